# SPDX-License-Identifier: GPL-3.0-or-later
import array

import numpy as np
import pytest

import gnurt
from conftest import cube


def test_any_layout_gives_the_same(scene, rays):
    origins, directions = (a.astype(np.float32).astype(float) for a in rays)
    expected = scene.intersect(origins, directions).t
    rows = np.concatenate([origins, directions], axis=1)
    wide = np.zeros((1000, 9))
    wide[:, 1:7] = rows
    for org, dir in (
        (rows[:, :3], rows[:, 3:]),
        (rows.astype(np.float32)[:, :3], rows[:, 3:]),
        (wide[:, 1:4], wide[:, 4:7]),
        (np.asfortranarray(origins), directions.tolist()),
        (origins[::-1][::-1], np.repeat(directions, 2, axis=0)[::2]),
        (origins.astype(">f8"), np.ascontiguousarray(directions.T).T),
    ):
        assert (scene.intersect(org, dir).t == expected).all()


def test_unaligned_arrays(scene, rays):
    fields = [("kind", "u1"), ("org", "<f4", 3), ("dir", "<f8", 3), ("far", "<f8"), ("face", "<u4", 3), ("at", ">f4", 3)]
    packed = np.zeros(1000, dtype=fields)
    packed["org"], packed["dir"], packed["far"] = *rays, 0.5
    assert not packed["org"].flags.aligned and packed["dir"].strides[0] % 8 != 0
    org, dir = packed["org"].copy(), packed["dir"].copy()
    expected = scene.intersect(org, dir, t_far=0.5)
    assert (scene.intersect(packed["org"], packed["dir"], t_far=packed["far"]).t == expected.t).all()
    shifted = np.frombuffer(b"-" + org.tobytes(), np.float32, offset=1).reshape(-1, 3)
    assert not shifted.flags.aligned and (scene.intersect(shifted, dir, t_far=0.5).t == expected.t).all()
    assert (scene.distance(packed["org"]) == scene.distance(org)).all()
    vertices, faces = cube()
    packed["at"][:8], packed["face"][:12] = vertices, faces
    placed = np.frombuffer(b"-" + np.eye(4).tobytes(), float, offset=1).reshape(4, 4)
    for copy in (True, False):
        other = gnurt.RayScene()
        other.add_triangles(packed["at"][:8], packed["face"][:12], placed, copy=copy)
        other.update(0, vertices=packed["at"][:8], transform=placed, copy=copy)
        assert (other.intersect(org, dir, t_far=0.5).t == expected.t).all()


