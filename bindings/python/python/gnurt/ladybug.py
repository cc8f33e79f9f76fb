# SPDX-License-Identifier: GPL-3.0-or-later
"""What ladybug-radiance asks Radiance for: which vectors reach which points. In this process, without files."""

import sys

import numpy as np

from . import RayScene

__all__ = ["install", "intersection_matrix"]

#: Rays that are traced at a time.
_RAYS = 1 << 20


def intersection_matrix(
    vectors,
    points,
    normals,
    context_geometry,
    offset_distance=0,
    numericalize=False,
    sim_folder=None,
    use_radiance_mesh=False,
):
    """Which vectors are seen from which points: an array of a row for each point and a column for each vector.

    True where nothing of `context_geometry` (ladybug's Face3D and Mesh3D, or whatever has `vertices` and `faces`) is in the way
    and the vector is in front of the point's normal, which must have unit length. With `numericalize` the cosine between them, 0
    where it is not seen. `sim_folder` and `use_radiance_mesh` have no effect.
    """
    vectors, points, normals = (_rows(given) for given in (vectors, points, normals))
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    vectors = np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0)
    points = points + offset_distance * normals
    scene, size = RayScene(), np.abs(points).max(initial=0)
    for geometry in context_geometry:
        vertices, faces = _triangles(geometry)
        if len(faces):
            scene.add_triangles(vertices, faces)
            size = max(size, np.abs(vertices).max())
    cosines = normals @ vectors.T
    matrix = np.where(cosines > 0, cosines, 0.0)
    # Floats end there; a point in a face does not see it.
    near = 4e-7 * size
    step = max(1, _RAYS // max(1, len(vectors)))
    for first in range(0, len(points), step):
        place, number = np.nonzero(matrix[first : first + step])
        hidden = scene.occluded(points[first + place], vectors[number], near)
        matrix[first + place[hidden], number[hidden]] = 0
    return matrix if numericalize else matrix > 0


def _rows(given):
    """Ladybug's points and vectors, or anything else with three numbers each."""
    return np.array([tuple(item) for item in given], float).reshape(-1, 3)


def _triangles(geometry):
    mesh = getattr(geometry, "triangulated_mesh3d", geometry)
    faces = []
    for face in mesh.faces:
        faces.extend((face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1))
    return _rows(mesh.vertices), np.array(faces, np.int64).reshape(-1, 3)


def install():
    """Puts `intersection_matrix` in the place of ladybug_radiance's, wherever that is imported."""
    from ladybug_radiance import intersection

    before = intersection.intersection_matrix
    for name, module in list(sys.modules.items()):
        if name.split(".")[0] == "ladybug_radiance" and getattr(module, "intersection_matrix", None) is before:
            module.intersection_matrix = intersection_matrix
