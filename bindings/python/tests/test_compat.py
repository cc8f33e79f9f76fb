# SPDX-License-Identifier: GPL-3.0-or-later
import subprocess
import sys

import numpy as np
import pytest

import gnurt.compat
import gnurt.igl
import gnurt.open3d
from conftest import brute_force, cube


def test_embreex(rays):
    sys.modules.pop("embreex", None)
    gnurt.compat.install_embreex()
    from embreex.mesh_construction import ElementMesh, TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    vertices, faces = cube()
    expected = brute_force(vertices, faces, *rays).min(axis=1)
    scene, soup = EmbreeScene(), EmbreeScene()
    TriangleMesh(scene, vertices, faces)
    TriangleMesh(soup, vertices[faces])
    rays = [a.astype(np.float32) for a in rays]
    found = scene.run(*rays, query="DISTANCE")
    assert np.allclose(np.where(found > 1e36, np.inf, found), expected, rtol=1e-4)
    assert (scene.run(*rays) == soup.run(*rays)).all()
    assert ((scene.run(*rays, query="OCCLUDED") == 0) == np.isfinite(expected)).all()
    far = np.full(1000, 1e37, np.float32)
    assert set(scene.run(*rays, dists=far, output=1)) == {"u", "v", "Ng", "tfar", "primID", "geomID"}
    assert (far == found).all(), "far ends are written in place"
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    prims = scene.run(*rays)
    across = np.where(prims[:, None] >= 0, np.cross(b - a, c - a)[prims], 0)
    twice = EmbreeScene()
    TriangleMesh(twice, 2 * vertices, faces)
    for asked, scale in ((scene, 1), (soup, 1), (twice, 2)):
        normals = asked.run(scale * rays[0], rays[1], output=1)["Ng"]
        assert (normals == scale**2 * across).all(), "not of length 1, as Embree's"
    bricks = EmbreeScene()
    ElementMesh(bricks, vertices, np.array([[0, 1, 3, 2, 4, 5, 7, 6]]))
    assert np.allclose(bricks.run(*rays, query="DISTANCE"), found)
    with pytest.raises(ValueError, match="vec_origins: expected float32"):
        scene.run(np.zeros((1, 3)), rays[1])


