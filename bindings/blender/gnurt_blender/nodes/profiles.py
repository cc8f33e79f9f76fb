# SPDX-License-Identifier: GPL-3.0-or-later
"""IES profiles of lights: the light that a luminaire gives off by direction, as a picture of angles.

Source: IESNA LM-63. Angles go from the light's -z, and around it from its -y over -x. Blender's factor is the candelas times 4 pi / 177.83.
"""

import math
import re

import bpy
import numpy as np

from .tree import node, triple

LUMENS_PER_WATT = 177.83


class Profile:
    """Candelas by vertical and horizontal angles in degrees."""

    def __init__(self, text):
        found = re.search(r"^\s*TILT\s*=\s*(\S+).*$", text, re.M)
        if not found:
            raise ValueError("there is no TILT line")
        numbers = [float(x) for x in re.split(r"[\s,]+", text[found.end() :].strip()) if x]
        if found.group(1).upper() == "INCLUDE":
            numbers = numbers[2 + 2 * int(numbers[1]) :] if len(numbers) > 1 else []
        if len(numbers) < 13:
            raise ValueError("it is too short")
        nv, nh, self.kind = (int(x) for x in numbers[3:6])
        factor = numbers[2] * numbers[10] * numbers[11]
        self.vertical, self.horizontal = np.array(numbers[13 : 13 + nv]), np.array(numbers[13 + nv : 13 + nv + nh])
        values = numbers[13 + nv + nh : 13 + nv + nh + nv * nh]
        if nv < 1 or nh < 1 or len(values) != nv * nh:
            raise ValueError(f"it has {len(values)} values for {nv} x {nh} angles")
        self.candelas = np.array(values).reshape(nh, nv) * factor

    def picture(self):
        """All directions, a degree each: (181, 361), vertical angles down, horizontal ones to the right."""
        v, h = np.arange(181.0), np.arange(361.0)
        last = self.horizontal[-1]
        if len(self.horizontal) == 1:
            h[:] = self.horizontal[0]
        elif last == 90:
            h = np.where(h > 180, 360 - h, h)
            h = np.where(h > 90, 180 - h, h)
        elif last == 180:
            h = np.where(h > 180, 360 - h, h)
        inside = (v >= self.vertical[0]) & (v <= self.vertical[-1])
        rows = np.where(inside, cubic(v, self.vertical, self.candelas, "reflect"), 0.0)
        return np.maximum(cubic(h, self.horizontal, rows.T, "wrap" if last == 360 else "reflect"), 0.0)


def cubic(at, knots, rows, beyond):
    """Rows of values at knots, interpolated by the splines of Catmull and Rom as Cycles does; `beyond` the ends they are reflected or go round."""
    if len(knots) == 1:
        return np.repeat(rows, len(at), axis=1)
    padded = np.concatenate([rows[:, 1:2], rows, rows[:, -2:-1]], axis=1)
    if beyond == "wrap":
        padded[:, 0], padded[:, -1] = rows[:, -2], rows[:, 1]
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
    except (OSError, ValueError, OverflowError) as error:
        p.warn(f"the profile is not shown: {error}")
        return {"Fac": ("float", "0.0")}
    if found.kind != 1:
        p.warn("the profile's angles are shown as those of type C")
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
