# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np

import gnurt


def test_distances_to_a_cube(scene):
    points = np.random.default_rng(3).uniform(-1, 2, size=(500, 3))
    outside = np.maximum(np.maximum(-points, points - 1), 0)
    inside = np.minimum(points, 1 - points).min(axis=1)
    expected = np.where(inside > 0, -inside, np.linalg.norm(outside, axis=1))
    assert np.allclose(scene.signed_distance(points), expected, atol=1e-12)
    assert np.allclose(scene.distance(points), abs(expected), atol=1e-12)
    assert (scene.contains(points) == (inside > 0)).all()
    at, distance, prim_id, geom_id = scene.closest_point(points.astype(np.float32))
    assert np.allclose(np.linalg.norm(at - points, axis=1), distance, atol=1e-6)
    assert (prim_id >= 0).all() and (geom_id == 0).all()


def test_nothing_is_near():
    scene = gnurt.RayScene()
    at, distance, prim_id, geom_id = scene.closest_point([[0.0, 0, 0]])
    assert np.isnan(at).all() and np.isinf(distance).all() and prim_id[0] == geom_id[0] == -1
    assert not scene.contains([[0.0, 0, 0]])[0]
