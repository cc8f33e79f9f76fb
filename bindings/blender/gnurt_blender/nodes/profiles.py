# SPDX-License-Identifier: GPL-3.0-or-later
"""IES profiles of lights: the light that a luminaire gives off by direction, as a picture of angles.

Source: IESNA LM-63; types and ends of angles as in Cycles 5.0. Angles go from the light's -z, and around it from its -y over -x. Blender's factor is the candelas times 4 pi / 177.83.
"""

import math
import re

import bpy
import numpy as np

from .tree import node, triple

LUMENS_PER_WATT = 177.83


class Profile:
    """Candelas by vertical and horizontal angles in degrees, in the frame of type C."""

    def __init__(self, text):
        found = re.search(r"^\s*TILT\s*=\s*(\S+).*$", text, re.M)
        if not found:
            raise ValueError("there is no TILT line")
        numbers = leading_numbers(text[found.end() :])
        if not np.isfinite(numbers).all():
            raise ValueError("some of its numbers are not finite")
        if found.group(1).upper() == "INCLUDE":
            numbers = numbers[2 + 2 * int(numbers[1]) :] if len(numbers) > 1 else []
        if len(numbers) < 13:
            raise ValueError("it is too short")
        nv, nh, kind = (int(x) for x in numbers[3:6])
        factor = numbers[2] * numbers[10] * numbers[11]
        vertical, horizontal = np.array(numbers[13 : 13 + nv]), np.array(numbers[13 + nv : 13 + nv + nh])
        values = numbers[13 + nv + nh : 13 + nv + nh + nv * nh]
        if nv < 1 or nh < 1 or len(values) != nv * nh:
            raise ValueError(f"it has {len(values)} values for {nv} x {nh} angles")
        if any((np.diff(angles) < 0).any() for angles in (vertical, horizontal)):
            raise ValueError("its angles do not ascend")
        if kind not in KINDS:
            raise ValueError(f"its type is {kind}, not 1, 2 or 3")
        self.vertical, self.horizontal, self.candelas = KINDS[kind](vertical, horizontal, np.array(values).reshape(nh, nv) * factor)

    def picture(self):
        """All directions, a degree each: (181, 361), vertical angles down, horizontal ones to the right; dark where the profile has no angles."""
        v, h = np.arange(181.0), np.arange(361.0)
        # At the pole below the light the spline goes on to the other side; elsewhere the end is repeated.
        below = 1 if self.vertical[0] == 0 and len(self.vertical) > 1 else 0
        rows = cubic(v, self.vertical, self.candelas, (below, -1))
        # Cycles takes the neighbours of the first and the last cell from these cells themselves, and so do we, though a full turn has
        # others.
        found = np.maximum(cubic(h, self.horizontal, rows.T, (0, -2)), 0.0)
        return found * np.outer(within(v, self.vertical), within(h, self.horizontal))


def leading_numbers(text):
    """The numbers up to the first other word: some files end with the character 0x1A."""
    numbers = []
    for word in re.findall(r"[^\s,]+", text):
        try:
            numbers.append(float(word))
        except ValueError:
            break
    return numbers


def within(at, knots):
    """The share of each texel that lies between the first and the last knot; where `at` ends, there is no edge."""
    low = np.clip(at - knots[0] + 0.5, 0.0, 1.0) if knots[0] > at[0] else 1.0
    high = np.clip(knots[-1] - at + 0.5, 0.0, 1.0) if knots[-1] < at[-1] else 1.0
    return low * high * np.ones_like(at)


def as_type_c(vertical, horizontal, candelas):
    """Horizontal angles of a full turn, from those of a quarter, a half, or a turn without its end."""
    if horizontal[0] == 90:
        horizontal = horizontal - 90
    if len(horizontal) == 1:
        return vertical, np.array([0.0, 360.0]), np.concatenate([candelas, candelas])
    for last in (90, 180):
        if horizontal[-1] == last:
            horizontal = np.concatenate([horizontal, 2 * last - horizontal[-2::-1]])
            candelas = np.concatenate([candelas, candelas[-2::-1]])
    steps = np.diff(horizontal)
    if horizontal[0] == 0 and horizontal[-1] < 360 and np.isclose([steps[0], steps[-1]], 360 - horizontal[-1], atol=1e-4).any():
        horizontal, candelas = np.append(horizontal, 360.0), np.concatenate([candelas, candelas[:1]])
    return vertical, horizontal, candelas


