# SPDX-License-Identifier: GPL-3.0-or-later
import os
import signal

import numpy as np
import pytest

import gnurt


def cube():
    """A closed cube from 0 to 1, faces outwards."""
    vertices = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], float)
    faces = np.array(
        [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4]]
        + [[2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
    )
    return vertices, faces


@pytest.fixture
def scene():
    scene = gnurt.RayScene()
    scene.add_triangles(*cube())
    return scene


@pytest.fixture
def rays():
    """A thousand rays at the cube, some of which miss."""
    random = np.random.default_rng(20061)
    origins = random.normal(size=(1000, 3)) * 3 + 0.5
    return origins, random.uniform(-0.5, 1.5, size=(1000, 3)) - origins


def in_child(job):
    """Runs a function in a fork of this process, which has half a minute; it must return something true."""
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(30)
        try:
            os._exit(0 if job() else 1)
        except BaseException as error:
            os.write(2, f"{error!r}\n".encode())
            os._exit(2)
    status = os.waitpid(child, 0)[1]
    assert status == 0, f"status {status:#x}; {signal.SIGALRM.value} is a child that hangs"


def brute_force(vertices, faces, origins, directions):
    """Parameters (rays, triangles) in double precision, inf where they miss: by solving for corners' weights."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    matrix = np.stack(np.broadcast_arrays(b - a, c - a, -directions[:, None]), axis=-1)
    with np.errstate(all="ignore"):
        inverse = np.linalg.inv(matrix + 0.0)
    u, v, t = np.moveaxis(np.einsum("rtij,rtj->rti", inverse, origins[:, None] - a), -1, 0)
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0), t, np.inf)
