# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads that call at the same moment: with and without Python's global lock, results are those of one thread."""

import copy
import os
import pickle
import sys
import sysconfig
import threading

import numpy as np
import pytest

import gnurt

FREE = bool(sysconfig.get_config_var("Py_GIL_DISABLED")) and os.environ.get("PYTHON_GIL") != "1"


def together(*calls):
    """Runs functions at the same moment, and raises what one of them raised."""
    begin, raised = threading.Barrier(len(calls)), []

    def run(call):
        begin.wait()
        try:
            call()
        except BaseException as error:
            raised.append(error)

    threads = [threading.Thread(target=run, args=(call,)) for call in calls]
    [thread.start() for thread in threads], [thread.join() for thread in threads]
    if raised:
        raise raised[0]


@pytest.mark.skipif(not FREE, reason="this interpreter has a global lock")
def test_the_lock_stays_off():
    assert not sys._is_gil_enabled()


def grid(n, z=0.0):
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    points = np.stack([x.ravel(), y.ravel(), np.full(n * n, z)], axis=1)
    i = np.arange(n * n).reshape(n, n)
    corners = [i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]]
    a, b, c, d = (corner.ravel() for corner in corners)
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def test_rays_while_meshes_come():
    """Each answer is that of the scene before or after a mesh, never between them."""
    scene = gnurt.RayScene()
    scene.add_triangles(*grid(20))
    org = np.random.default_rng(3).uniform(0.05, 0.95, (2000, 3)) * [1, 1, 0] + [0, 0, 50]
    wrong = []

    def trace():
        for _ in range(40):
            t = scene.intersect(org, np.array([[0.0, 0.0, -1.0]])).t
            # One grid is met by all rays: the highest that is there.
            if len(set(t.tolist())) != 1 or t[0] != round(float(t[0])):
                wrong.append(t)

    def add():
        for z in range(1, 21):
            scene.add_triangles(*grid(20, float(z)))

    together(trace, trace, trace, add)
    assert not wrong
    assert set(scene.intersect(org, np.array([[0.0, 0.0, -1.0]])).t.tolist()) == {30.0}


def test_one_picture_from_many_threads():
    scene = gnurt.load("builtin:cornell")
    first = np.asarray(scene.render(32, 24, spp=2))
    pictures = [None] * 4

    def render(i):
        pictures[i] = np.asarray(scene.render(32, 24, spp=2))

    together(*(lambda i=i: render(i) for i in range(4)))
    assert all((picture == first).all() for picture in pictures)


def test_edits_while_pictures_are_made():
    """A picture shows the lamp as it was at one moment."""
    scene = gnurt.load("builtin:cornell")
    lamp = scene.add_light("point", position=(0, 0, 0), intensity=1.0)

    def picture():
        return np.asarray(scene.render(16, 12, spp=1)).tobytes()

    def shine(power):
        scene.set_light(lamp, "point", position=(0, 0, 0), intensity=float(power))

    expected = set()
    for power in range(1, 6):
        shine(power)
        expected.add(picture())
    assert len(expected) == 5
    pictures = []

    def edit():
        for power in [1, 2, 3, 4, 5] * 6:
            shine(power)

    def render():
        for _ in range(8):
            pictures.append(picture())

    together(edit, render, render)
    assert len(pictures) == 16 and set(pictures) <= expected
    assert picture() in expected


def test_hits_are_read_by_many():
    """Values of hits that are computed at first use are computed once, and are the same for all."""
    scene = gnurt.RayScene()
    scene.add_triangles(*grid(50))
    org = np.random.default_rng(5).uniform(0.05, 0.95, (5000, 3)) + [0, 0, 3]
    for _ in range(20):
        hits = scene.intersect(org, np.array([[0.0, 0.0, -1.0]]))
        normals = [None] * 4

        def read(i):
            normals[i] = hits.normal

        together(*(lambda i=i: read(i) for i in range(4)))
        assert all((normal == normals[0]).all() for normal in normals)
        assert np.allclose(np.abs(normals[0]), [0, 0, 1])


def test_all_at_once():
    """Threads that render, trace, edit, copy and pickle: each result is one that a single thread could have."""
    scene, rays = gnurt.load("builtin:cornell"), gnurt.RayScene()
    lamp = scene.add_light("point", position=(0, 0, 0), intensity=1.0)
    glow = scene.add_material("glow", shader="surface glow (float k = 1) { Ci = k * emission (); }", parameters={"k": 0.25})
    rays.add_triangles(*grid(20))
    org = np.random.default_rng(9).uniform(0.05, 0.95, (3000, 3)) + [0, 0, 3]
    down = np.array([[0.0, 0.0, -1.0]])
    t = rays.intersect(org, down).t

    def shine(power):
        scene.set_light(lamp, "point", position=(0, 0, 0), intensity=float(power))

    def picture(of=scene):
        return np.asarray(of.render(16, 12, spp=1)).tobytes()

    expected = set()
    for power in (1, 2, 3):
        shine(power)
        expected.add(picture())
    pictures, traced, stored = [], [], pickle.dumps(rays)

    def edit():
        for power in [1, 2, 3] * 8:
            shine(power)
            scene.set_material(glow, shader="surface glow (float k = 1) { Ci = k * emission (); }", parameters={"k": 1.0 / power})

    def trace():
        for _ in range(30):
            traced.append(rays.intersect(org, down).t)
            traced.append(pickle.loads(stored).intersect(org, down).t)

    def render():
        for _ in range(6):
            pictures.append(picture())

    def stand_in():
        for _ in range(6):
            pictures.append(picture(pickle.loads(pickle.dumps(scene))))
            pictures.append(picture(copy.deepcopy(scene)))

    together(edit, trace, trace, render, stand_in)
    assert len(pictures) == 18 and set(pictures) <= expected
    assert len(traced) == 120 and all((each == t).all() for each in traced)
