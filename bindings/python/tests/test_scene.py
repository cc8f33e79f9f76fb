# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import pickle

import numpy as np
import pytest

import gnurt
from conftest import cube

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
        with pytest.raises(IndexError, match="there is no geometry"):
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
