#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the stage that surfaces are shown on: a hollow ball with an opening, a sphere inside it, a base, a bent backdrop and
three lamps. usage: stage.py OUT.obj; its OUT.mtl is written next to it.

Materials: `shown` is that of the ball and its base, `inside` the sphere, `backdrop` the rest. All solids are closed, so that
glass refracts as it should; texture coordinates go round the vertical axis, whose upper pole lies in the opening."""

import math
import pathlib
import sys

OPEN = (0.22, math.sin(math.radians(57)), math.cos(math.radians(57)))  # where the opening faces, about
CENTRE = (0, 1.125, 0)
OUTER, INNER, CORE = 1.0, 0.88, 0.62
HALF = math.radians(43)  # half of the opening's angle


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def arc(centre, radius, first, last, steps, sign=1):
    """Points (distance from the axis, height) of an arc with their normals; angles count from the axis."""
    for k in range(steps + 1):
        a = first + (last - first) * k / steps
        n = (math.sin(a), math.cos(a))
        yield (centre[0] + radius * n[0], centre[1] + radius * n[1]), (sign * n[0], sign * n[1])


def lathe(name, material, profile, centre, axis, turns=160, repeat=2):
    """A closed profile turned about an axis through `centre`; faces look to the profile's normals."""
    axis = unit(axis)
    across = unit(cross(axis, (0.31, 0.2, 1)))
    along = cross(axis, across)
    profile = list(profile)
    lines = [f"o {name}", f"usemtl {material}", "s 1"]
    points = []
    for (r, h), (nr, nh) in profile:
        for k in range(turns):
            a = 2 * math.pi * k / turns
            side = [math.cos(a) * across[i] + math.sin(a) * along[i] for i in range(3)]
            point = [centre[i] + r * side[i] + h * axis[i] for i in range(3)]
            normal = [nr * side[i] + nh * axis[i] for i in range(3)]
            points.append(point)
            lines += ["v {:.6f} {:.6f} {:.6f}".format(*point), "vn {:.5f} {:.5f} {:.5f}".format(*normal)]
    count = len(points)

    def uv(i):
        x, y, z = (points[i][k] - CENTRE[k] for k in range(3))
        return math.atan2(x, z) / (2 * math.pi), 0.5 + math.asin(max(-1, min(1, y / max(1e-9, math.dist((x, y, z), (0, 0, 0)))))) / math.pi

    for row in range(len(profile) - 1):
        (r0, h0), n0 = profile[row]
        (r1, h1), n1 = profile[row + 1]
        # The side that the normal is on: front faces go round counter-clockwise.
        front = (h1 - h0) * (n0[0] + n1[0]) - (r1 - r0) * (n0[1] + n1[1]) < 0
        for k in range(turns):
            ring = [row * turns + k, row * turns + (k + 1) % turns, (row + 1) * turns + (k + 1) % turns, (row + 1) * turns + k]
            if not front:
                ring.reverse()
            uvs = [uv(i) for i in ring]
            u0 = uvs[0][0]
            lines += ["vt {:.5f} {:.5f}".format(repeat * (u - round(u - u0)), v) for u, v in uvs]
            lines.append("f " + " ".join(f"{i - count}/{j - 4}/{i - count}" for j, i in enumerate(ring)))
    return lines


def ball():
    """Outer side from below to the opening, a round rim, the inner side back."""
    rim, middle = (OUTER - INNER) / 2, (OUTER + INNER) / 2
    # The normals of the rim turn from outwards over the opening's edge to inwards.
    edge = (middle * math.sin(HALF), middle * math.cos(HALF))
    yield from arc((0, 0), OUTER, math.pi, HALF, 120)
    yield from arc(edge, rim, HALF, HALF - math.pi, 16)
    yield from arc((0, 0), INNER, HALF, math.pi, 120, -1)


def base():
    """A disc with a round edge and a groove, which the ball stands on."""
    yield (0, 0), (0, -1)
    yield (0.86, 0), (0, -1)
    yield from arc((0.86, 0.06), 0.06, math.pi, 0, 16)
    yield (0.74, 0.12), (0, 1)
    yield from arc((0.70, 0.12), 0.04, math.pi / 2, math.pi * 3 / 2, 12, -1)
    yield (0.66, 0.12), (0, 1)
    yield (0, 0.12), (0, 1)


def backdrop():
    """A floor that bends up into a wall, seen from +z."""
    rows, bend, far, wide = [(6.0, 0.0), (-3.0, 0.0)], 3.0, -3.0, 14.0
    rows += [(far - bend * math.sin(a), bend * (1 - math.cos(a))) for a in (math.pi / 2 * k / 24 for k in range(1, 25))]
    rows.append((far - bend, 9.0))
    lines = ["o backdrop", "usemtl backdrop", "s 1"]
    normals = [(0, 1, 0)] * 2 + [(0, math.cos(a), math.sin(a)) for a in (math.pi / 2 * k / 24 for k in range(1, 25))] + [(0, 0, 1)]
    for (z, y), n in zip(rows, normals):
        for x in (-wide, wide):
            lines += [f"v {x} {y:.5f} {z:.5f}", "vn {:.5f} {:.5f} {:.5f}".format(*n)]
    count = 2 * len(rows)
    for k in range(len(rows) - 1):
        ring = [2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2]
        lines.append("f " + " ".join(f"{i - count}//{i - count}" for i in ring))
    return lines


def lamp(name, centre, width, height, target=(0, 1, 0)):
    forward = unit([target[k] - centre[k] for k in range(3)])
    across = unit(cross(forward, (0.01, 1, 0.02)))
    along = cross(forward, across)
    lines = [f"o {name}", f"usemtl {name}"]
    for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        lines.append("v " + " ".join(str(centre[k] + s * width / 2 * across[k] + t * height / 2 * along[k]) for k in range(3)))
    return lines + ["f -4 -3 -2 -1"]


def main():
    out = pathlib.Path(sys.argv[1])
    lines = [f"mtllib {out.stem}.mtl"]
    lines += lathe("ball", "shown", ball(), CENTRE, OPEN)
    lines += lathe("sphere", "inside", arc((0, 0), CORE, math.pi, 0, 90), CENTRE, (0, 1, 0))
    lines += lathe("base", "shown", base(), (0, 0, 0), (0, 1, 0))
    lines += backdrop()
    lines += lamp("key", (-3.4, 4.2, 3.2), 2.2, 2.2)
    lines += lamp("rim", (3.6, 3.4, -1.2), 1.2, 2.6)
    lines += lamp("fill", (4.2, 2.0, 4.2), 2.4, 2.4)
    out.write_text("\n".join(lines) + "\n")
    materials = dict(shown="Kd 0.6 0.6 0.6", inside="Kd 0.32 0.32 0.33\nPm 0\nPr 0.4", backdrop="Kd 0.5 0.5 0.51",
                     key="Kd 0 0 0\nKe 16 14.6 13", rim="Kd 0 0 0\nKe 11 12 14", fill="Kd 0 0 0\nKe 2.2 2.4 2.7")
    out.with_suffix(".mtl").write_text("".join(f"newmtl {name}\n{values}\n" for name, values in materials.items()))


if __name__ == "__main__":
    main()