def as_type_b(vertical, horizontal, candelas):
    """The poles of type B lie at the sides: vertical and horizontal angles are swapped, and the user turns the light, as in Cycles."""
    around, rows = mirrored(vertical, candelas.T)
    down, columns = mirrored(horizontal, rows.T)
    return down, around, columns.T


def as_type_a(vertical, horizontal, candelas):
    """Horizontal angles from -90 to 90, which go around in the opposite direction to those of type C."""
    if horizontal[0] == 0:
        around, rows = mirrored(horizontal, candelas)
        return vertical + 90, around + 90, rows
    return vertical + 90, 180 - horizontal[::-1], candelas[::-1]


def mirrored(angles, rows):
    """Angles from -90 to 90 as those from 0 to 180; rows from 0 on stand for both sides."""
    if angles[0] != 0:
        return angles + 90, rows
    return np.concatenate([90 - angles[:0:-1], 90 + angles]), np.concatenate([rows[:0:-1], rows])


# By the number in a file.
KINDS = {1: as_type_c, 2: as_type_b, 3: as_type_a}


def cubic(at, knots, rows, beyond):
    """Rows of values at knots, interpolated by the splines of Catmull and Rom; `beyond` the ends stand the values of two knots."""
    if len(knots) == 1:
        return np.repeat(rows, len(at), axis=1)
    first, last = beyond
    padded = np.concatenate([rows[:, [first]], rows, rows[:, [last]]], axis=1)
    cell = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    t = np.clip((at - knots[cell]) / np.maximum(knots[cell + 1] - knots[cell], 1e-9), 0.0, 1.0)
    a, b, c, d = (padded[:, cell + k] for k in range(4))
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))


def text_of(p):
    """The text of a profile inside Blender's file or beside it."""
    if p.mode == "INTERNAL":
        return p.ies.as_string() if p.ies else ""
    with open(bpy.path.abspath(p.filepath), encoding="latin-1") as file:
        return file.read()


@node("TEX_IES")
def profile(p):
    code = p.code
    try:
        found = Profile(text_of(p))
    except (OSError, ValueError) as error:
        p.warn(f"the profile is not shown: {error}")
        return {"Fac": ("float", "0.0")}
    picture = found.picture() * (4 * math.pi / LUMENS_PER_WATT)
    number = code.host.export.scene.add_texture(picture.astype(np.float32)[..., None], name=p.node.name, colorspace="linear")
    name = f"profile{number}"
    code.textures[name] = number
    if p.is_linked("Vector"):
        d = p.var("vector", f"normalize({p.v('Vector')})")
    else:
        turn = np.array(code.host.object.matrix_world)[:3, :3]
        turn = turn / np.linalg.norm(turn, axis=0)
        seen = p.var("vector", "normalize(vector(-I))")
        d = p.var("vector", "vector(" + ", ".join(f"dot({seen}, {triple('vector', turn[:, k])})" for k in range(3)) + ")")
    # The middles of the first and the last texel are the ends of the angles.
    down = p.var("float", f"(acos(clamp(-{d}[2], -1.0, 1.0)) * {180 / math.pi!r} + 0.5) / 181.0")
    turn = p.var("float", f"atan2(-{d}[0], -{d}[1]) * {180 / math.pi!r}")
    across = p.var("float", f"(({turn} < 0.0 ? {turn} + 360.0 : {turn}) + 0.5) / 361.0")
    read = p.var("color", f'texture("{name}", {across}, {down}, 0.0, 0.0, 0.0, 0.0, "wrap", "clamp", "interp", "linear")')
    return {"Fac": ("float", f"{read}[0] * {p.f('Strength')}")}
