# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads, grids, points and curves of ray scenes, beside closed forms and fine meshes in double precision."""

import copy
import pickle

import numpy as np
import pytest

import gnurt
from conftest import brute_force

#: Weights of a curve's vertices for powers of u; Hermite curves have vertices 0 and 1, then their tangents.
BASES = {
    "linear": np.array([[1, -1, 0, 0], [0, 1, 0, 0]]),
    "bezier": np.array([[1, -3, 3, -1], [0, 3, -6, 3], [0, 0, 3, -3], [0, 0, 0, 1]]),
    "bspline": np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]]) / 6,
    "catmull-rom": np.array([[0, -1, 2, -1], [2, 0, -5, 3], [0, 1, 4, -3], [0, 0, -1, 1]]) / 2,
    "hermite": np.array([[1, 0, -3, 2], [0, 0, 3, -2], [0, 1, -2, 1], [0, 0, -1, 1]]),
}


def random_rays(rng, count=4000, size=3.0):
    origins = rng.normal(size=(count, 3))
    origins *= 2 * size / np.linalg.norm(origins, axis=1, keepdims=True)
    return origins, rng.uniform(-size, size, (count, 3)) * 0.5 - origins


def turned(scale=1.0):
    """A rotation, a scale and a shift."""
    q, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = scale * q, (0.2, -0.1, 0.3)
    return matrix


def through_spheres(centers, radii, origins, directions):
    """Both parameters of each ray and sphere, (2, rays, spheres); inf where they miss."""
    away = origins[:, None] - centers
    a, b = (directions**2).sum(-1)[:, None], (away * directions[:, None]).sum(-1)
    root = b**2 - a * ((away**2).sum(-1) - radii**2)
    with np.errstate(invalid="ignore"):
        ends = (-b + np.array([-1, 1])[:, None, None] * np.sqrt(root)) / a
    return np.where(root >= 0, ends, np.inf)


def test_spheres():
    rng = np.random.default_rng(1)
    centers, radii = rng.uniform(-1.5, 1.5, (50, 3)).astype("f4"), rng.uniform(0.05, 0.5, 50).astype("f4")
    origins, directions = random_rays(rng)
    for matrix in (None, turned(1.7)):
        scene = gnurt.RayScene()
        assert scene.add_points(centers, radii, transform=matrix) == 0
        at, r = centers.astype(float), radii.astype(float)
        if matrix is not None:
            at, r = at @ matrix[:3, :3].T + matrix[:3, 3], r * 1.7
        ends = through_spheres(at, r, origins, directions)
        nearest = np.where(ends[0] >= 0, ends[0], ends[1])
        nearest[nearest < 0] = np.inf
        expected, prim = nearest.min(1), nearest.argmin(1)
        hits = scene.intersect(origins, directions)
        is_hit = np.isfinite(expected)
        assert 500 < is_hit.sum() < 3900
        assert (np.isfinite(hits.t) == is_hit).mean() > 0.999
        both = is_hit & np.isfinite(hits.t)
        assert np.abs(hits.t[both] - expected[both]).max() < 1e-4
        assert (hits.prim_id == prim)[both].mean() > 0.999
        points = origins + directions * expected[:, None]
        with np.errstate(invalid="ignore"):
            normals = (points - at[prim]) / r[prim, None]
        same = both & (hits.prim_id == prim)
        assert np.abs(hits.normal - normals)[same].max() < 0.02
        assert (hits.normal[~np.isfinite(hits.t)] == 0).all()
        assert (hits.u == 0).all() and (hits.v == 0).all()
        assert (scene.occluded(origins, directions) == np.isfinite(hits.t)).all()
        crossed = ((ends >= 0) & np.isfinite(ends)).sum((0, 2))
        assert (scene.crossings(origins, directions) == crossed).mean() > 0.998
        listed = scene.all_hits(origins, directions)
        assert (np.diff(listed.splits) == crossed).mean() > 0.998
        # Points.
        query = rng.uniform(-2, 2, (3000, 3))
        off = np.linalg.norm(query[:, None] - at, axis=-1) - r
        found, distances, prims, geoms = scene.closest_point(query)
        assert np.abs(distances - np.abs(off).min(1)).max() < 1e-5
        assert (prims == np.abs(off).argmin(1)).mean() > 0.999 and (geoms == 0).all()
        assert np.abs(np.linalg.norm(found - at[prims], axis=1) - r[prims]).max() < 1e-5
        assert (scene.contains(query) == (off <= 0).any(1)).mean() > 0.9995
        assert (np.sign(scene.signed_distance(query)) == np.where((off <= 0).any(1), -1, 1)).mean() > 0.9995


