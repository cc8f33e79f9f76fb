# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays and signed distances under libigl's names."""

import numpy as np

from . import RayScene

__all__ = ["ray_mesh_intersect", "signed_distance"]


def _scene(V, F):
    scene = RayScene()
    scene.add_triangles(V, F)
    return scene


def ray_mesh_intersect(source, dir, V, F, first=False):
    """`[(triangle, t, u, v), ...]` in the order of t; of the first hit only if `first`."""
    source, dir = (np.asarray(a, float).reshape(1, 3) for a in (source, dir))
    hits = _scene(V, F).all_hits(source, dir, max_hits=1 if first else None)
    return list(zip(hits.prim_id.tolist(), hits.t.tolist(), hits.u.tolist(), hits.v.tolist()))


def signed_distance(P, V, F, sign_type=None):
    """`(S, I, C, N)`: distances, negative inside; triangles; nearest points; unit normals of those triangles.

    Inside is what a ray leaves after an odd number of crossings, whatever `sign_type`. Where there is no nearest point (there are no
    triangles, or the point has no finite place), the triangle is -1 and the normal 0.
    """
    P = np.asarray(P, float)
    scene = _scene(V, F)
    points, _, triangles, _ = scene.closest_point(P)
    there = triangles >= 0
    corners = np.asarray(V, float)[np.asarray(F)[triangles[there]]]
    normals = np.zeros((len(P), 3))
    normals[there] = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return scene.signed_distance(P), triangles.astype(np.int64), points, normals / np.where(lengths > 0, lengths, 1)