def test_open3d(rays):
    vertices, faces = cube()
    scene = gnurt.open3d.RaycastingScene()
    scene.add_triangles(vertices.astype(np.float32), faces.astype(np.uint32))
    picture = scene.create_rays_pinhole(60, [0.5, 0.5, 0.5], [0.5, 0.5, 4], [0, 1, 0], 8, 6)
    # As Open3D 0.20 has them: rows go up, and columns to the left.
    corners = [[0.5, 0.5, 4, 0.5051815, -0.3608439, -1], [0.5, 0.5, 4, -0.5051815, 0.3608439, -1]]
    assert np.allclose(picture[[0, -1], [0, -1]], corners)
    other = scene.create_rays_pinhole(
        fov_deg=70, center=[1, 2, 3], eye=[3, 1, 7], up=[0, 0.3, 1], width_px=6, height_px=9
    )
    assert other.shape == (9, 6, 6)
    assert np.allclose(other[0, 0], [3, 1, 7, 0.4838348, -0.06870875, -1.4047385])
    assert np.allclose(other[-1, -1], [3, 1, 7, -1.3567065, 0.5051446, -0.34100458])
    turned = [[np.cos(0.3), -np.sin(0.3), 0, 1], [np.sin(0.3), np.cos(0.3), 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    matrices = scene.create_rays_pinhole([[10, 0.3, 4], [0, 12, 3], [0, 0, 1]], turned, 8, 6)
    assert np.allclose(matrices[0, 0], [-1.546377, -1.6151527, -3, -0.38996363, -0.09744336, 1])
    hits = scene.cast_rays(picture)
    assert hits["t_hit"].shape == (6, 8) and hits["primitive_uvs"].shape == (6, 8, 2)
    assert hits["primitive_ids"][0, 0] == scene.INVALID_ID and np.isclose(hits["t_hit"][3, 4], 3)
    assert (scene.count_intersections(picture) == 2 * np.isfinite(hits["t_hit"])).all()
    points = np.float32([[[0.5, 0.5, 0.75], [0.25, 0.5, 3]]])
    assert scene.compute_signed_distance(points, nsamples=3).tolist() == [[-0.25, 2]]
    near = scene.compute_closest_points(points)
    assert near["points"].tolist() == [[[0.5, 0.5, 1], [0.25, 0.5, 1]]]
    assert near["primitive_normals"].tolist() == [[[0, 0, 1]] * 2]
    u, v = np.moveaxis(near["primitive_uvs"][0], -1, 0)[..., None]
    a, b, c = np.moveaxis(vertices[faces[near["primitive_ids"][0]]], 1, 0)
    assert np.allclose((1 - u - v) * a + u * b + v * c, near["points"][0])
    assert np.isnan(gnurt.open3d.RaycastingScene().compute_closest_points(points)["points"]).all()
    assert scene.list_intersections(picture)["ray_splits"].shape == (49,)
    diagonal = scene.list_intersections(np.float32([[0.5, 0.5, -1, 0, 0, 1]]))
    assert np.allclose(diagonal["t_hit"], [1, 2]), "once, where two triangles meet"


def test_igl():
    vertices, faces = cube()
    hits = gnurt.igl.ray_mesh_intersect([0.25, 0.3, 3], [0, 0, -1], vertices, faces)
    assert [round(t, 6) for _, t, _, _ in hits] == [2, 3]
    distances, triangles, points, normals = gnurt.igl.signed_distance([[0.5, 0.4, 0.9]], vertices, faces)
    assert np.allclose(distances, -0.1) and np.allclose(points, [[0.5, 0.4, 1]]) and np.allclose(normals, [[0, 0, 1]])
    for points, of in ([[0.5, 0.4, 0.9]], faces[:0]), ([[np.nan, 0, 0]], faces):
        _, triangles, _, normals = gnurt.igl.signed_distance(points, vertices, of)
        assert triangles.tolist() == [-1] and normals.tolist() == [[0, 0, 0]], "none is nearest"


def test_trimesh(rays):
    trimesh = pytest.importorskip("trimesh")
    import gnurt.trimesh

    mesh = trimesh.Trimesh(*cube(), process=False)
    mesh.ray = gnurt.trimesh.RayMeshIntersector(mesh)
    expected = brute_force(*cube(), *rays).min(axis=1)
    assert (mesh.ray.intersects_any(*rays) == np.isfinite(expected)).all()
    locations, index_ray, _ = mesh.ray.intersects_location(*rays)
    counts = gnurt.igl._scene(*cube()).crossings(*rays)
    assert (np.bincount(index_ray, minlength=1000) == counts).all() and locations.shape == (counts.sum(), 3)
    assert mesh.ray.contains_points([[0.5, 0.5, 0.5], [2, 0, 0]]).tolist() == [True, False]


@pytest.mark.parametrize("before", ["", "import trimesh", "import trimesh.ray", "gnurt.trimesh.install()"])
def test_installing_in_trimesh(before):
    """Without embreex, whatever is installed here; before and after trimesh is imported, and twice."""
    pytest.importorskip("trimesh")
    program = f"""
import sys
sys.modules["embreex"] = None
import gnurt.trimesh
{before}
try:
    from trimesh.ray.ray_pyembree import RayMeshIntersector
except ImportError:
    pass
gnurt.trimesh.install()
from trimesh.ray.ray_pyembree import RayMeshIntersector
import trimesh
import trimesh.ray.ray_pyembree as module
assert RayMeshIntersector is gnurt.trimesh.RayMeshIntersector
assert module is trimesh.ray.ray_pyembree is gnurt.trimesh and trimesh.ray.has_embree
mesh = trimesh.creation.box()
assert type(mesh.ray) is RayMeshIntersector and mesh.ray.intersects_any([[0, 0, 3]], [[0, 0, -1]]).tolist() == [True]
assert mesh.contains([[0, 0, 0], [0, 0, 1]]).tolist() == [True, False]
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