def test_quads():
    rng = np.random.default_rng(2)
    vertices = rng.uniform(-1, 1, (40, 1, 3)) + 0.4 * rng.normal(size=(40, 4, 3))
    vertices = vertices.astype("f4").reshape(-1, 3)
    faces = np.arange(160).reshape(40, 4)
    faces[0, 3] = faces[0, 2]
    origins, directions = random_rays(rng)
    scene = gnurt.RayScene()
    scene.add_quads(vertices, faces)
    halves = np.concatenate([faces[:, [0, 1, 3]], faces[:, [2, 3, 1]]])
    # The first one is a triangle.
    halves[40] = halves[0]
    ts = brute_force(vertices.astype(float), halves, origins, directions)
    expected, half = ts.min(1), ts.argmin(1)
    hits = scene.intersect(origins, directions)
    both = np.isfinite(expected) & np.isfinite(hits.t)
    assert (np.isfinite(expected) == np.isfinite(hits.t)).mean() > 0.999 and both.sum() > 500
    assert np.abs(hits.t[both] - expected[both]).max() < 1e-4
    same = both & (hits.prim_id == half % 40)
    assert same.sum() / both.sum() > 0.999
    # The point by u and v of each half, which is linear.
    a, b, c, d = (vertices.astype(float)[faces[hits.prim_id, k]] for k in range(4))
    u, v = hits.u[:, None].astype(float), hits.v[:, None].astype(float)
    point = np.where(half[:, None] < 40, a + u * (b - a) + v * (d - a), c + (1 - u) * (d - c) + (1 - v) * (b - c))
    assert np.abs(point - origins - directions * expected[:, None])[same].max() < 1e-3
    corners = vertices.astype(float)[halves[half]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
    assert np.abs(hits.normal - normal)[same].max() < 1e-4
    assert (scene.occluded(origins, directions) == np.isfinite(hits.t)).all()
    # Any affine map of a mesh is valid.
    squeezed = np.diag([1.0, 0.5, 2.0, 1.0])
    other = gnurt.RayScene()
    other.add_quads(vertices * [1, 0.5, 2], faces)
    scene.update(0, transform=squeezed)
    assert np.allclose(scene.intersect(origins, directions).t, other.intersect(origins, directions).t, rtol=1e-4)


def cells(grids):
    """The quads of all cells, in the order of their numbers."""
    return np.array(
        [
            [first + y * stride + x + k for k in (0, 1, stride + 1, stride)]
            for first, stride, columns, rows in grids
            for y in range(rows - 1)
            for x in range(columns - 1)
        ]
    )


def test_grids():
    """Bit for bit the same as the cells as quads."""
    rng = np.random.default_rng(21)
    x, y = np.meshgrid(np.linspace(-1.5, 1.5, 30), np.linspace(-1.5, 1.5, 20))
    vertices = np.stack([x, y, 0.2 * rng.normal(size=x.shape)], -1).reshape(-1, 3).astype("f4")
    # All but the last columns; a part of the vertices once more, in a sparser grid; one cell.
    grids = np.array([[0, 30, 29, 20], [3, 60, 5, 9], [568, 30, 2, 2]])
    origins, directions = random_rays(rng)
    for matrix in (None, np.diag([1, 0.7, 2, 1])):
        for dtype in ("int64", "uint32"):
            ours, theirs = gnurt.RayScene(), gnurt.RayScene()
            assert ours.add_grids(vertices, grids.astype(dtype), transform=matrix, copy=False) == 0
            theirs.add_quads(vertices, cells(grids), transform=matrix)
            for step in range(2):
                hits, expected = ours.intersect(origins, directions), theirs.intersect(origins, directions)
                assert np.isfinite(expected.t).sum() > 500 and len(np.unique(expected.prim_id)) > 300
                for name in ("t", "u", "v", "prim_id", "geom_id", "normal"):
                    assert np.array_equal(getattr(hits, name), getattr(expected, name)), name
                assert np.array_equal(ours.occluded(origins, directions), np.isfinite(expected.t))
                for scene in (ours, theirs):
                    scene.update(0, vertices=vertices * [1, 1, -2])
    assert np.allclose(ours.distance(origins), theirs.distance(origins), rtol=1e-6)


@pytest.mark.parametrize("form", ["flat", "oriented"])
def test_discs(form):
    rng = np.random.default_rng(3)
    centers, radii = rng.uniform(-1.5, 1.5, (60, 3)), rng.uniform(0.05, 0.5, 60)
    centers, radii = centers.astype("f4").astype(float), radii.astype("f4").astype(float)
    normals = rng.normal(size=(60, 3)).astype("f4").astype(float)
    origins, directions = random_rays(rng)
    matrix, scale = turned(0.6), 0.6
    scene = gnurt.RayScene()
    scene.add_points(centers, radii, transform=matrix, form=form, normals=normals if form == "oriented" else None)
    at, r, n = centers @ matrix[:3, :3].T + matrix[:3, 3], radii * scale, normals @ matrix[:3, :3].T
    across = directions[:, None] if form == "flat" else np.broadcast_to(n, (len(origins), 60, 3))
    t = ((at - origins[:, None]) * across).sum(-1) / (directions[:, None] * across).sum(-1)
    off = np.linalg.norm(origins[:, None] + t[..., None] * directions[:, None] - at, axis=-1)
    t = np.where((off <= r) & (t >= 0), t, np.inf)
    hits = scene.intersect(origins, directions)
    both = np.isfinite(t.min(1)) & np.isfinite(hits.t)
    assert (np.isfinite(t.min(1)) == np.isfinite(hits.t)).mean() > 0.999 and both.sum() > 400
    assert np.abs(hits.t[both] - t.min(1)[both]).max() < 1e-4
    assert (hits.prim_id == t.argmin(1))[both].mean() > 0.999
    if form == "flat":
        assert (hits.normal == 0).all(), "they face the ray"
    else:
        unit = n / np.linalg.norm(n, axis=1, keepdims=True)
        assert np.abs(hits.normal - unit[hits.prim_id])[both].max() < 1e-5
    assert not scene.contains(at).any(), "they enclose nothing"


def strand(rng, basis, curves=6):
    """Vertices and radii of one strand with this many curves, tangents of Hermite ones, and vertices of each curve."""
    order, step = (2, 1) if basis in ("linear", "hermite") else (4, 3 if basis == "bezier" else 1)
    count = order + (curves - 1) * step
    along = np.linspace(-2, 2, count)
    vertices = np.stack([along, 0.4 * np.sin(2 * along), 0.3 * np.cos(3 * along)], 1) + rng.normal(0, 0.03, (count, 3))
    radii = rng.uniform(0.05, 0.1, count)
    tangents = None
    if basis == "hermite":
        tangents = np.concatenate([np.gradient(vertices, axis=0), rng.normal(0, 0.01, (count, 1))], 1).astype("f4")
    rows = np.arange(curves)[:, None] * step + np.arange(order)
    return vertices.astype("f4"), radii.astype("f4"), tangents, rows


def controls(rows, values, tangents, basis):
    """What the weights of a basis are of, (curves, 4 or 2, k)."""
    picked = np.asarray(values, float)[rows]
    return np.concatenate([picked, np.asarray(tangents, float)[rows]], 1) if basis == "hermite" else picked


def along(basis, control, u):
    """Points and derivatives (curves, len(u), k)."""
    powers = u[:, None] ** np.arange(4)
    slopes = np.arange(4) * u[:, None] ** np.maximum(np.arange(4) - 1, 0)
    weights = BASES[basis]
    return tuple(np.einsum("nk,pk,cpx->cnx", some, weights, control) for some in (powers, slopes))


def ring_mesh(rings):
    """Triangles between neighbours of a table of points (n, m, 3)."""
    n, m, _ = rings.shape
    i, j = np.meshgrid(np.arange(n - 1), np.arange(m - 1), indexing="ij")
    a = (i * m + j).ravel()
    return rings.reshape(-1, 3), np.concatenate([np.stack([a, a + 1, a + m], 1), np.stack([a + 1, a + m + 1, a + m], 1)])


@pytest.mark.parametrize("basis", ["bezier", "bspline", "catmull-rom", "hermite", "linear"])
@pytest.mark.parametrize("form", ["round", "oriented"])
def test_curves_are_those_of_fine_meshes(basis, form):
    if basis == "linear" and form == "round":
        pytest.skip("cones with spheres at their ends: test_straight_tubes")
    rng = np.random.default_rng(4)
    vertices, radii, tangents, rows = strand(rng, basis)
    normals, normal_tangents = None, None
    if form == "oriented":
        normals = (rng.normal(0, 0.2, vertices.shape) + [0, 0, 1]).astype("f4")
        normal_tangents = rng.normal(0, 0.1, vertices.shape).astype("f4") if basis == "hermite" else None
    scene = gnurt.RayScene()
    given = {"normals": normals, "tangents": tangents, "normal_tangents": normal_tangents}
    scene.add_curves(vertices, radii, basis=basis, form=form, **given)

    u = np.linspace(0, 1, 101)
    point, slope = along(basis, controls(rows, np.column_stack([vertices, radii]), tangents, basis), u)
    middle, r, way = point[..., :3], point[..., 3:], slope[..., :3]
    way = way / np.linalg.norm(way, axis=-1, keepdims=True)
    if form == "round":
        side = np.cross(way, [0.3, 0.2, 1.0])
        side /= np.linalg.norm(side, axis=-1, keepdims=True)
        angle = np.linspace(0, 2 * np.pi, 97)[:, None]
        ring = np.cos(angle) * side[..., None, :] + np.sin(angle) * np.cross(way, side)[..., None, :]
    else:
        upright, _ = along(basis, controls(rows, normals, normal_tangents, basis), u)
        side = np.cross(way, upright)
        side /= np.linalg.norm(side, axis=-1, keepdims=True)
        ring = np.linspace(-1, 1, 9)[:, None] * side[..., None, :]
    surface = middle[..., None, :] + r[..., None] * ring
    fine = gnurt.RayScene()
    for rings in surface:
        fine.add_triangles(*ring_mesh(rings))

    origins = rng.normal(size=(20000, 3)) * [1, 0.2, 0.2]
    origins = origins + [0, 0, 5] if form == "oriented" else origins + 4 * rng.choice([-1, 1], (20000, 1)) * [0, 1, 1]
    targets = middle.reshape(-1, 3)[rng.integers(0, middle.size // 3, 20000)] + rng.normal(0, 0.06, (20000, 3))
    hits, expected = scene.intersect(origins, targets - origins), fine.intersect(origins, targets - origins)
    is_hit = hits.prim_id >= 0
    assert is_hit.sum() > 5000
    assert (is_hit == (expected.prim_id >= 0)).mean() > 0.995
    both = is_hit & (expected.prim_id >= 0)
    close = np.isclose(hits.t, expected.t, rtol=0, atol=2e-3)
    assert close[both].mean() > 0.995, "distances"
    both &= close
    # The mesh has a geometry for each curve.
    assert (hits.prim_id == expected.geom_id)[both].mean() > 0.995
    facing = np.abs((hits.normal * expected.normal).sum(1))
    assert np.quantile(facing[both], 0.02) > 0.98, "normals"
    assert np.allclose(np.linalg.norm(hits.normal[is_hit], axis=1), 1, atol=1e-5)
    along_fine = (expected.prim_id % (100 * (ring.shape[-2] - 1)) // (ring.shape[-2] - 1)) / 100 + 0.005
    near = both & (hits.prim_id == expected.geom_id)
    assert np.abs(hits.u - along_fine)[near].max() < 0.05, "how far along the curve"
    if form == "round":
        assert (hits.v == 0).all()
    else:
        assert 0 <= hits.v.min() and 0.9 < hits.v.max() <= 1
    assert (scene.occluded(origins, targets - origins) == is_hit).all()


@pytest.mark.parametrize("basis", list(BASES))
def test_ribbons_face_rays(basis):
    rng = np.random.default_rng(6)
    vertices, radii, tangents, rows = strand(rng, basis)
    scene = gnurt.RayScene()
    scene.add_curves(vertices, radii, basis=basis, form="flat", tangents=tangents)
    u = np.linspace(0, 1, 301)
    point, _ = along(basis, controls(rows, np.column_stack([vertices, radii]), tangents, basis), u)
    point = point.reshape(-1, 4)
    origins = rng.normal(size=(5000, 3)) * [1, 0.2, 0.2] + [0, 0, 6]
    targets = point[rng.integers(30, len(point) - 30, 5000), :3] + rng.normal(0, 0.08, (5000, 3))
    ways = (targets - origins) / np.linalg.norm(targets - origins, axis=1, keepdims=True)
    from_origin = point[:, :3] - origins[:, None]
    t = (from_origin * ways[:, None]).sum(-1)
    gap = np.linalg.norm(from_origin - t[..., None] * ways[:, None], axis=-1) - point[:, 3]
    # Bent ribbons end across: where they do or have a kink, points beyond the end are none of them.
    inner = (gap.min(1) < -0.004) & ((gap.argmin(1) + 8) % 301 > 16)
    outer = gap.min(1) > 0.004
    hits = scene.intersect(origins, ways)
    assert 1000 < inner.sum() and 500 < outer.sum()
    assert np.isfinite(hits.t[inner]).all() and np.isinf(hits.t[outer]).all()
    # Hits lie as far along the ray as the curve there.
    found = along(basis, controls(rows, vertices, None if tangents is None else tangents[:, :3], basis), hits.u[inner].astype(float))[0]
    found = found[hits.prim_id[inner], np.arange(inner.sum())]
    assert np.abs(hits.t[inner] - ((found - origins[inner]) * ways[inner]).sum(1)).max() < 0.02
    assert (np.abs(hits.v) <= 1).all() and (hits.normal == 0).all()


def test_straight_tubes():
    """Of one radius: all that is as near to the line of vertices."""
    rng = np.random.default_rng(7)
    vertices = np.array([[-1.5, 0, 0], [-0.3, 0.8, 0.1], [0.6, -0.4, 0.3], [1.5, 0.2, -0.2]]).astype("f4")
    scene = gnurt.RayScene()
    scene.add_curves(vertices, 0.15, basis="linear")
    a, b = vertices[:-1].astype(float), vertices[1:].astype(float)

    def distance(points):
        off = points[..., None, :] - a
        share = np.clip((off * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0, 1)
        return np.linalg.norm(off - share[..., None] * (b - a), axis=-1).min(-1)

    origins, directions = random_rays(rng)
    hits = scene.intersect(origins, directions)
    is_hit = np.isfinite(hits.t)
    assert 200 < is_hit.sum()
    points = origins + directions * np.where(is_hit, hits.t, 0)[:, None]
    assert np.abs(distance(points[is_hit]) - 0.15).max() < 1e-4
    steps = np.linspace(0, 2, 400)[:, None, None]
    gaps = distance(origins + directions * steps)
    # Nothing is inside before the hit, and rays that miss come nowhere near.
    before = steps[..., 0] < np.where(is_hit, hits.t, np.inf) - 0.001
    assert np.where(before, gaps, 1).min() > 0.1499
    # Within, parts of the balls around vertices count.
    query = rng.uniform(-2, 2, (1000, 3))
    query = query[distance(query) > 0.15]
    assert np.abs(scene.distance(query) - distance(query) + 0.15).max() < 1e-5


def test_strands():
    rng = np.random.default_rng(8)
    vertices = rng.normal(size=(17, 3))
    origins, directions = random_rays(rng, 2000, 2.0)

    def hits(**given):
        scene = gnurt.RayScene()
        scene.add_curves(vertices, 0.2, **given)
        found = scene.intersect(origins, directions)
        return found.t, found.prim_id

    for basis, counts, segments in (
        ("bspline", [6, 0, 4, 7], [0, 1, 2, 6, 10, 11, 12, 13]),
        ("bezier", [7, 10], [0, 3, 7, 10, 13]),
        ("linear", [2, 3, 12], [0, 2, 3, *range(5, 16)]),
        ("catmull-rom", None, list(range(14))),
    ):
        ours, theirs = hits(basis=basis, counts=counts), hits(basis=basis, segments=np.array(segments))
        assert np.array_equal(ours, theirs) and len(np.unique(ours[1])) > len(segments) // 2
    assert (hits(segments=[])[1] == -1).all()


def everything():
    rng = np.random.default_rng(9)
    scene = gnurt.RayScene()
    vertices = rng.normal(size=(12, 3))
    normals, tangents = rng.normal(size=(12, 3)), rng.normal(size=(12, 4))
    scene.add_triangles(vertices, np.arange(12).reshape(4, 3))
    scene.add_quads(vertices + 1, np.arange(12).reshape(3, 4), transform=np.diag([1, 2, 1, 1]))
    scene.add_points(vertices - 1, 0.2)
    scene.add_points(vertices, np.full(12, 0.3), form="flat", transform=turned(2))
    scene.add_points(vertices, 0.3, form="oriented", normals=normals)
    scene.add_curves(vertices, 0.1)
    scene.add_curves(
        vertices, 0.1, basis="hermite", form="oriented", normals=normals, tangents=tangents, normal_tangents=normals
    )
    scene.add_grids(vertices * [1, 1, 0.2] + [0, 0, 2], [[0, 4, 4, 3]], transform=np.diag([1, 1, 2, 1]))
    scene.remove(scene.add_points(vertices, 1))
    scene.add_instance(5, np.diag([1, 1, 3, 1]))
    return scene


def test_kept(tmp_path):
    scene = everything()
    rays = random_rays(np.random.default_rng(10), 3000)
    expected = scene.intersect(*rays)
    assert set(expected.geom_id) == {-1, *range(8)} and set(expected.inst_id) == {-1, 0}
    scene.save(tmp_path / "a.rays")
    outer = gnurt.RayScene()
    outer.add_instance(scene, np.eye(4))
    outer.save(tmp_path / "b.rays")
    others = [pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene)]
    others += [gnurt.RayScene.load(tmp_path / name) for name in ("a.rays", "b.rays")]
    for other in others:
        for threads in (1, 0):
            hits = other.intersect(*rays, threads=threads)
            for name in ("t", "prim_id", "geom_id", "u", "v", "normal"):
                assert np.array_equal(getattr(hits, name), getattr(expected, name)), name
    hits = pickle.loads(pickle.dumps(expected))
    assert np.array_equal(hits.normal, expected.normal)


def test_updates():
    scene, rays = everything(), random_rays(np.random.default_rng(11), 3000)
    scene.intersect(*rays)
    rng = np.random.default_rng(9)
    vertices = rng.normal(size=(12, 3))
    for number in range(8):
        scene.update(number, vertices=vertices * 0.5 + number / 4)
    scene.update(2, transform=turned(1.5))
    fresh = pickle.loads(pickle.dumps(scene))
    ours, theirs = scene.intersect(*rays), fresh.intersect(*rays)
    assert np.array_equal(ours.t, theirs.t) and np.array_equal(ours.geom_id, theirs.geom_id)


def test_instances_squeeze():
    """Ellipsoids by instances of a sphere, which stands out of the way."""
    ball, scene = gnurt.RayScene(), gnurt.RayScene()
    ball.add_points([[0, 0, 0]], 1.0)
    squeeze = np.diag([1.0, 2.0, 0.5, 1.0])
    scene.add_instance(ball, squeeze)
    origins, directions = random_rays(np.random.default_rng(12))
    inverse = np.linalg.inv(squeeze)[:3, :3]
    ends = through_spheres(np.zeros((1, 3)), np.ones(1), origins @ inverse.T, directions @ inverse.T)
    hits = scene.intersect(origins, directions)
    both = np.isfinite(ends[0, :, 0]) & np.isfinite(hits.t)
    assert (np.isfinite(ends[0, :, 0]) == np.isfinite(hits.t)).mean() > 0.999 and both.sum() > 300
    assert np.abs(ends[0, both, 0] - hits.t[both]).max() < 1e-4
    normal = (origins + directions * np.where(both, hits.t, 0)[:, None]) * [1, 1 / 4, 4]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.abs(normal - hits.normal)[both].max() < 2e-3


FOUR = np.arange(12.0).reshape(4, 3) ** 1.5
WRONG = [
    (lambda s: s.add_quads(FOUR, [[0, 1, 2]]), ValueError, r"faces: expected shape \(m, 4\), not \(1, 3\)"),
    (lambda s: s.add_quads(FOUR, [[0, 1, 2, 4]]), ValueError, "faces: row 0 names vertex 4, and there are 4"),
    (lambda s: s.add_grids(FOUR, [[0, 2, 2]]), ValueError, r"grids: expected shape \(m, 4\), not \(1, 3\)"),
    (lambda s: s.add_grids(FOUR, [[0, 2, 2, 2], [0, 3, 2, 2]]), ValueError, "grids: row 1 takes vertex 4, and there are 4"),
    (lambda s: s.add_grids(FOUR, [[0, 2, 1, 2]]), ValueError, "grids: row 0 has 1 columns of vertices; valid are 2 to 65535"),
    (lambda s: s.add_grids(FOUR, [[0, 2, 2, 65536]]), ValueError, "grids: row 0 has 65536 rows of vertices"),
    (lambda s: s.add_grids(FOUR, [[-1, 2, 2, 2]]), ValueError, "grids: row 0 has first vertex -1 and stride 2"),
    (lambda s: s.add_grids(FOUR, [[2**62, 2**62, 2, 2]]), ValueError, "grids: row 0 takes vertex"),
    (lambda s: s.add_grids(FOUR, [[0, 2, 2, 1.5]]), TypeError, "grids: expected whole numbers"),
    (lambda s: s.add_points(FOUR, [1, 2]), ValueError, r"radii: expected one number or shape \(4,\).*not \(2,\)"),
    (lambda s: s.add_points(FOUR, [1.0]), ValueError, r"radii: .*not \(1,\)"),
    (lambda s: s.add_points(FOUR, [1, 2, -3, 4]), ValueError, "radii: row 2 is -3; expected finite numbers from 0 on"),
    (lambda s: s.add_points(FOUR, np.nan), ValueError, "radii: row 0 is NaN"),
    (lambda s: s.add_points(FOUR, "wide"), TypeError, "radii: expected numbers"),
    (lambda s: s.add_points(FOUR, 1, form="cube"), ValueError, 'form: invalid: "cube"; valid are: "round", "flat", "orie'),
    (lambda s: s.add_points(FOUR, 1, form="oriented"), TypeError, 'normals: missing; form="oriented" needs them'),
    (lambda s: s.add_points(FOUR, 1, normals=FOUR), ValueError, 'normals: valid with form="oriented" only'),
    (lambda s: s.add_points(FOUR, 1, form="oriented", normals=FOUR[:2]), ValueError, r"normals: .*\(4, 3\), a row for"),
    (lambda s: s.add_points(FOUR, 1, transform=np.diag([1, 2, 1, 1])), ValueError, "transform: .*same scale.*add_instance"),
    (lambda s: s.add_curves(FOUR, 1, basis="nurbs"), ValueError, 'basis: invalid: "nurbs"; valid are: "linear"'),
    (lambda s: s.add_curves(FOUR, 1, form="square"), ValueError, 'form: invalid: "square"'),
    (lambda s: s.add_curves(FOUR, 1, counts=[4], segments=[0]), TypeError, "segments: valid without counts only"),
    (lambda s: s.add_curves(FOUR, 1, segments=[0, 1]), ValueError, "segments: row 1 starts at vertex 1 and takes 4, and"),
    (lambda s: s.add_curves(FOUR, 1, segments=[-1]), ValueError, "segments: row 0 starts at vertex -1"),
    (lambda s: s.add_curves(FOUR, 1, segments=[2**62]), ValueError, "segments: row 0"),
    (lambda s: s.add_curves(FOUR, 1, segments=[0.5]), TypeError, "segments: expected whole numbers"),
    (lambda s: s.add_curves(FOUR, 1, counts=[5, -1]), ValueError, "counts: expected numbers from 0 on whose sum is 4"),
    (lambda s: s.add_curves(FOUR, 1, counts=[3, 1]), ValueError, "counts: row 0 is 3; .*4 vertices or more"),
    (lambda s: s.add_curves(FOUR[:3], 1, basis="bezier"), ValueError, "counts: row 0 is 3; .*4 vertices plus a multiple of 3"),
    (lambda s: s.add_curves(FOUR, 1, basis="hermite"), TypeError, 'tangents: missing; basis="hermite" needs them'),
    (lambda s: s.add_curves(FOUR, 1, tangents=np.zeros((4, 4))), ValueError, 'tangents: valid with basis="hermite" only'),
    (lambda s: s.add_curves(FOUR, 1, basis="hermite", tangents=FOUR), ValueError, r"tangents: expected shape \(n, 4\)"),
    (lambda s: s.add_curves(FOUR, 1, form="oriented"), TypeError, "normals: missing"),
    (lambda s: s.add_curves(FOUR, 1, transform=np.diag([1, 2, 1, 1])), ValueError, "transform: .*same scale"),
    (lambda s: s.update(s.add_curves(FOUR, 1), transform=np.diag([1, 2, 1, 1])), ValueError, "transform: .*same scale"),
    (lambda s: s.update(s.add_points(FOUR, 1), vertices=FOUR[:3]), ValueError, r"vertices: expected shape \(4, 3\)"),
    (lambda s: [s.add_curves(FOUR, 1), s.contains(FOUR)], TypeError, "contains: the scene has curves, which enclose nothing"),
    (lambda s: [s.add_curves(FOUR, 1), s.signed_distance(FOUR)], TypeError, "signed_distance: the scene has curves"),
]


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_wrong(number):
    call, kind, message = WRONG[number]
    with pytest.raises(kind, match=message):
        call(gnurt.RayScene())


def test_doubles_have_triangles_only():
    scene = gnurt.RayScene(dtype="float64")
    for call in (
        lambda: scene.add_quads(FOUR, [[0, 1, 2, 3]]),
        lambda: scene.add_grids(FOUR, [[0, 2, 2, 2]]),
        lambda: scene.add_points(FOUR, 1),
        lambda: scene.add_curves(FOUR, 1),
    ):
        with pytest.raises(TypeError, match="unsupported in a scene of float64, which has triangles only"):
            call()
    state = everything().__getstate__()
    state["dtype"] = "float64"
    with pytest.raises(ValueError, match="triangles only"):
        scene.__setstate__(state)


def test_damaged_states():
    state = everything().__getstate__()
    for name, value in (("kind", "cubes"), ("radii", None), ("form", "square"), ("vertices", [[1, 2]])):
        damaged = {**state, "meshes": [dict(state["meshes"][2])], "instances": []}
        if value is None:
            del damaged["meshes"][0][name]
        else:
            damaged["meshes"][0][name] = value
        with pytest.raises(ValueError, match=name):
            gnurt.RayScene().__setstate__(damaged)
