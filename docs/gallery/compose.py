#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the gallery's scenes out of well-known meshes: puts scans on a floor under lamps.

usage: compose.py SCENES OUT    SCENES holds the folders bunny, dragon, ... ; OUT gets one OBJ with its MTL per scene
Needs nothing but Python; gnurt must be on the PATH, it turns PLY into OBJ."""

import pathlib
import subprocess
import sys


def quad(name, material, corners):
    """A quad whose front is where its corners go round counter-clockwise; indices from the end of the list."""
    lines = [f"o {name}", f"usemtl {material}"]
    lines += ["v {} {} {}".format(*corner) for corner in corners]
    return lines + ["f -4 -3 -2 -1"]


def lamp(material, centre, target, width, height):
    """A lamp that shines towards a point."""

    def unit(v):
        length = sum(x * x for x in v) ** 0.5
        return [x / length for x in v]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    forward = unit([target[k] - centre[k] for k in range(3)])
    across = unit(cross(forward, (0.1, 1, 0.2)))
    along = cross(forward, across)

    def corner(s, t):
        return [centre[k] + s * width / 2 * across[k] + t * height / 2 * along[k] for k in range(3)]

    return quad(material, material, [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)])


def material(name, **values):
    lines = [f"newmtl {name}"]
    for key, value in values.items():
        lines.append(f"{key} " + (" ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)))
    return lines


def body(scenes, out, name, material_name):
    """The triangles of a scan, all of one material."""
    obj = out / f"{name}-mesh.obj"
    subprocess.run(["gnurt", "convert", "-q", scenes / name / f"{name}.ply", obj], check=True)
    kept = ("v ", "vn ", "vt ", "f ")
    lines = [line for line in obj.read_text().splitlines() if line.startswith(kept)]
    obj.unlink()
    obj.with_suffix(".mtl").unlink(missing_ok=True)
    return [f"o {name}", f"usemtl {material_name}"] + lines


def write(out, name, objects, materials):
    (out / f"{name}.mtl").write_text("\n".join(sum(materials, [])) + "\n")
    text = "\n".join([f"mtllib {name}.mtl"] + sum(objects, [])) + "\n"
    (out / f"{name}.obj").write_text(text)


def studio(scenes, out, name, height, size, scan, floor=(0.45, 0.45, 0.45)):
    """A scan on a floor in front of a wall, lit by a warm lamp from the left, a cool one from the right and one above.
    `height` is that of the floor, `size` the size of the scan."""
    s = size
    far = 12 * s
    objects = [
        body(scenes, out, name, "scan"),
        quad("floor", "floor", [(-far, height, far), (far, height, far), (far, height, -far), (-far, height, -far)]),
        quad("wall", "floor", [(-far, height, -3 * s), (far, height, -3 * s), (far, far, -3 * s), (-far, far, -3 * s)]),
        lamp("warm", (-2.5 * s, height + 2.5 * s, 2 * s), (0, height + s / 2, 0), 1.2 * s, 1.2 * s),
        lamp("cool", (3 * s, height + 2 * s, s), (0, height + s / 2, 0), 1.8 * s, 1.8 * s),
        lamp("above", (0, height + 4 * s, 0), (0, height, 0), 3 * s, 3 * s),
    ]
    materials = [
        material("scan", **scan),
        material("floor", Kd=floor),
        material("warm", Kd=(0, 0, 0), Ke=(28, 20, 11)),
        material("cool", Kd=(0, 0, 0), Ke=(5, 8, 13)),
        material("above", Kd=(0, 0, 0), Ke=(1.2, 1.3, 1.5)),
    ]
    write(out, name, objects, materials)


def main():
    scenes, out = map(pathlib.Path, sys.argv[1:3])
    out.mkdir(parents=True, exist_ok=True)
    glass = dict(Kd=(0, 0, 0), Ks=(1, 1, 1), Tf=(0.95, 1.0, 0.97), Ni=1.5, Ns=1000, d=0.1, illum=7)
    studio(scenes, out, "bunny", 0.033, 0.15, dict(Kd=(0.75, 0.45, 0.3)))
    studio(scenes, out, "dragon", 0.0529, 0.18, dict(Kd=(1.0, 0.71, 0.29), Pm=1, Pr=0.25))
    studio(scenes, out, "buddha-100k", -1.002, 1.9, dict(Kd=(0.35, 0.7, 0.5), Pm=0, Pr=0.15))
    studio(scenes, out, "armadillo", -0.573, 1.0, glass)


if __name__ == "__main__":
    main()
