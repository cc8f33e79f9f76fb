# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and curves as the package takes them: points and radii, strand by strand.

Space: that of the points.
"""

import numpy as np

from . import hashes


class Strands:
    """Strands that go through all of their points: vertices (n, 3), radii (n,), and how many vertices each strand has.

    The first and the last point are there twice: a Catmull-Rom curve goes from its second vertex to the last but one.
    """

    def __init__(self, strands, radii):
        found = [(np.asarray(points, np.float32), np.asarray(radius, np.float32)) for points, radius in zip(strands, radii) if len(points) > 1]
        twice = [np.concatenate([[0], np.arange(len(points)), [len(points) - 1]]) for points, _ in found]
        self.counts = [len(order) for order in twice]
        self.found, self.twice = found, twice

    def __bool__(self):
        return bool(self.found)

    def _rows(self, of):
        return np.ascontiguousarray(np.concatenate([of(number, *strand)[order] for number, (strand, order) in enumerate(zip(self.found, self.twice))]), np.float32)

    @property
    def vertices(self):
        return self._rows(lambda number, points, radii: points)

    @property
    def radii(self):
        return self._rows(lambda number, points, radii: radii)

    def value(self, name):
        """What the node Hair Info gives, by vertex; None for what is not known."""
        if name == "Is Strand":
            return self._rows(lambda number, points, radii: np.ones(len(points)))
        if name == "Intercept":
            return self._rows(lambda number, points, radii: lengths(points) / max(lengths(points)[-1], 1e-20))
        if name == "Length":
            return self._rows(lambda number, points, radii: np.full(len(points), lengths(points)[-1]))
        if name == "Thickness":
            return self._rows(lambda number, points, radii: 2 * radii)
        if name == "Random":
            return self._rows(lambda number, points, radii: np.full(len(points), hashes.of_number(number)))
        return None


def lengths(points):
    """How far along a strand its points are."""
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def of_curves(curves):
    """Points and radii of a hair curves data-block."""
    positions = np.empty(len(curves.points) * 3, np.float32)
    curves.points.foreach_get("position", positions)
    positions = positions.reshape(-1, 3)
    radii = np.full(len(positions), 0.005, np.float32)
    found = curves.attributes.get("radius")
    if found is not None:
        found.data.foreach_get("value", radii)
    strands, widths = [], []
    for curve in curves.curves:
        part = slice(curve.first_point_index, curve.first_point_index + curve.points_length)
        strands.append(positions[part])
        widths.append(radii[part])
    return Strands(strands, widths)


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
    shape, root, tip = settings.shape, settings.root_radius * settings.radius_scale, settings.tip_radius * settings.radius_scale
    strands, widths = [], []
    for number in numbers:
        points = np.array([system.co_hair(evaluated, particle_no=number, step=step) for step in range(steps + 1)])
        if not points.any():
            continue
        points = points @ inverse[:3, :3].T + inverse[:3, 3]
        at = np.linspace(0, 1, steps + 1)
        at = at ** (1 + shape) if shape < 0 else at ** (1 / max(1 - shape, 1e-3))
        width = root + (tip - root) * at
        if settings.use_close_tip:
            width[-1] = 0.0
        strands.append(points)
        widths.append(width)
    return Strands(strands, widths)
