# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes four locks of hair as a file of pbrt-v4: hair.py OUT.pbrt

Each lock has 26,000 strands, B-splines of twelve vertices, that hang in waves and in clumps. Hair is coloured by its two pigments: from left
to right little of both, red, brown and black.
"""
import math
import random
import sys

STRANDS, VERTICES, CLUMPS, LENGTH = 26000, 12, 110, 1.85
# Eumelanin, pheomelanin, waves along a lock, their size.
LOCKS = [(0.22, 0.1, 1.0, 0.035), (0.35, 1.4, 2.6, 0.05), (1.5, 0.3, 0.25, 0.02), (7.0, 0.0, 4.2, 0.055)]


def strand(root, clump, middle, waves, size, own):
    """The vertices of a strand from its root, drawn towards its clump and the middle of its lock on the way down."""
    (x, z), (cx, cz, phase, length) = root, clump
    for k in range(VERTICES):
        along = k / (VERTICES - 1)
        pull = 0.8 * along**0.8
        turn = math.tau * waves * along + phase + own[0]
        swing = size * min(1, 3 * along) * (1 + own[1])
        yield (
            x + (cx + (middle - cx) * 0.3 * along - x) * pull + swing * math.cos(turn) + own[2] * along,
            1 - LENGTH * length * own[4] * along,
            z + (cz - z) * pull + 0.7 * swing * math.sin(turn) + own[3] * along,
        )


def main():
    chance = random.Random(1)
    with open(sys.argv[1], "w") as out:
        out.write("LookAt 0 0.2 5.6  0 0.12 0  0 1 0\nCamera \"perspective\" \"float fov\" 24\nWorldBegin\n")
        out.write('LightSource "infinite" "rgb L" [0.22 0.25 0.3]\n')
        for (low, high), depth, radiance in [((1.4, 3.2), 3.2, 16), ((-3.0, -1.2), -2.2, 40)]:
            corners = [(low, 2.2, depth), (high, 2.2, depth), (high, 3.6, depth), (low, 3.6, depth)]
            order = "0 2 1 0 3 2" if depth > 0 else "0 1 2 0 2 3"
            numbers = " ".join(f"{x} {y} {z}" for x, y, z in corners)
            out.write(f'AttributeBegin\nAreaLightSource "diffuse" "rgb L" [{radiance} {radiance * 0.95} {radiance * 0.85}]\n')
            out.write(f'Shape "trianglemesh" "integer indices" [{order}] "point3 P" [{numbers}]\nAttributeEnd\n')
        out.write('Material "diffuse" "rgb reflectance" [0.16 0.17 0.19]\n')
        out.write('Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 -4 -4 9 -4 -4 9 6 -4 -9 6 -4]\n')
        out.write('Material "diffuse" "rgb reflectance" [0.05 0.035 0.025]\n')
        for face in ["0 1 2 0 2 3", "4 6 5 4 7 6", "0 4 5 0 5 1", "3 2 6 3 6 7"]:
            corners = [(x, y, z) for z in (0.13, -0.13) for x, y in [(-1.9, 0.96), (1.9, 0.96), (1.9, 1.08), (-1.9, 1.08)]]
            numbers = " ".join(f"{x} {y} {z}" for x, y, z in corners)
            out.write(f'Shape "trianglemesh" "integer indices" [{face}] "point3 P" [{numbers}]\n')
        for n, (eumelanin, pheomelanin, waves, size) in enumerate(LOCKS):
            out.write(f'Material "hair" "float eumelanin" {eumelanin} "float pheomelanin" {pheomelanin} "float beta_m" 0.25 "float beta_n" 0.3\n')
            middle = (1.5 - n) * 0.9
            place = lambda: (middle + chance.uniform(-0.33, 0.33), chance.uniform(-0.1, 0.1))
            clumps = [(*place(), chance.gauss(0, 0.5), chance.uniform(0.93, 1.0)) for _ in range(CLUMPS)]
            for _ in range(STRANDS):
                root = place()
                near = min(clumps, key=lambda clump: (clump[0] - root[0]) ** 2 + 4 * (clump[1] - root[1]) ** 2)
                own = (chance.gauss(0, 0.25), chance.gauss(0, 0.15), chance.gauss(0, 0.018), chance.gauss(0, 0.018), 1 - 0.25 * chance.random() ** 3)
                vertices = " ".join(f"{x:.4f} {y:.4f} {z:.4f}" for x, y, z in strand(root, near, middle, waves, size, own))
                out.write(f'Shape "curve" "string type" "cylinder" "string basis" "bspline" "point3 P" [{vertices}] "float width0" 0.0032 "float width1" 0.0012\n')


if __name__ == "__main__":
    main()
