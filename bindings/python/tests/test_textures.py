# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures from arrays and files, in materials, lights and shaders; meshes with attributes per corner; motion blur."""

import numpy as np
import pytest

import gnurt

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])
UV = (SQUARE[:, :2] + 1) / 2
FRONT = gnurt.Camera(eye=(0, 0, 5), target=(0, 0, 0), projection="orthographic", view_height=2)
# Four quarters: red and green above, blue and white below.
QUARTERS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8)
SHOW = 'surface show(string file = "photo") { Ci = (color) texture(file, u, 1 - v, "interp", "closest") * emission(); }'


def seen(scene, **options):
    return np.asarray(scene.render(8, 8, spp=1, camera=FRONT, filter="box", **options))[..., :3]


def test_emission_by_an_array():
    scene = gnurt.Scene()
    photo = scene.add_texture(QUARTERS, filter="nearest")
    glow = scene.add_material("glow", kind="matte", color=0, emission_texture=photo)
    scene.add_mesh(SQUARE, FACES, texcoords=UV, material=glow)
    found = seen(scene)
    for (row, column), color in {(1, 1): (1, 0, 0), (1, 6): (0, 1, 0), (6, 1): (0, 0, 1), (6, 6): (1, 1, 1)}.items():
        assert np.allclose(found[row, column], color, atol=1e-3), (row, column)
    # Turned by half: u' = 1 - u, v' = 1 - v.
    scene.set_material(glow, kind="matte", color=0, emission_texture=(photo, (-1, 0, 0, -1, 1, 1)))
    assert np.allclose(seen(scene)[1, 1], (1, 1, 1), atol=1e-3), "the transform counts"


def test_colour_spaces():
    for colorspace, expected in {"srgb": 0.2158, "linear": 128 / 255}.items():
        scene = gnurt.Scene()
        grey = scene.add_texture(np.full((2, 2), 128, np.uint8), colorspace=colorspace)
        scene.add_mesh(SQUARE, FACES, texcoords=UV, material=scene.add_material(kind="matte", color=0, emission_texture=grey))
        assert np.allclose(seen(scene), expected, atol=2e-3), colorspace


def test_shaders_read_arrays():
    scene = gnurt.Scene()
    photo = scene.add_texture(QUARTERS.astype(np.float32) / 255)
    scene.add_mesh(SQUARE, FACES, texcoords=UV, material=scene.add_material(shader=SHOW, textures={"photo": photo}))
    assert np.allclose(seen(scene)[1, 1], (1, 0, 0), atol=1e-3)
    with pytest.raises(IndexError, match="7 is out of range"):
        scene.add_material(shader=SHOW, textures={"photo": 7})


def test_wrong_textures():
    scene = gnurt.Scene()
    with pytest.raises(ValueError, match="source: expected an array of shape"):
        scene.add_texture(np.zeros((2, 2, 5)))
    with pytest.raises(ValueError, match="wrap: expected repeat, mirror or clamp, not 'tile'"):
        scene.add_texture(QUARTERS, wrap="tile")
    with pytest.raises(OSError):
        scene.add_texture("/nowhere/photo.png")
    with pytest.raises(IndexError, match="0 is out of range"):
        scene.add_material(color_texture=0)


def test_environment_by_an_array():
    scene = gnurt.Scene()
    scene.add_light("environment", texture=scene.add_texture(np.full((4, 8, 3), 0.5, np.float32)), radiance=2)
    assert np.allclose(seen(scene), 1, atol=1e-3)


def test_light_shaders():
    sun = "light sun(color power = 1) { L = vector(0, 0, 1); lightdist = 1e30; Cl = power; }"
    scene = gnurt.Scene()
    scene.add_mesh(SQUARE, FACES, material=scene.add_material(kind="matte", color=1))
    lamp = scene.add_light_shader(sun, parameters={"power": np.pi})
    assert np.allclose(seen(scene), 1, atol=1e-3), "irradiance over pi"
    scene.set_light_shader(lamp, sun, parameters={"power": np.pi / 2})
    assert np.allclose(seen(scene), 0.5, atol=1e-3)


def test_corners_and_materials():
    paint = "surface paint(color tint = 0 [[ int lockgeom = 0 ]]) { color c = 0; getattribute(\"tint\", c); Ci = c * emission(); }"
    scene = gnurt.Scene()
    corners = np.zeros((2, 3, 3))
    corners[0], corners[1] = (1, 0, 0), (0, 1, 0)
    scene.add_mesh(SQUARE, FACES, material=scene.add_material(shader=paint), attributes={"tint": corners})
    found = seen(scene)
    assert np.allclose(found[6, 6], (1, 0, 0), atol=1e-3) and np.allclose(found[1, 1], (0, 1, 0), atol=1e-3)
    scene = gnurt.Scene()
    both = [scene.add_material(color=0, emission=1), scene.add_material(color=0, emission=0.25)]
    mesh = scene.add_mesh(SQUARE, FACES, material=both, face_materials=[0, 1])
    found = seen(scene)
    assert np.allclose(found[6, 6], 1, atol=1e-3) and np.allclose(found[1, 1], 0.25, atol=1e-3)
    scene.set_mesh(mesh, SQUARE, FACES, material=both, face_materials=[1, 1])
    assert np.allclose(seen(scene), 0.25, atol=1e-3), "the new mesh is shown"
    scene.update(mesh, rays=["shadow", "other"])
    assert not seen(scene)[4, 4].any(), "the camera does not see it"
    with pytest.raises(ValueError, match="normals: expected shape"):
        scene.add_mesh(SQUARE, FACES, normals=np.zeros((3, 3)))
    with pytest.raises(ValueError, match="face_materials"):
        scene.add_mesh(SQUARE, FACES, material=both)
    with pytest.raises(ValueError, match="face_materials: expected whole numbers"):
        scene.add_mesh(SQUARE, FACES, material=both, face_materials=[0, 0.5])


def test_motion():
    scene = gnurt.Scene()
    bar = scene.add_mesh(SQUARE * (0.25, 1, 1), FACES, material=scene.add_material(color=0, emission=1))
    places = np.stack([np.eye(4), np.eye(4)])
    places[0, 0, 3], places[1, 0, 3] = -0.5, 0.5
    blurred = np.asarray(scene.render(8, 8, spp=256, camera=FRONT, filter="box", motion={"instances": {bar: places}}))
    row = blurred[4, :, 0]
    # The bar is half a unit wide and goes one unit: the middle sees it half of the time.
    assert abs(row[3:5].mean() - 0.5) < 0.06, row
    assert row[0] < 0.2 and row[7] < 0.2, row
    with pytest.raises(IndexError, match="instance.* 9"):
        scene.render(8, 8, spp=1, motion={"instances": {9: places}})
