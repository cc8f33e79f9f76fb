# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves and hair as tubes of triangles.

Space: that of the points. Each strand has a ring of corners at each of its points, in a frame that does not twist
[Wang et al., Computation of rotation minimizing frames, 2008, by projection].
"""

import numpy as np

SIDES = 6


def tubes(strands, radii, sides=SIDES):
    """Vertices, faces, and per vertex (strand, share of the length) of strands: lists of (n, 3) points and (n,) radii."""
    ring = np.arange(sides) * (2 * np.pi / sides)
    # As wide as a round tube seen from anywhere, on average: the mean width of a polygon is its perimeter over pi.
    grown = np.pi / (sides * np.sin(np.pi / sides))
    circle = np.stack([np.cos(ring), np.sin(ring)], axis=1) * grown
    vertices, faces, owners, shares, normals, base = [], [], [], [], [], 0
    for number, (points, radius) in enumerate(zip(strands, radii)):
        points = np.asarray(points, float)
        if len(points) < 2:
            continue
        way = np.gradient(points, axis=0)
        way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-20)
        side = np.cross(way[0], np.eye(3)[np.argmin(np.abs(way[0]))])
        frames = []
        for direction in way:
            side = side - direction * (side @ direction)
            side /= max(np.linalg.norm(side), 1e-20)
            frames.append((side, np.cross(direction, side)))
        frames = np.array(frames)
        around = np.einsum("sk,nkc->nsc", circle, frames)
        count = len(points)
        vertices.append((points[:, None] + around * np.asarray(radius)[:, None, None]).reshape(-1, 3))
        normals.append((around / grown).reshape(-1, 3))
        i, j = np.meshgrid(np.arange(count - 1), np.arange(sides), indexing="ij")
        a, b = base + i * sides + j, base + i * sides + (j + 1) % sides
        c, d = a + sides, b + sides
        faces.append(np.stack([np.stack([a, b, d], axis=-1), np.stack([a, d, c], axis=-1)]).reshape(-1, 3))
        lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        owners.append(np.full(count * sides, number))
        shares.append(np.repeat(lengths / max(lengths[-1], 1e-20), sides))
        base += count * sides
    if not vertices:
        return None
    return tuple(np.concatenate(part) for part in (vertices, faces, owners, shares, normals))


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
    return strands, widths


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
    return strands, widths


def spheres(points, radii, levels=1):
    """Spheres of triangles around points."""
    from .lamps import icosphere

    unit, faces = icosphere(levels)
    vertices = (points[:, None] + unit[None] * radii[:, None, None]).reshape(-1, 3)
    shifts = np.arange(len(points))[:, None, None] * len(unit)
    return vertices, (faces[None] + shifts).reshape(-1, 3), np.tile(unit, (len(points), 1))
