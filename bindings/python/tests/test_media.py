# SPDX-License-Identifier: GPL-3.0-or-later
"""Media: fog, smoke, the contents of bodies. Oracles are Beer's law, and even media beside grids of the same density."""

import gzip
from pathlib import Path

import numpy as np
import pytest

import gnurt
from conftest import cube

FRONT = gnurt.Camera(eye=(0.5, 0.5, 6), target=(0.5, 0.5, 0), fov=2)
DATA = Path(__file__).parents[3] / "crates/image/tests/data"


def boundary(**medium):
    """A scene of the unit cube with a medium, under an even sky."""
    scene = gnurt.Scene()
    number = scene.add_medium(**medium)
    scene.add_mesh(*cube(), material=scene.add_material(kind="boundary", medium=number))
    return scene


def light(scene, sky=1.0, camera=FRONT, spp=256):
    """The mean light of a picture of its middle."""
    scene.add_light("environment", radiance=(sky, sky, sky))
    return np.asarray(scene.render(8, 8, spp=spp, camera=camera, max_depth=64))[..., :3].mean((0, 1))


def test_beers_law():
    assert np.allclose(light(boundary(absorption=(0.5, 1, 2)), spp=4), np.exp([-0.5, -1, -2]), rtol=1e-3)


def test_emission():
    found = light(boundary(absorption=0.5, emission=(3, 2, 1)), sky=0, spp=4)
    assert np.allclose(found, np.array([3, 2, 1]) * (1 - np.exp(-0.5)), rtol=1e-3)


def test_a_ball_around():
    scene = gnurt.Scene()
    scene.add_medium(absorption=0.25, extent="around", centre=(0.5, 0.5, 0), radius=2)
    assert np.allclose(light(scene, spp=4), np.exp(-1), rtol=1e-3)
    everywhere = gnurt.Scene()
    everywhere.add_medium(absorption=0.25, extent="around")
    assert (light(everywhere, spp=1) == 0).all(), "infinitely much of it"


def test_even_grids_are_even_media():
    sigma = {"absorption": (0.2, 0.5, 0.1), "scattering": (1.0, 0.3, 2.0), "anisotropy": 0.4}
    grid = gnurt.Scene()
    grid.add_medium(density=np.full((5, 6, 7), 2.0), **sigma)
    doubled = {name: tuple(2 * np.array(value)) if isinstance(value, tuple) else value for name, value in sigma.items()}
    scenes = [grid, boundary(**doubled)]
    for scene in scenes:
        scene.add_light("point", position=(0.5, 3, 2), intensity=20)
    a, b = (light(scene, sky=0.1, spp=2048) for scene in scenes)
    assert np.allclose(a, b, rtol=0.02), (a, b)
    # A third of its cells along x is empty: seen along x, a third of the way.
    density = np.zeros((3, 1, 1))
    density[2] = 1
    third = gnurt.Scene()
    # Cells are interpolated between their centres: half of the middle one counts.
    third.add_medium(density=np.repeat(density, 32, axis=0), absorption=1.5, transform=np.diag([2.0, 1, 1, 1]))
    side = gnurt.Camera(eye=(9, 0.5, 0.5), target=(0, 0.5, 0.5), fov=2)
    assert np.allclose(light(third, camera=side, spp=4096), np.exp(-1.5 * 2 / 3), rtol=0.02)


def test_cells_glow():
    glow = np.zeros((4, 2, 2, 3))
    glow[..., 0], glow[..., 1] = 1, 2
    scene = gnurt.Scene()
    scene.add_medium(density=np.ones((4, 2, 2)), emission_grid=glow, absorption=0.5, emission=3)
    assert np.allclose(light(scene, sky=0, spp=4096), np.array([3, 6, 0]) * (1 - np.exp(-0.5)), rtol=0.03)


def test_bodies_with_a_surface():
    scene = gnurt.Scene()
    milk = scene.add_medium(absorption=1)
    see_through = scene.add_material(shader="surface s () { Ci = transparent(); }", medium=milk)
    scene.add_mesh(*cube(), material=see_through)
    assert np.allclose(light(scene, spp=64), np.exp(-1), rtol=1e-3)
    scene.set_medium(milk, absorption=2)
    assert np.allclose(light(scene, spp=64), np.exp(-2), rtol=1e-3)


