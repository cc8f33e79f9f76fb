# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import gc
import os
import pickle
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest

import gnurt
from conftest import cube, in_child

DOWN = np.array([[0.0, 0, -1]])


def at(x):
    place = np.eye(4)
    place[0, 3] = x
    return place


def test_ids_stay(scene):
    vertices, faces = cube()
    second = scene.add_triangles(vertices, faces, transform=at(10))
    shown = [scene.add_instance(0, at(20)), scene.add_instance(second, at(30))]
    assert (second, shown) == (1, [0, 1])
    above = np.array([[0.5 + x, 0.5, 3] for x in (0, 10, 20, 30, 40)])

    def ids():
        hits = scene.intersect(above, DOWN)
        return hits.geom_id.tolist(), hits.inst_id.tolist(), hits.normal[:, 2].tolist()

    assert ids() == ([0, 1, 0, 1, -1], [-1, -1, 0, 1, -1], [1, 1, 1, 1, 0])
    scene.remove(inst_id=0)
    scene.update(inst_id=1, transform=at(40))
    assert ids()[:2] == ([0, 1, -1, -1, 1], [-1, -1, -1, -1, 1])
    scene.update(0, vertices=vertices + [0, 0, 1])
    assert scene.intersect(above[:1], DOWN).t == [1]
    scene.remove(1)
    assert ids()[:2] == ([0, -1, -1, -1, -1], [-1] * 5), "its instances go with it"
    assert scene.add_triangles(vertices, faces) == 2, "numbers are not given twice"
    for wrong in (lambda: scene.remove(1), lambda: scene.update(7), lambda: scene.add_instance(1, at(0))):
        with pytest.raises(IndexError, match="does not exist"):
            wrong()


def test_kept(scene, rays, tmp_path):
    scene.remove(scene.add_triangles(*cube()))
    scene.add_triangles(*cube(), transform=at(2)[:3])
    scene.add_instance(0, at(4))
    expected = scene.intersect(*rays)
    scene.save(tmp_path / "a.rays")
    others = [pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene)]
    for other in [*others, gnurt.RayScene.load(tmp_path / "a.rays")]:
        hits = other.intersect(*rays)
        assert (hits.t == expected.t).all() and (hits.geom_id == expected.geom_id).all()
        assert repr(other) == repr(scene) and type(other) is gnurt.RayScene
    assert [path.name for path in tmp_path.iterdir()] == ["a.rays"], "no unfinished file is left"


@pytest.fixture
def town(scene):
    """Two streets of two houses each, and a tower twice; all are cubes."""
    street = gnurt.RayScene()
    for x in (0, 2):
        street.add_instance(scene, at(x))
    town = gnurt.RayScene()
    tower = town.add_triangles(*cube(), transform=at(-3))
    for y in (0, 5):
        place = at(0)
        place[1, 3] = y
        town.add_instance(street, place)
    town.add_instance(tower, at(9))
    return town


CORNERS = (0, 0), (2, 0), (0, 5), (2, 5), (-3, 0), (9, 0)


def test_scenes_in_scenes(town, scene):
    above = np.array([[x + 0.3, y + 0.5, 3] for x, y in [*CORNERS, (5, 2)]])
    hits = town.intersect(above, DOWN)
    assert hits.t.tolist() == [2] * 6 + [np.inf]
    assert hits.inst_id.tolist() == [0, 0, 1, 1, -1, 2, -1]
    assert hits.geom_id.tolist() == [0] * 6 + [-1]
    assert hits.path.tolist() == [[0, 0], [0, 1], [1, 0], [1, 1], [-1, -1], [2, -1], [-1, -1]]
    assert hits.normal[:6].tolist() == [[0, 0, 1]] * 6
    every = town.all_hits(above, DOWN)
    assert every.splits.tolist() == [0, 2, 4, 6, 8, 10, 12, 12]
    assert every.path[::2].tolist() == hits.path[:6].tolist() and town.occluded(above, DOWN).sum() == 6
    assert town.contains([[2.5, 5.5, 0.5], [1.5, 0.5, 0.5]]).tolist() == [True, False]
    assert scene.intersect(above, DOWN).path.tolist() == [[-1]] * 7, "one level where there are none within"
    scene.update(0, vertices=cube()[0] * [1, 1, 2])
    assert town.intersect(above, DOWN).t.tolist() == [1] * 4 + [2, 2, np.inf], "edits of what lies within are seen"
    town.remove(inst_id=0)
    town.update(inst_id=1, transform=at(20))
    assert town.intersect([[22.3, 0.5, 3]], DOWN).path.tolist() == [[1, 1]]


