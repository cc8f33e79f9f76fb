# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and curves as the package takes them: points and radii, strand by strand, in arrays of all strands.

Space: that of the points. Tests: `tests/checks.py`, beside a loop over strands.
"""

from itertools import chain

import numpy as np

from . import hashes, meshes


class Strands:
    """Strands that go through all of their points: vertices (n, 3), radii (n,), and how many vertices each strand has.

    Made from points (m, 3), radii (m,), and how many points each strand has; strands of fewer than two points are left out.
    The first and the last point are there twice: a Catmull-Rom curve goes from its second vertex to the last but one.
    """

    def __init__(self, points, radii, counts, normals=None):
        counts = np.asarray(counts, np.int64)
        kept = counts > 1
        points, radii = np.asarray(points, np.float32), np.asarray(radii, np.float32)
        if not kept.all():
            rows = np.repeat(kept, counts)
            points, radii, counts = points[rows], radii[rows], counts[kept]
        self.points, self.thickness, self.lengths = points, radii, counts
        # What reads normals of the points given, (m, 3), and which of them are used.
        self.normals, self.used = normals, slice(None) if kept.all() else rows
        # How often each point is there.
        self.times = np.ones(len(points), np.int64)
        ends = np.cumsum(counts)
        self.times[ends - counts] = 2
        self.times[ends - 1] = 2

    def __bool__(self):
        return len(self.lengths) > 0

    @property
    def counts(self):
        return (self.lengths + 2).tolist()

    @property
    def vertices(self):
        return np.repeat(self.points, self.times, axis=0)

    @property
    def radii(self):
        return np.repeat(self.thickness, self.times)

    def _of_strands(self, values):
        """A number of each strand, at its vertices."""
        return np.repeat(values.astype(np.float32), self.lengths + 2)

    def value(self, name):
        """What the node Hair Info gives, by vertex; None for what is not known."""
        if name == "Is Strand":
            return np.ones(self.times.sum(), np.float32)
        if name == "Intercept":
            along = lengths(self.points, self.lengths)
            whole = along[np.cumsum(self.lengths) - 1]
            return np.repeat((along / np.repeat(np.maximum(whole, 1e-20), self.lengths)).astype(np.float32), self.times)
        if name == "Length":
            return self._of_strands(lengths(self.points, self.lengths)[np.cumsum(self.lengths) - 1])
        if name == "Thickness":
            return 2 * self.radii
        if name == "Random":
            return self._of_strands(hashes.of_number(np.arange(len(self.lengths), dtype=np.uint64)))
        if name == "Normal" and self.normals is not None:
            return np.repeat(self.normals()[self.used], self.times, axis=0)
        return None


def lengths(points, counts):
    """How far along their strands points are, in float64: sums of float32 from root to tip."""
    steps = np.zeros(len(points), np.float32)
    steps[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1)
    firsts = np.cumsum(counts) - counts
    steps[firsts] = 0
    along = np.empty(len(points))
    # Strands of one length are rows of a table, and there are few lengths.
    for count in np.unique(counts):
        rows = firsts[counts == count, None] + np.arange(count)
        along[rows] = np.cumsum(steps[rows], axis=1)
    return along


def of_curves(curves):
    """Points and radii of a hair curves data-block."""
    positions = np.empty(len(curves.points) * 3, np.float32)
    curves.points.foreach_get("position", positions)
    positions = positions.reshape(-1, 3)
    radii = np.full(len(positions), 0.005, np.float32)
    found = curves.attributes.get("radius")
    if found is not None:
        found.data.foreach_get("value", radii)
    if not len(curves.curves):
        return Strands(positions, radii, [])
    # Where each curve begins, and where the last one ends.
    offsets = np.empty(len(curves.curve_offset_data), np.int32)
    curves.curve_offset_data.foreach_get("value", offsets)
    return Strands(positions, radii, np.diff(offsets), lambda: normals_of(curves))


def normals_of(curves):
    """Normals of all points, (n, 3).

    Blender makes them for an iteration and frees them at its end: `foreach_get` reads them after that, and so would a vector that is kept.
    """
    numbers = chain.from_iterable(item.vector[:] for item in curves.normals)
    return np.fromiter(numbers, np.float32, count=3 * len(curves.points)).reshape(-1, 3)


def of_particles(evaluated, system, matrix):
    """Points and radii of a hair system, in the space of the object."""
    settings = system.settings
    steps = 2 ** settings.render_step
    inverse = np.linalg.inv(np.array(matrix))
    children = len(system.child_particles)
    parents = len(system.particles)
    numbers = range(parents, parents + children) if children and settings.child_type != "NONE" else range(parents)
    if children and settings.use_parent_particles:
        numbers = range(parents + children)
    # Blender has no call for all points at once.
    found = (system.co_hair(evaluated, particle_no=number, step=step) for number in numbers for step in range(steps + 1))
    points = np.fromiter(chain.from_iterable(found), float, count=len(numbers) * (steps + 1) * 3).reshape(-1, steps + 1, 3)
    points = points[points.any(axis=(1, 2))]
    points = points @ inverse[:3, :3].T + inverse[:3, 3]
    return Strands(points.reshape(-1, 3), profile(settings, points).reshape(-1), np.full(len(points), steps + 1))


def profile(settings, points):
    """Radii of strands from root to tip; Blender's settings are diameters, whatever their names."""
    root, tip = (0.5 * settings.radius_scale * width for width in (settings.root_radius, settings.tip_radius))
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=2).cumsum(axis=1)
    left = np.ones(points.shape[:2])
    left[:, 1:] -= lengths / np.maximum(lengths[:, -1:], 1e-20)
    shape = settings.shape
    width = tip + (root - tip) * np.maximum(left, 0) ** (1 + shape if shape < 0 else 1 / max(1 - shape, 1e-3))
    if settings.use_close_tip:
        width[:, -1] = 0.0
    return width
