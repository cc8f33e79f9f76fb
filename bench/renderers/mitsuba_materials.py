# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows one thing in a room, of several materials, by Mitsuba 3 and by gnurt, and compares the pictures' means.

    python3 mitsuba_materials.py GNURT [--spp 256] [--batches 8] [--variant llvm_ad_rgb] [MATERIAL ...]

The thing is a ball of flat triangles, so that no shading normals are in play. The models are the same but for what the
table says. Standard errors are those of the batches. Needs `pip install mitsuba numpy`. Source: original.
"""
import argparse
import os
import subprocess
import tempfile

import mitsuba as mi
import numpy as np

import interiors

SIZE, DEPTH = 96, 12
CAMERA = ((0, 1, 0.95), (0, 0.9, -1), (0, 1, 0), 75, SIZE, SIZE)
metal = lambda alpha: {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": alpha}
pbr = lambda alpha: f"Kd 1 1 1\nPm 1\nPr {alpha ** 0.5}\n"
# Name: lines of MTL, Mitsuba's BSDF, what differs.
MATERIALS = {
    "matte": ("Kd 0.7 0.5 0.3\n", {"type": "twosided", "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.5, 0.3]}}}, "nothing"),
    "mirror": ("Kd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\n", {"type": "twosided", "nested": {"type": "conductor", "material": "none", "specular_reflectance": {"type": "rgb", "value": 0.9}}}, "nothing"),
    "glass": ("Kd 0 0 0\nillum 7\nNi 1.5\n", {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}, "nothing"),
    "metal 0.02": (pbr(0.02), {"type": "twosided", "nested": metal(0.02)}, "shadowing; light between facets"),
    "metal 0.05": (pbr(0.05), {"type": "twosided", "nested": metal(0.05)}, "shadowing; light between facets"),
    "metal 0.1": (pbr(0.1), {"type": "twosided", "nested": metal(0.1)}, "shadowing; light between facets"),
    "metal 0.3": (pbr(0.3), {"type": "twosided", "nested": metal(0.3)}, "shadowing; light between facets"),
}
LAMP = (4.0, 3.5, 3.0)


def ball(centre, radius, times=2):
    """A sphere as triangles, counter-clockwise seen from outside: (n, 3, 3)."""
    g = (1 + 5**0.5) / 2
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    unit = lambda v: v / np.linalg.norm(v)
    triangles = [[unit(np.array(corners[i], float)) for i in face] for face in faces]
    for _ in range(times):
        cut = []
        for a, b, c in triangles:
            ab, bc, ca = unit(a + b), unit(b + c), unit(c + a)
            cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = cut
    return np.array(triangles) * radius + np.array(centre)


def quad(a, b, c, d):
    return np.array([[a, b, c], [a, c, d]], float)


def write_room(folder, lines):
    """A room of 2 x 2 x 2 with coloured walls and a lamp; its corners go round counter-clockwise seen from inside."""
    p = lambda x, y, z: (x, y, z)
    parts = [
        ("floor", "Kd 0.6 0.6 0.6\n", quad(p(-1, 0, 1), p(1, 0, 1), p(1, 0, -1), p(-1, 0, -1))),
        ("ceiling", "Kd 0.7 0.7 0.7\n", quad(p(-1, 2, -1), p(1, 2, -1), p(1, 2, 1), p(-1, 2, 1))),
        ("back", "Kd 0.5 0.6 0.7\n", quad(p(-1, 0, -1), p(1, 0, -1), p(1, 2, -1), p(-1, 2, -1))),
        ("front", "Kd 0.5 0.5 0.5\n", quad(p(1, 0, 1), p(-1, 0, 1), p(-1, 2, 1), p(1, 2, 1))),
        ("left", "Kd 0.7 0.2 0.1\n", quad(p(-1, 0, 1), p(-1, 0, -1), p(-1, 2, -1), p(-1, 2, 1))),
        ("right", "Kd 0.1 0.6 0.2\n", quad(p(1, 0, -1), p(1, 0, 1), p(1, 2, 1), p(1, 2, -1))),
        ("lamp", "Kd 0 0 0\nKe %g %g %g\n" % LAMP, quad(p(-0.8, 1.98, -0.8), p(0.8, 1.98, -0.8), p(0.8, 1.98, 0.8), p(-0.8, 1.98, 0.8))),
        ("thing", lines, ball((0, 0.75, -0.3), 0.5)),
    ]
    os.makedirs(os.path.join(folder, "room"))
    base = os.path.join(folder, "room", "room")
    with open(base + ".mtl", "w") as mtl, open(base + ".obj", "w") as obj:
        obj.write("mtllib room.mtl\n")
        for name, material, triangles in parts:
            mtl.write(f"newmtl {name}\n{material}\n")
            obj.write(f"usemtl {name}\n")
            for triangle in triangles:
                obj.writelines("v %.9g %.9g %.9g\n" % tuple(corner) for corner in triangle)
                obj.write("f -3 -2 -1\n")
    return base + ".obj"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("gnurt")
    parser.add_argument("only", nargs="*")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--batches", type=int, default=8)
    arguments = parser.parse_intermixed_args()
    mi.set_variant(arguments.variant)
    from mitsuba_path import load_scene

    interiors.CAMERAS["room"] = CAMERA
    print("| material | what differs | whole picture: gnurt / Mitsuba - 1, % | standard error, % | the thing alone, % | standard error, % |")
    print("|---|---|---|---|---|---|")
    for name in arguments.only or MATERIALS:
        lines, bsdf, differs = MATERIALS[name]
        with tempfile.TemporaryDirectory() as folder:
            path = write_room(folder, lines)
            scene = load_scene(interiors.read(folder, "room"), CAMERA, folder, {"thing": bsdf}, DEPTH)
            own, theirs = [], []
            for seed in range(arguments.batches):
                output = os.path.join(folder, "own.pfm")
                words = [arguments.gnurt, "render", path, *interiors.gnurt_arguments("room"), "--integrator=path", f"--max-depth={DEPTH}"]
                words += [f"--spp={arguments.spp}", f"--seed={seed}", "-q", "-o", output]
                subprocess.run(words, check=True)
                own.append(np.array(mi.Bitmap(output)).astype(float)[..., :3])
                theirs.append(mi.render(scene, spp=arguments.spp, seed=seed).numpy().astype(float))
        # Where the ball is seen, by its distance from the line of sight.
        y, x = np.mgrid[0:SIZE, 0:SIZE]
        eye, target = np.array(CAMERA[0]), np.array(CAMERA[1])
        forward = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(forward, [0, 1, 0])
        right /= np.linalg.norm(right)
        up, scale = np.cross(right, forward), np.tan(np.radians(CAMERA[3] / 2)) * 2 / SIZE
        d = forward + (x + 0.5 - SIZE / 2)[..., None] * scale * right - (y + 0.5 - SIZE / 2)[..., None] * scale * up
        d /= np.linalg.norm(d, axis=-1, keepdims=True)
        to = np.array((0, 0.75, -0.3)) - eye
        thing = np.linalg.norm(to - (d @ to)[..., None] * d, axis=-1) < 0.49

        row = [name, differs]
        for mask in (np.ones_like(thing), thing):
            a, b = (np.array([picture[mask].mean() for picture in batch]) for batch in (own, theirs))
            error = np.hypot(*(v.std(ddof=1) / len(v) ** 0.5 / v.mean() for v in (a, b)))
            row += [f"{(a.mean() / b.mean() - 1) * 100:+.3f}", f"{error * 100:.3f}"]
        print("| " + " | ".join(row) + " |", flush=True)


main()