def test_scenes_in_scenes_are_as_one(town):
    random = np.random.default_rng(5)
    origins, to = random.uniform(-4, 12, size=(2, 3000, 3)) * [1, 0.8, 0.3]
    one = gnurt.RayScene()
    for x, y in CORNERS:
        one.add_triangles(cube()[0] + [x, y, 0], cube()[1])
    found, wanted = town.intersect(origins, to - origins), one.intersect(origins, to - origins)
    assert np.isfinite(wanted.t).sum() > 300
    np.testing.assert_allclose(found.t, wanted.t, rtol=1e-5)


def test_scenes_in_scenes_are_kept(town, scene, tmp_path):
    above = [[2.3, 5.5, 3.0]]
    town.save(tmp_path / "a.rays")
    others = [pickle.loads(pickle.dumps(town)), copy.deepcopy(town), gnurt.RayScene.load(tmp_path / "a.rays")]
    shallow = copy.copy(town)
    scene.update(0, vertices=cube()[0] * [1, 1, 2])
    for other in others:
        hits = other.intersect(above, DOWN)
        assert hits.t == [2] and hits.path.tolist() == [[1, 1]], "as it was, with all in it"
    assert shallow.intersect(above, DOWN).t == [1], "a shallow copy shows the same scenes"
    whole = (tmp_path / "a.rays").read_bytes()
    for damaged in (whole[:200], b"GNURT ray scene 1\n" + whole[18:], whole.replace(b"0.instances", b"0.instantes")):
        (tmp_path / "b.rays").write_bytes(damaged)
        with pytest.raises(ValueError, match="b.rays"):
            gnurt.RayScene.load(tmp_path / "b.rays")


def test_no_scene_shows_itself(town, scene):
    for shown in (scene, town):
        with pytest.raises(ValueError, match="cannot contain itself"):
            scene.add_instance(shown, at(0))
    with pytest.raises(TypeError):
        town.add_instance("street", at(0))
    deepest = scene
    for _ in range(16):
        outer = gnurt.RayScene()
        outer.add_instance(deepest, at(1))
        deepest = outer
    assert deepest.intersect([[16.3, 0.5, 3]], DOWN).path.tolist() == [[0] * 16]
    outer = gnurt.RayScene()
    outer.add_instance(deepest, at(1))
    with pytest.raises(ValueError, match="more than 16 levels"):
        outer.commit()


def test_damaged_files(scene, tmp_path):
    scene.save(tmp_path / "a.rays")
    whole = (tmp_path / "a.rays").read_bytes()
    for damaged in (b"", whole[:10], whole[:100], whole[:-30], whole[:60] + b"\xff" * 40 + whole[100:]):
        (tmp_path / "b.rays").write_bytes(damaged)
        with pytest.raises(ValueError, match="b.rays"):
            gnurt.RayScene.load(tmp_path / "b.rays").intersect(np.zeros((1, 3)), DOWN)


def test_arrays_are_copied_unless_said():
    vertices, faces = cube()
    vertices, faces = vertices.astype(np.float32), faces.astype(np.uint32)
    above = np.array([[0.5, 0.5, 3]])
    for copied in (True, False):
        scene, own = gnurt.RayScene(), vertices.copy()
        scene.add_triangles(own, faces, copy=copied)
        own += 1
        assert (scene.intersect(above, DOWN).t == [2]).all() == copied


