# SPDX-License-Identifier: GPL-3.0-or-later
"""The oracle of `gnurt_blender/strands.py`: points and radii of hair, strand by strand."""

import numpy as np
from gnurt_blender import hashes

VALUES = ("Is Strand", "Intercept", "Length", "Thickness", "Random")


def along(points):
    """How far along a strand its points are."""
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def arrays(strands):
    """Vertices, radii, counts and the values of Hair Info, of pairs of points and radii."""
    found = [(np.asarray(points, np.float32), np.asarray(radii, np.float32)) for points, radii in strands if len(points) > 1]
    rows = {"vertices": [], "radii": [], "counts": []} | {name: [] for name in VALUES}
    for number, (points, radii) in enumerate(found):
        twice = np.concatenate([[0], np.arange(len(points)), [len(points) - 1]])
        length, same = along(points), np.ones(len(points))
        rows["counts"].append([len(twice)])
        of = (points, radii, same, length / max(length[-1], 1e-20), same * length[-1], 2 * radii, same * hashes.of_number(number))
        for name, values in zip(("vertices", "radii", *VALUES), of):
            rows[name].append(values[twice].astype(np.float32))
    return {name: np.concatenate(values) for name, values in rows.items()}


def hair(settings, paths, matrix):
    """Pairs of points and radii of a hair system, from points in the world."""
    inverse, strands = np.linalg.inv(matrix), []
    for world in paths:
        if not world.any():
            continue
        points = world.astype(float) @ inverse[:3, :3].T + inverse[:3, 3]
        far, radii = along(points), []
        for at in far:
            left = max(1 - at / max(far[-1], 1e-20), 0)
            left = left ** (1 + settings.shape) if settings.shape < 0 else left ** (1 / max(1 - settings.shape, 1e-3))
            radii.append(settings.radius_scale / 2 * (settings.tip_radius + (settings.root_radius - settings.tip_radius) * left))
        if settings.use_close_tip:
            radii[-1] = 0.0
        strands.append((points, np.array(radii)))
    return strands
