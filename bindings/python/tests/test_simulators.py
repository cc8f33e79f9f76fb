# SPDX-License-Identifier: GPL-3.0-or-later
"""Stand-ins for parts of programs that simulate buildings and robots."""

from types import SimpleNamespace

import numpy as np
import pytest

from conftest import cube
from gnurt import ladybug, mujoco_lidar


def test_ladybug():
    quad = SimpleNamespace(vertices=[(0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)], faces=[(0, 1, 2, 3)])
    roof = SimpleNamespace(triangulated_mesh3d=quad)
    points, normals = [(1, 1, 0), (5, 5, 0), (1, 1, 1)], [(0, 0, 1)] * 3
    vectors = [(0, 0, 1), (0, 0, -1), (4, 0, 3)]
    expected = [[False, False, True], [True, False, True], [True, False, True]]
    seen = ladybug.intersection_matrix(vectors, points, normals, [roof])
    assert seen.dtype == bool and seen.tolist() == expected, "under the roof, beside it, in it"
    cosines = ladybug.intersection_matrix(vectors, points, normals, [roof], offset_distance=-0.25, numericalize=True)
    assert np.allclose(cosines, [[0, 0, 0.6], [1, 0, 0.6], [0, 0, 0]])
    assert ladybug.intersection_matrix(vectors, points, normals, []).sum() == 6
    assert ladybug.intersection_matrix([], points, normals, [quad]).shape == (3, 0)


def test_ladybug_radiance():
    radiance = pytest.importorskip("ladybug_radiance")
    import ladybug_radiance.intersection

    before = radiance.intersection.intersection_matrix
    ladybug.install()
    assert radiance.intersection.intersection_matrix is ladybug.intersection_matrix is not before
    radiance.intersection.intersection_matrix = before


def model(**given):
    """A floor, a ball, a cube of a mesh twice, a ball that nobody sees."""
    vertices, faces = cube()
    kinds = [0, 2, 7, 7, 2]
    n = len(kinds)
    made = {
        "ngeom": n,
        "geom_type": np.array(kinds),
        "geom_dataid": np.array([-1, -1, 0, 0, -1]),
        "geom_matid": np.full(n, -1),
        "geom_rgba": np.array([[1, 1, 1, 1]] * (n - 1) + [[1, 1, 1, 0]]),
        "geom_bodyid": np.arange(n),
        "geom_group": np.array([0, 0, 0, 7, 0]),
        "geom_size": np.array([[0, 0, 1], [1, 0, 0], [0, 0, 0], [0, 0, 0], [0.5, 0, 0]], float),
        "mesh_vertadr": np.array([0]),
        "mesh_vertnum": np.array([len(vertices)]),
        "mesh_faceadr": np.array([0]),
        "mesh_facenum": np.array([len(faces)]),
        "mesh_vert": vertices,
        "mesh_face": faces,
    }
    places = np.array([[0, 0, -2], [4, 0, 0], [0, 4, -0.5], [0, -4, -0.5], [-4, 0, 0]], float)
    data = SimpleNamespace(geom_xpos=places, geom_xmat=np.tile(np.eye(3).ravel(), (n, 1)))
    return SimpleNamespace(**{**made, **given}), data


def test_mujoco_lidar():
    azimuth = np.array([0, np.pi / 2, -np.pi / 2, np.pi, 0, 0])
    rise = np.array([0, 0, 0, 0, -np.pi / 2, np.pi / 2])

    def seen(**options):
        robot, data = model()
        lidar = mujoco_lidar.MjLidarGnurt(robot, **options)
        lidar.update(data)
        pose = np.eye(4)
        pose[:3, 3] = 0.5, 0.5, 0
        lidar.trace_rays(pose, azimuth, rise)
        return lidar

    ball = 3.5 - np.sqrt(1 - 0.25)
    lidar = seen()
    assert np.allclose(lidar.get_distances(), [ball, 3.5, 3.5, -1, 2, -1], atol=2e-3), lidar.get_distances()
    assert np.allclose(lidar.get_hit_points()[:2], [[ball, 0, 0], [0, 3.5, 0]], atol=2e-3)
    assert seen(geomgroup=[1, 1, 1, 1, 1, 0]).get_distances()[2] == -1, "a group"
    assert seen(bodyexclude=2).get_distances()[1] == -1, "a body"
    assert (seen(cutoff_dist=3).get_distances() > 0).sum() == 2, "too far"
    robot, data = model()
    lidar = mujoco_lidar.MjLidarGnurt(robot)
    with pytest.raises(RuntimeError, match="update"):
        lidar.trace_rays(np.eye(4), azimuth, rise)
    lidar.update(data)
    data.geom_xpos[3] += (0, -1, 0)
    lidar.update(data)
    lidar.trace_rays(np.eye(4), azimuth, rise)
    assert np.allclose(lidar.get_distances()[1:3], [4, 4]), "what moves is followed"
    with pytest.raises(ValueError, match="same shape"):
        lidar.trace_rays(np.eye(4), azimuth, rise[1:])


def test_mujoco():
    mujoco = pytest.importorskip("mujoco")
    kinds = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "mesh")
    bodies = "".join(
        f'<body pos="{2 * np.cos(i):.3f} {2 * np.sin(i):.3f} 0" euler="{30 * i} 20 10"><freejoint/><geom type="{kind}" '
        + ('mesh="m"/>' if kind == "mesh" else 'size=".3 .4 .5"/>')
        + "</body>"
        for i, kind in enumerate(kinds)
    )
    text = f"""<mujoco><asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/><hfield name="h" nrow="8" ncol="12" size="9 7 .7 .3"/></asset>
      <worldbody><geom type="hfield" hfield="h" pos="0 0 -2"/><geom type="plane" size="1 2 .1" pos="0 0 3" euler="160 0 0"/>{bodies}</worldbody></mujoco>"""
    robot, random = mujoco.MjModel.from_xml_string(text), np.random.default_rng(1)
    robot.hfield_data[:] = random.random(robot.hfield_data.shape)
    data = mujoco.MjData(robot)
    mujoco.mj_forward(robot, data)
    lidar, n = mujoco_lidar.MjLidarGnurt(robot, cutoff_dist=50.0), 20_000
    lidar.update(data)
    theta, phi = random.uniform(0, 2 * np.pi, n), random.uniform(-1.5, 1.5, n)
    lidar.trace_rays(np.eye(4), theta, phi)
    ways = np.stack((np.cos(phi) * np.cos(theta), np.cos(phi) * np.sin(theta), np.sin(phi)), -1)
    geoms, far = np.zeros(n, np.int32), np.zeros(n)
    start = np.zeros((3, 1))
    mujoco.mj_multiRay(robot, data, start, ways.ravel(), None, 1, -1, geoms, far, None, n, 50.0)
    far[geoms < 0] = -1
    assert (np.abs(far - lidar.get_distances()) > 5e-3).mean() < 2e-3, "but for outlines of what is round"