def sheet(n):
    """`2 n^2` triangles over the unit square, at height 0."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1, 1)
    return vertices, np.concatenate([corner + [0, 1, n + 2], corner + [0, n + 2, n + 1]])


def test_what_is_added_during_a_build_is_seen():
    scene, vertices = gnurt.RayScene(), cube()
    scene.add_triangles(*sheet(300))
    above = [[0.5, 0.5, 9.0]]
    began, found = threading.Event(), []

    def ask():
        began.set()
        found.append(scene.intersect(above, DOWN, threads=1).t[0])

    thread = threading.Thread(target=ask)
    thread.start()
    began.wait()
    heights = []
    while thread.is_alive() and len(heights) < 50:
        heights.append(1 + len(heights) / 8)
        place = np.eye(4)
        place[2, 3] = heights[-1] - 1
        scene.add_triangles(*vertices, transform=place)
        time.sleep(0.005)
    thread.join()
    assert len(heights) > 1 and found[0] <= 9, "cubes came while the trees were built"
    assert scene.intersect(above, DOWN).t == [9 - heights[-1]], "trees of an earlier state are not kept"


@pytest.mark.parametrize("with_instances", [False, True])
def test_updates_answer_as_new_scenes(with_instances):
    random = np.random.default_rng(7)
    vertices, faces = sheet(40)
    places = [at(x) for x in (2, 4, 6)]

    def made(heights, shift, places):
        scene = gnurt.RayScene()
        scene.add_triangles(vertices + heights, faces, transform=shift)
        scene.add_triangles(*cube(), transform=at(8))
        for place in places if with_instances else []:
            scene.add_instance(0, place)
        return scene

    origins = random.uniform([0, 0, 3], [9, 1, 4], size=(2000, 3))
    scene, shift = made(0 * vertices, None, places), None
    for frame in range(6):
        heights = random.uniform(0, 0.2, size=vertices.shape)
        scene.update(0, vertices=vertices + heights)
        if frame % 2:
            shift = at(frame / 8)
            scene.update(0, transform=shift)
        if with_instances:
            places[frame % 3] = at(2 + frame / 4)
            scene.update(inst_id=frame % 3, transform=places[frame % 3])
        hits, expected = scene.intersect(origins, DOWN), made(heights, shift, places).intersect(origins, DOWN)
        assert (hits.prim_id >= 0).sum() > 300
        for name in ("t", "u", "v", "prim_id", "geom_id", "inst_id", "normal"):
            assert (getattr(hits, name) == getattr(expected, name)).all(), f"{name} in frame {frame}"


def test_instances_share_arrays():
    program = """if True:
        import resource, sys
        import numpy as np
        import gnurt
        from test_scene import at, sheet
        scene = gnurt.RayScene()
        scene.add_triangles(*sheet(200))
        scene.commit()
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for i in range(200):
            scene.add_instance(0, at(i))
        assert scene.intersect([[150.5, 0.5, 1]], [[0, 0, -1.0]]).inst_id == [150]
        print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
    """
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=os.path.dirname(__file__))
    assert answer.returncode == 0, answer.stderr
    assert float(answer.stdout) < 60, "a copy of the arrays for each of 200 instances would be 290 MB"


def test_collecting_garbage_may_ask():
    """Of Python 3.11: it collects wherever an object is made. A finalizer then asks the scene that makes it."""

    class Asking:
        def __init__(self, scene):
            self.scene, self.itself = scene, self

        def __del__(self):
            asked.append(self.scene.intersect([[0.5, 0.5, 3]], DOWN, threads=1).t.tolist())

    asked = []

    def job():
        scene = gnurt.RayScene()
        for _ in range(60):
            scene.add_instance(scene.add_triangles(*cube()), at(5))
        for threshold in range(20, 200, 5):
            gc.collect()
            Asking(scene)
            # So that the collection comes somewhere in the middle.
            gc.set_threshold(threshold)
            pickle.dumps(scene)
            scene.add_triangles(*cube())
            scene.intersect([[0.5, 0.5, 3]], DOWN, threads=1)
            gc.set_threshold(0)
        gc.collect()
        return len(asked) == 36 and all(t == [2] for t in asked)

    in_child(job)


def test_arrays_that_go_may_ask():
    """What is replaced is dropped by the scene: code of the program's may run then."""

    class Asking(np.ndarray):
        def __del__(self):
            if self.base is None:
                asked.append(scene.intersect([[0.5, 0.5, 3]], DOWN, threads=1).t.tolist())

    asked = []
    scene = gnurt.RayScene()

    def job():
        vertices, faces = cube()
        ours = Asking((8, 3), np.float32)
        ours[:] = vertices
        scene.add_triangles(ours, faces.astype(np.uint32), copy=False)
        del ours
        scene.update(0, vertices=vertices + [0, 0, 1])
        return asked == [[1]]

    in_child(job)


def test_kept_arrays_stay_as_they_are(rays):
    vertices, faces = (a.astype(t) for a, t in zip(cube(), (np.float32, np.uint32)))
    for copy in (True, False):
        scene = gnurt.RayScene()
        scene.add_triangles(vertices, faces, copy=copy)
        (kept, numbers, _), *_ = scene.__getstate__()["meshes"]
        for array in (kept, numbers):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 99
        again = pickle.loads(pickle.dumps(scene))
        assert (again.intersect(*rays).t == scene.intersect(*rays).t).all()
    assert vertices.flags.writeable and faces.flags.writeable, "the program's own"


def test_circles_with_owners_are_collected():
    class Owned(gnurt.RayScene):
        pass

    outer, inner = Owned(), Owned()
    outer.add_instance(inner, np.eye(4))
    inner.owner = outer
    gone = weakref.ref(outer)
    del outer, inner
    gc.collect()
    assert gone() is None


def test_circles_of_threads_are_refused():
    """Two threads that put two scenes into each other: one of them is told."""
    for _ in range(200):
        a, b = gnurt.RayScene(), gnurt.RayScene()
        begin, told = threading.Barrier(2), []

        def put(inner, outer):
            begin.wait()
            try:
                outer.add_instance(inner, np.eye(4))
            except ValueError:
                told.append(outer)

        both = [threading.Thread(target=put, args=pair) for pair in ((a, b), (b, a))]
        [thread.start() for thread in both], [thread.join() for thread in both]
        assert len(told) == 1