def test_bodies_add_or_replace():
    for adds, expected in ((True, 1.25), (False, 1.0)):
        scene = boundary(absorption=1, adds=adds)
        scene.add_medium(absorption=0.25, extent="around", centre=(0.5, 0.5, 0.5), radius=0.5 + 1e-4)
        assert np.allclose(light(scene, spp=4), np.exp(-expected), rtol=1e-2)


def test_files(tmp_path):
    path = tmp_path / "grids.vdb"
    path.write_bytes(gzip.decompress((DATA / "grids.vdb.gz").read_bytes()))
    with pytest.raises(ValueError, match="cells are too many"):
        gnurt.read_volume(path)
    found = gnurt.read_volume(path, ["density", "Cd"])
    lines = (DATA / "grids.txt").read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("grid density"))
    low = np.array(lines[first].split()[2:5], int) - 1
    density, matrix = found["density"]
    compared = 0
    for line in lines[first + 1 :]:
        if line.startswith("grid"):
            break
        at, value = np.array(line.split()[:3], int) - low, float(line.split()[3])
        if (at >= 0).all() and (at < density.shape).all():
            assert density[tuple(at)] == np.float32(value), line
            compared += 1
    assert compared > 20 and matrix.shape == (4, 4) and found["Cd"][0].shape[3] == 3
    # By its file, and by its arrays.
    scenes = [gnurt.Scene(), gnurt.Scene()]
    scenes[0].add_medium(file=path, grid="density", absorption=1)
    scenes[1].add_medium(density=np.maximum(density, 0), transform=matrix, absorption=1)
    middle = (matrix @ (0.5, 0.5, 0.5, 1))[:3]
    size = np.linalg.norm(matrix[:3, :3], axis=0).max()
    camera = gnurt.Camera(eye=middle + (0, 0, 3 * size), target=middle, fov=20)
    a, b = (light(scene, camera=camera) for scene in scenes)
    assert (a == b).all() and a.max() < 0.999


@pytest.mark.parametrize(
    ("arguments", "kind", "message"),
    [
        ({"absorption": -1}, ValueError, "absorption"),
        ({"scattering": "much"}, TypeError, "scattering"),
        ({"anisotropy": 1}, ValueError, "anisotropy"),
        ({"second_share": 2}, ValueError, "second_share"),
        ({"extent": "inside"}, ValueError, "extent: expected bodies, around or free"),
        ({"extent": "free"}, ValueError, "extent: 'free' needs"),
        ({"radius": 2}, ValueError, "radius"),
        ({"priority": 0.5}, TypeError, "priority"),
        ({"density": np.ones((2, 2))}, ValueError, r"density: expected shape \(x, y, z\)"),
        ({"density": np.full((2, 2, 2), np.nan)}, ValueError, "density: expected finite"),
        ({"density": np.ones((2, 2, 2)), "emission_grid": np.ones((2, 2, 3))}, ValueError, "emission_grid"),
        ({"density": np.ones((2, 2, 2)), "transform": np.eye(3)}, ValueError, "transform"),
        ({"density": np.ones((2, 2, 2)), "file": "a.vdb"}, ValueError, "density: conflicts"),
        ({"density": np.ones((2, 2, 2)), "grid": "a"}, ValueError, "grid"),
        ({"emission_grid": np.ones((2, 2, 2))}, ValueError, "emission_grid"),
        ({"file": "nowhere.vdb"}, OSError, "nowhere.vdb"),
        ({"density": np.ones((2, 2, 2)), "temperature_grid": "heat"}, ValueError, "temperature_grid: needs file"),
        ({"file": "nowhere.vdb", "kelvin": 2}, ValueError, "kelvin: needs temperature_grid"),
        ({"colour": 1}, TypeError, "colour: unknown"),
    ],
)
def test_wrong_arguments(arguments, kind, message):
    with pytest.raises(kind, match=message):
        gnurt.Scene().add_medium(**arguments)


def test_wrong_numbers():
    scene = gnurt.Scene()
    with pytest.raises(IndexError, match="medium: 0 is out of range"):
        scene.add_material(medium=0)
    with pytest.raises(ValueError, match="medium: a boundary"):
        scene.add_material(kind="boundary")
    with pytest.raises(IndexError, match="medium: 3"):
        scene.set_medium(3, absorption=1)