def test_other_arrays(scene):
    class Array:
        def __array__(self, dtype=None, copy=None):
            return np.array([[0.5, 0.5, 3]])

    down = memoryview(array.array("d", [0, 0, -1])).cast("B").cast("d", [1, 3])
    assert scene.intersect(Array(), down).t == [2]
    assert scene.intersect([[0, 0, 3]], np.array([[0, 0, -1]], np.int8)).t == [2]


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda s: s.intersect(np.zeros((5, 2)), np.zeros((5, 3))), ValueError, r"origins: .*\(n, 3\).*\(5, 2\)"),
        (lambda s: s.intersect(np.zeros(3), np.zeros((5, 3))), ValueError, r"origins: .*\(3,\)"),
        (lambda s: s.occluded(np.zeros((5, 3)), np.zeros((4, 3))), ValueError, r"directions: .*\(5, 3\).*\(4, 3\)"),
        (lambda s: s.intersect("rays", np.zeros((5, 3))), TypeError, "origins"),
        (lambda s: s.intersect(np.zeros((5, 3), complex), np.zeros((5, 3))), TypeError, "origins: .*complex"),
        (lambda s: s.intersect(np.zeros((5, 3)), np.ones((5, 3)), t_far=np.zeros(4)), ValueError, "t_far: .*5.*4"),
        (lambda s: s.intersect(np.zeros((5, 3)), np.ones((5, 3)), t_near="a"), TypeError, "t_near"),
        (lambda s: s.contains(np.zeros((5, 4))), ValueError, "points"),
        (lambda s: s.contains(np.zeros((5, 3)), threads=-1), ValueError, "threads: 0 or more, not -1"),
        (lambda s: s.contains(np.zeros((5, 3)), threads=10**6), ValueError, "threads"),
        (lambda s: s.add_triangles(np.zeros((5, 3)), [[0, 1, 5]]), ValueError, "faces: row 0 names vertex 5.*5"),
        (lambda s: s.add_triangles(np.zeros((5, 3)), [[0, 1, -1]]), ValueError, "faces: .*-1"),
        (lambda s: s.add_triangles(np.zeros((5, 3)), [[0.5, 1, 2]]), TypeError, "faces: .*whole"),
        (lambda s: s.add_triangles(np.zeros((5, 3)), [[0, 1, 2, 3]]), ValueError, r"faces: .*\(m, 3\)"),
        (lambda s: s.add_triangles(np.zeros((5, 2)), [[0, 1, 2]]), ValueError, "vertices"),
        (lambda s: s.add_triangles(*cube(), transform=np.eye(3)), ValueError, r"transform: .*\(3, 3\)"),
        (lambda s: s.add_triangles(*cube(), transform=np.zeros((3, 4))), ValueError, "transform: .*singular"),
        (lambda s: s.add_instance(0, np.eye(4) * np.nan), ValueError, "transform: .*finite"),
        (lambda s: s.add_instance(0, np.ones((4, 4))), ValueError, "transform: .*last row"),
        (lambda s: s.update(0, vertices=np.zeros((3, 3))), ValueError, "vertices|faces"),
        (lambda s: s.update(), TypeError, "geom_id or inst_id"),
    ],
)
def test_wrong_arguments(scene, call, error, words):
    before = repr(scene)
    with pytest.raises(error, match=words):
        call(scene)
    assert repr(scene) == before


def test_missing_files_are_named(tmp_path):
    scene = gnurt.RayScene()
    with pytest.raises(FileNotFoundError, match="none/a.rays"):
        scene.save(tmp_path / "none" / "a.rays")
    for load in (gnurt.load, gnurt.RayScene.load):
        with pytest.raises(FileNotFoundError, match="none.obj"):
            load(tmp_path / "none.obj")


def test_help_says_what_each_call_takes():
    for name, member in vars(gnurt.RayScene.__base__).items():
        if not name.startswith("_"):
            assert member.__doc__, name


def test_polygons_are_divided():
    from gnurt._gnurt import _divide_polygons

    # A triangle, a square, and a quad that folds at its first diagonal.
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.7, 0.7, 0]], np.float32)
    corners = np.array([0, 1, 2, 0, 1, 2, 3, 1, 4, 3, 2], np.int32)
    loops, faces, polygons = _divide_polygons(vertices, corners, np.array([3, 4, 4], np.int32))
    assert (corners[loops] == faces).all()
    assert polygons.tolist() == [0, 1, 1, 2, 2]
    assert faces.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [1, 4, 2], [4, 3, 2]]
    area = np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2)))[:, 2]
    assert (area[:3] > 0).all() and (area[3:] < 0).all(), "no side is turned"
    assert _divide_polygons(vertices, corners[:5], [5]) is None, "five corners"
    with pytest.raises(ValueError, match="there is no vertex 5"):
        _divide_polygons(vertices, [0, 1, 5], [3])
    with pytest.raises(ValueError, match="there is no vertex -1"):
        _divide_polygons(vertices, [0, 1, -1], [3])
    with pytest.raises(ValueError, match="sum"):
        _divide_polygons(vertices, [0, 1, 2, 3], [3])


def test_hashes_of_arrays():
    from gnurt._gnurt import _hash_array

    bytes_of = np.arange(1000, dtype=np.uint8)
    changed = bytes_of.copy()
    changed[999] ^= 1
    assert len(_hash_array(bytes_of)) == 16
    assert _hash_array(bytes_of) == _hash_array(bytes_of.copy()) != _hash_array(changed)
