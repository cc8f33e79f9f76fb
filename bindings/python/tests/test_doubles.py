# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import pickle
from fractions import Fraction

import numpy as np
import pytest

import gnurt
from conftest import cube

DOUBLE = np.dtype("float64")


def exact_hits(vertices, faces, origin, direction):
    """Parameters of all triangles that a ray touches, as fractions."""
    org, along = ([Fraction(float(x)) for x in row] for row in (origin, direction))

    def minus(a, b):
        return [x - y for x, y in zip(a, b, strict=True)]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def dot(a, b):
        return sum(x * y for x, y in zip(a, b, strict=True))

    found = []
    for face in faces:
        a, b, c = ([Fraction(float(x)) for x in vertices[corner]] for corner in face)
        u, v, w = minus(b, a), minus(c, a), minus(org, a)
        p, q = cross(along, v), cross(w, u)
        area = dot(u, p)
        if area:
            weights, t = [dot(w, p) / area, dot(along, q) / area], dot(v, q) / area
            if min(*weights, 1 - sum(weights), t) >= 0:
                found.append(t)
    return sorted(found)


@pytest.mark.parametrize("offset", [0.0, 1e4, 1e6, 1e8])
def test_hits_are_exact(offset):
    random = np.random.default_rng(33)
    vertices, faces = cube()
    vertices = offset + vertices.astype(float) + 1e-2 * random.normal(size=vertices.shape)
    scene = gnurt.RayScene(dtype="float64")
    scene.add_triangles(vertices, faces)
    count = 90
    corners = vertices[faces[random.integers(0, len(faces), count)]]
    weights = random.dirichlet([1, 1, 1], count)
    weights[1::3] = [0.5, 0.5, 0]
    weights[2::3] = [1, 0, 0]
    targets = np.einsum("ij,ijk->ik", weights, corners)
    origins = offset + random.normal(size=(count, 3)) * 3
    directions = targets - origins
    hits, everything = scene.intersect(origins, directions), scene.all_hits(origins, directions)
    assert hits.t.dtype == hits.u.dtype == hits.normal.dtype == everything.t.dtype == DOUBLE
    assert (np.isfinite(hits.t) == scene.occluded(origins, directions)).all()
    for i in range(count):
        expected = exact_hits(vertices, faces, origins[i], directions[i])
        found = everything.t[everything.splits[i] : everything.splits[i + 1]]
        assert len(found) == len(expected)
        for t, exact in zip(found, expected, strict=True):
            assert abs(Fraction(float(t)) - exact) <= exact * Fraction(1, 10**13)
        # Triangles that meet in one place differ by rounding, and the lowest of them counts.
        place = [t for t in found if t <= found[0] * (1 + 2e-13)]
        assert hits.t[i] in place if place else np.isinf(hits.t[i])


def test_far_away_is_as_near():
    vertices, faces = cube()
    near, far = gnurt.RayScene(dtype=float), gnurt.RayScene(dtype=np.float64)
    near.add_triangles(vertices, faces)
    far.add_triangles(vertices.astype(float) + 2.0**27, faces)
    # Sums without rounding.
    points = np.random.default_rng(1).integers(-64, 128, size=(500, 3)) / 64
    assert (near.signed_distance(points) == far.signed_distance(points + 2.0**27)).all()
    assert (near.contains(points) == far.contains(points + 2.0**27)).all()
    assert (near.crossings(points, [[1.0, 0.25, 0.5]]) == far.crossings(points + 2.0**27, [[1.0, 0.25, 0.5]])).all()
    at, distance, _, _ = far.closest_point(points + 2.0**27)
    assert np.allclose(at - 2.0**27, near.closest_point(points)[0], atol=1e-7)
    assert (distance == abs(near.signed_distance(points))).all()


def test_instances_and_nested_scenes():
    vertices, faces = cube()
    inner = gnurt.RayScene(dtype="float64")
    mesh = inner.add_triangles(vertices.astype(float), faces)
    shift = np.eye(4)
    shift[:3, 3] = [1e8, 0, 0]
    inner.add_instance(mesh, shift)
    outer = gnurt.RayScene(dtype="float64")
    outer.add_instance(inner, np.diag([1, 1, 2, 1.0]))
    for each in (outer, copy.deepcopy(outer), pickle.loads(pickle.dumps(outer))):
        hits = each.intersect([[1e8 + 0.5, 0.25, -1], [0.5, 0.25, -1], [9, 9, 9]], [[0, 0, 1.0]])
        assert hits.t.tolist() == [1, 1, np.inf]
        assert hits.path.tolist() == [[0, 0], [0, -1], [-1, -1]] and hits.inst_id.tolist() == [0, 0, -1]
        assert hits.normal[0].tolist() == [0, 0, -1] and hits.geom_id.tolist() == [0, 0, -1]
        assert each.dtype == DOUBLE
    outer.update(inst_id=0, transform=np.eye(4))
    assert outer.signed_distance([[1e8 + 0.5, 0.5, 3]])[0] == 2


def test_files_keep_the_type(tmp_path):
    vertices = np.array([[0, 0, 0], [1e8 + 1, 0, 0], [0, 1 / 3, 0]])
    scene = gnurt.RayScene(dtype="float64")
    scene.add_triangles(vertices, [[0, 1, 2]])
    scene.save(tmp_path / "scene")
    loaded = gnurt.RayScene.load(tmp_path / "scene")
    assert loaded.dtype == DOUBLE and (loaded.__getstate__()["meshes"][0][0] == vertices).all()
    assert gnurt.RayScene().dtype == np.float32


def test_types_do_not_mix():
    with pytest.raises(ValueError, match="dtype: float32 or float64, not int8"):
        gnurt.RayScene(dtype="int8")
    with pytest.raises(ValueError, match="a scene of float32 does not go into one of float64"):
        gnurt.RayScene(dtype="float64").add_instance(gnurt.RayScene(), np.eye(4))


def test_no_folds_in_trimesh():
    trimesh = pytest.importorskip("trimesh")
    import gnurt.trimesh

    # Two walls nearer to each other than floats tell apart: with vertices of float32 they meet, and cross.
    mesh = trimesh.creation.box(extents=[1, 1, 3e-8])
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.3, [1, 2, 3]))
    mesh.apply_translation([1234.5678, -765.4321, 99.123])
    rays = gnurt.trimesh.RayMeshIntersector(mesh)
    normal = mesh.face_normals[np.argmax(mesh.area_faces)]
    random = np.random.default_rng(5)
    inside = mesh.triangles_center.mean(axis=0) + 0.2 * np.cross(normal, random.uniform(-1, 1, size=(50, 3)))
    faces, ids = rays.intersects_id(inside - 4 * normal, np.broadcast_to(normal, (50, 3)))
    assert (np.bincount(ids, minlength=50) == 2).all(), "in and out, each once"
    assert rays._scene.dtype == DOUBLE
    assert gnurt.trimesh.RayMeshIntersector(trimesh.creation.box())._scene.dtype == np.float32
