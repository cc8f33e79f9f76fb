# SPDX-License-Identifier: GPL-3.0-or-later
"""Displaced surfaces by numbers, textures and shaders."""

import gnurt
import numpy as np
import pytest

WAVES = 'displacement waves (float k = 1) { P += k * 0.1 * sin (6.2831853 * P[0]) * N; }'


def sheet(**properties):
    scene = gnurt.Scene()
    textures = properties.pop("textures", ())
    for texture in textures:
        scene.add_texture(texture, colorspace="linear")
    material = scene.add_material("sheet", kind="matte", **properties)
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    uv = [[0, 0], [1, 0], [1, 1], [0, 1]]
    scene.add_mesh(vertices, [[0, 1, 2], [0, 2, 3]], normals=[[0, 0, 1]] * 4, texcoords=uv, material=material)
    return scene, material


def heights(scene):
    """Distances from above, along x."""
    camera = gnurt.Camera(eye=(0.5, 0.5, 2), target=(0.5, 0.5, 0), up=(0, 1, 0), projection="orthographic", view_height=1 / 16)
    picture = scene.render(64, 4, camera=camera, spp=1, layers=True, integrator="eyelight")
    return 2 - picture["depth"][2]


def test_numbers_and_textures():
    assert np.allclose(heights(sheet(displacement=0.25, displacement_levels=2)[0]), 0.25, atol=1e-6)
    grey = np.full((2, 2), 0.75, np.float32)
    scene, _ = sheet(textures=[grey], displacement_texture=0, displacement_midlevel=0.5, displacement_scale=2)
    assert np.allclose(heights(scene), 0.5, atol=1e-6)
    vector = np.zeros((1, 1, 3), np.float32)
    vector[..., 2] = 0.125
    for space in "object", "tangent":
        scene, _ = sheet(textures=[vector], displacement_texture=0, displacement_vector=space)
        assert np.allclose(heights(scene), 0.125, atol=1e-6)


def test_shaders_and_edits():
    scene, material = sheet(displacement_shader=WAVES, displacement_parameters={"k": 2}, displacement_edge=0.01)
    x = (np.arange(64) + 0.5) / 64
    assert np.allclose(heights(scene), 0.2 * np.sin(2 * np.pi * x), atol=0.03), "as far as places in pixels are known"
    scene.set_material(material, "sheet", kind="matte", displacement=0.5)
    assert np.allclose(heights(scene), 0.5, atol=1e-6)
    scene.set_material(material, "sheet", kind="matte")
    assert np.allclose(heights(scene), 0, atol=1e-6)
    surface = "surface s (output vector displacement = 0) { displacement = 0.25 * N; Ci = diffuse(N); }"
    assert scene.shade("sheet", surface) == [material]
    assert np.allclose(heights(scene), 0.25, atol=1e-6)
    assert scene.shade("sheet", "displacement d () { displace (0.75); }") == [material]
    assert np.allclose(heights(scene), 0.75, atol=1e-6)


def test_what_is_wrong_is_named():
    for wrong, text in (
        ({"displacement": 1, "displacement_shader": WAVES}, "give one of displacement"),
        ({"displacement": 1, "displacement_edge": 0.1, "displacement_levels": 2}, "not both"),
        ({"displacement_texture": 0, "displacement_vector": "world"}, "object or tangent"),
        ({"displacement_shader": "light l () { }"}, "expected a displacement, not a light"),
        ({"displacement_shader": "surface s () { Ci = 0; }"}, "no displacement"),
    ):
        with pytest.raises(ValueError, match=text):
            sheet(**wrong)
    with pytest.raises(IndexError):
        sheet(displacement_texture=3)
