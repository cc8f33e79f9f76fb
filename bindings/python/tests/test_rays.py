# SPDX-License-Identifier: GPL-3.0-or-later
import threading

import numpy as np

import gnurt
from conftest import brute_force, cube, in_child


def test_against_brute_force(scene, rays):
    vertices, faces = cube()
    expected = brute_force(vertices, faces, *rays)
    hits = scene.intersect(*rays)
    hit = np.isfinite(expected.min(axis=1))
    assert 300 < hit.sum() < 1000 and (np.isfinite(hits.t) == hit).all()
    assert np.allclose(hits.t[hit], expected.min(axis=1)[hit], rtol=1e-5)
    assert ((hits.prim_id >= 0) == hit).all() and ((hits.geom_id == 0) == hit).all() and (hits.inst_id == -1).all()
    a, b, c = (vertices[faces[hits.prim_id[hit]]][:, k] for k in range(3))
    u, v = hits.u[hit, None], hits.v[hit, None]
    at = rays[0][hit] + hits.t[hit, None] * rays[1][hit]
    assert np.allclose((1 - u - v) * a + u * b + v * c, at, atol=1e-5), "weights of the second and third corner"
    assert np.allclose(hits.normal[hit], np.cross(b - a, c - a)), "the right hand"
    assert (hits.normal[~hit] == 0).all() and len(hits) == 1000 and "1000 rays" in repr(hits)
    assert (scene.occluded(*rays) == hit).all()
    every = scene.all_hits(*rays)
    counts = np.diff(every.splits)
    assert (counts[hit] >= 1).all() and (counts[~hit] == 0).all() and len(every) == 1000
    assert (np.diff(every.t)[np.diff(every.ray_id) == 0] >= 0).all(), "sorted along each ray"
    first = scene.all_hits(*rays, max_hits=1)
    assert (first.t == hits.t[hit]).all() and (first.ray_id == np.nonzero(hit)[0]).all()


def test_threads_change_nothing(scene, rays):
    one, three = scene.intersect(*rays, threads=1), scene.intersect(*rays, threads=3)
    for name in ("t", "u", "v", "prim_id", "normal"):
        assert (getattr(one, name) == getattr(three, name)).all(), name
    found = []
    jobs = [threading.Thread(target=lambda: found.append(scene.intersect(*rays).t)) for _ in range(4)]
    [job.start() for job in jobs], [job.join() for job in jobs]
    assert len(found) == 4 and all((t == one.t).all() for t in found)


def test_after_fork(scene, rays):
    hits = scene.intersect(*rays, threads=2)
    normal = hits.normal
    in_child(lambda: (scene.intersect(*rays, threads=2).t == hits.t).all())
    in_child(lambda: (hits.normal == normal).all())


def test_one_goes_with_many(scene):
    many = np.random.default_rng(1).uniform(0.1, 0.9, size=(50, 3))
    eye = np.array([[0.5, 0.5, 5.0]])
    assert (scene.intersect(eye, many - eye).t == scene.intersect(np.repeat(eye, 50, 0), many - eye).t).all()
    down = np.array([[0.0, 0.0, -1.0]])
    above = many + [0, 0, 5]
    assert np.allclose(scene.intersect(above, down).t, above[:, 2] - 1)
    assert scene.intersect(eye, down).t == [4] and len(scene.intersect(np.zeros((0, 3)), down)) == 0


def test_near_and_far_ends(scene):
    origins, down = np.full((3, 3), [0.3, 0.4, 3.0]), np.array([[0.0, 0.0, -1.0]])
    assert scene.intersect(origins, down, 2.5).t.tolist() == [3, 3, 3]
    assert scene.occluded(origins, down, [0, 2.5, 3.5], [1.5, 2.6, 9]).tolist() == [False, False, False]
    assert scene.occluded(origins, down, t_far=np.float32([1.5, 2, 9])).tolist() == [False, True, True]


def test_crossings_at_edges_and_corners(scene):
    vertices, faces = cube()
    middles = np.concatenate([vertices, (vertices[faces] + vertices[np.roll(faces, 1, 1)]).reshape(-1, 3) / 2])
    outside = np.random.default_rng(2).normal(size=(len(middles), 3)) * 9 + 0.5
    counts = scene.crossings(outside, middles - outside, t_far=100)
    assert (counts % 2 == 0).all() and counts.max() == 2
    crossed = scene.crossing_hits(outside, middles - outside, t_far=100)
    assert (np.diff(crossed.splits) == counts).all() and (np.diff(crossed.t)[np.diff(crossed.ray_id) == 0] >= 0).all()
    assert len(scene.all_hits(outside, middles - outside, t_far=100).t) > len(crossed.t), "all that meet there"
    assert (scene.crossings([[-1.0, -1, -1]], [[1.0, 1, 1]]) == 2).all()
    soup = gnurt.RayScene()
    soup.add_triangles(vertices[faces].reshape(-1, 3), np.arange(36).reshape(-1, 3))
    assert (soup.crossings(outside, middles - outside, t_far=100) == counts).all()
    soup.add_triangles(vertices, faces)
    assert (soup.crossings(outside, middles - outside, t_far=100) == 2 * counts).all(), "sheets count each"


def test_rays_that_miss(scene):
    origins = np.array([[np.nan, 0, 0], [np.inf, 0, 0], [0.5, 0.5, 9], [0.5, 0.5, 9]])
    directions = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 0, 0], [0, np.nan, -1]])
    assert np.isinf(scene.intersect(origins, directions).t).all()
    assert not scene.occluded(origins, directions).any() and (scene.crossings(origins, directions) == 0).all()
