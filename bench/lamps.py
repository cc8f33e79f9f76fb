# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a hall of 600 small lamps between partitions and boxes: python bench/lamps.py hall.obj

Metres, y up, 40 x 4 x 30. Lamps face down; each place sees a part of them.
View of the records: --eye 3,3.7,27 --target 20,0.3,12 --up 0,1,0 --fov 65
"""

import pathlib
import random
import sys

WIDTH, DEPTH, HEIGHT = 40, 30, 4
LAMPS, BOXES, COLOURS = 600, 260, 12
MATTE = {
    "floor": (0.5, 0.47, 0.42),
    "wall": (0.7, 0.7, 0.68),
    "wall2": (0.65, 0.55, 0.45),
    "boxa": (0.3, 0.4, 0.6),
    "boxb": (0.7, 0.3, 0.2),
    "boxc": (0.4, 0.6, 0.3),
}


class Mesh:
    """Quads by material; corners counterclockwise as seen from their front."""

    def __init__(self):
        self.points, self.quads = [], {}

    def quad(self, material, *corners):
        first = len(self.points) + 1
        self.points += corners
        self.quads.setdefault(material, []).append(range(first, first + 4))

    def box(self, material, x0, y0, z0, x1, y1, z1):
        self.quad(material, (x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0))
        self.quad(material, (x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1))
        self.quad(material, (x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0))
        self.quad(material, (x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1))
        self.quad(material, (x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0))
        self.quad(material, (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1))


def hall():
    """The mesh."""
    rng, mesh = random.Random(5), Mesh()
    w, d, h = WIDTH, DEPTH, HEIGHT
    mesh.quad("floor", (0, 0, 0), (0, 0, d), (w, 0, d), (w, 0, 0))
    mesh.quad("wall", (0, h, 0), (w, h, 0), (w, h, d), (0, h, d))
    mesh.quad("wall", (0, 0, 0), (w, 0, 0), (w, h, 0), (0, h, 0))
    mesh.quad("wall", (0, 0, d), (0, h, d), (w, h, d), (w, 0, d))
    mesh.quad("wall", (0, 0, 0), (0, h, 0), (0, h, d), (0, 0, d))
    mesh.quad("wall", (w, 0, 0), (w, 0, d), (w, h, d), (w, h, 0))
    for x in range(5, w, 5):
        for z in range(0, d, 5):
            if rng.random() < 0.55:
                mesh.box("wall", x - 0.05, 0, z + 0.2, x + 0.05, rng.choice([1.6, 2.4, h]), z + 4.2)
            if rng.random() < 0.45:
                mesh.box("wall2", x + 0.2, 0, z - 0.05, x + 4.2, rng.choice([1.6, 2.4, h]), z + 0.05)
    for _ in range(BOXES):
        x, z = rng.uniform(0.5, w - 0.5), rng.uniform(0.5, d - 0.5)
        s, top = rng.uniform(0.15, 0.5), rng.uniform(0.3, 1.3)
        mesh.box(rng.choice(["boxa", "boxb", "boxc"]), x - s, 0, z - s, x + s, top, z + s)
    for number in range(LAMPS):
        x, z, s = rng.uniform(0.3, w - 0.3), rng.uniform(0.3, d - 0.3), 0.06
        y = rng.choice([3.6, 2.9, 2.2, 3.2])
        corners = (x - s, y, z - s), (x + s, y, z - s), (x + s, y, z + s), (x - s, y, z + s)
        mesh.quad(f"lamp{number % COLOURS}", *corners)
        if y < 3.5:
            mesh.box("boxa", x - 0.1, y + 0.01, z - 0.1, x + 0.1, y + 0.05, z + 0.1)
    return mesh


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    path, mesh = pathlib.Path(sys.argv[1]), hall()
    library = path.with_suffix(".mtl")
    with path.open("w", encoding="utf-8") as out:
        out.write(f"mtllib {library.name}\n")
        out.writelines("v %g %g %g\n" % point for point in mesh.points)
        for material, quads in mesh.quads.items():
            out.write(f"usemtl {material}\n")
            out.writelines("f %d %d %d %d\n" % tuple(quad) for quad in quads)
    with library.open("w", encoding="utf-8") as out:
        for name, colour in MATTE.items():
            out.write("newmtl %s\nKd %g %g %g\nillum 1\n" % (name, *colour))
        for number in range(COLOURS):
            rng = random.Random(number)
            colour = [rng.uniform(0.4, 1) * rng.choice([60, 120, 240]) for _ in range(3)]
            out.write("newmtl lamp%d\nKd 0 0 0\nKe %g %g %g\n" % (number, *colour))


if __name__ == "__main__":
    main()
