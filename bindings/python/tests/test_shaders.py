# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials in the shading language."""

import numpy as np
import pytest

import gnurt
from conftest import cube

GLOW = "surface glow(color tint = 1, int times = 1, string how = \"plain\") { Ci = tint * times * emission(); }"
FRONT = gnurt.Camera(eye=(0.5, 0.5, 4), target=(0.5, 0.5, 0), fov=40)


def shown(**material):
    scene = gnurt.Scene()
    glow = scene.add_material("glow", **material)
    scene.add_mesh(*cube(), material=glow)
    return scene, np.asarray(scene.render(16, 12, spp=1, camera=FRONT))[6, 8, :3]


def test_text_and_parameters(tmp_path):
    assert np.allclose(shown(shader=GLOW)[1], 1)
    scene, found = shown(shader=GLOW, parameters={"tint": np.array([0.5, 0.25, 1]), "times": 2})
    assert np.allclose(found, (1, 0.5, 2))
    file = tmp_path / "glow.osl"
    file.write_text(GLOW)
    assert np.allclose(shown(shader=file, parameters={"tint": 0.5, "how": "much"})[1], 0.5)
    scene.set_material(0, shader=str(file), parameters={"tint": (3, 3, 3)})
    assert np.allclose(np.asarray(scene.render(16, 12, spp=1, camera=FRONT))[6, 8, :3], 3), "an edit shows"


def test_files_of_scenes(tmp_path):
    (tmp_path / "glow.osl").write_text(GLOW)
    (tmp_path / "a.mtl").write_text("newmtl glow\ngnurt_shader glow.osl tint=0.5,0.25,1\n")
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nusemtl glow\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    picture = gnurt.load(tmp_path / "a.obj").render(16, 12, spp=1, camera=gnurt.Camera((0.3, 0.3, 1), (0.3, 0.3, 0)))
    assert np.allclose(np.asarray(picture)[6, 8, :3], (0.5, 0.25, 1))
    (tmp_path / "glow.osl").unlink()
    with pytest.warns(UserWarning, match="material 'glow' is shown without its shader: .*glow.osl"):
        gnurt.load(tmp_path / "a.obj")


CAMERA = """camera flat(float width = 1, float aspect = 1) {
    P = point("camera", (u - 0.5) * width * aspect, (v - 0.5) * width, 0); I = vector("camera", 0, 0, -1); }"""
PIXEL = "pixel twice(float k = 2, output color Cpixel = 0) { Cpixel = k * (color) trace(P, I); }"


def test_cameras_and_pixels(tmp_path):
    scene = gnurt.Scene()
    scene.add_mesh(*cube(), material=scene.add_material("glow", shader=GLOW))
    view = {"width": 16, "height": 8, "spp": 16, "camera": FRONT, "camera_shader": CAMERA}

    def lit(**more):
        # Samples lie a little beyond their pixels, too: those that the cube fills show most of it.
        return (np.asarray(scene.render(**view, **more))[..., 0] > 0.6).sum()

    assert lit(camera_parameters={"width": 4}) == 4, "a cube of one on a picture of 8 by 4"
    assert lit(camera_parameters={"width": 2, "aspect": 1}) == 32
    file = tmp_path / "twice.osl"
    file.write_text(PIXEL)
    picture = scene.render(16, 12, spp=1, camera=FRONT, pixel_shader=file, pixel_parameters={"k": 3})
    assert np.allclose(np.asarray(picture)[6, 8, :3], 3)
    assert np.allclose(np.asarray(scene.render(16, 12, spp=1, camera=FRONT))[6, 8, :3], 1), "and not afterwards"
    for options, message in (
        ({"camera_shader": GLOW}, "camera_shader: .*of type surface"),
        ({"pixel_shader": CAMERA}, "pixel_shader: .*of type camera"),
        ({"pixel_parameters": {"k": 1}}, "pixel_parameters: .*give pixel_shader="),
        ({"pixel_shader": PIXEL, "pixel_parameters": {"j": 1}}, "pixel_parameters: unknown parameter 'j'"),
    ):
        with pytest.raises(ValueError, match=message):
            scene.render(16, 12, spp=1, **options)


def test_what_is_wrong_is_said():
    for material, kind, message in (
        ({"shader": "none.osl"}, ValueError, "shader: none.osl"),
        ({"shader": "surface a() { Ci = 1 * ; }"}, ValueError, "shader.osl"),
        ({"shader": 3}, TypeError, "shader: expected a file, or source text"),
        ({"shader": "pixel a() { }"}, ValueError, "shader: .*of type pixel"),
        ({"shader": GLOW, "parameters": {"tnt": 1}}, ValueError, "unknown parameter 'tnt'.*did you mean 'tint'"),
        ({"shader": GLOW, "parameters": {"tint": (1, 2)}}, ValueError, "parameters: parameter 'tint'"),
        ({"shader": GLOW, "parameters": {"tint": {}}}, ValueError, "parameter 'tint'"),
        ({"shader": GLOW, "parameters": {"tint": object()}}, TypeError, "parameters: 'tint'"),
        ({"shader": GLOW, "parameters": [1]}, TypeError, "parameters: expected a dict"),
        ({"parameters": {"tint": 1}}, ValueError, "give shader="),
        ({"shader": GLOW, "metallic": 1}, TypeError, "metallic"),
    ):
        with pytest.raises(kind, match=message):
            gnurt.Scene().add_material("x", **material)
    with pytest.warns(UserWarning, match="not so"):
        shown(shader='surface a() { warning("not so"); Ci = emission(); }')


MATERIAL = """
  <surface_unlit name="SR_{0}" type="surfaceshader"><input name="emission_color" type="color3" value="{1}" /></surface_unlit>
  <surfacematerial name="{0}" type="material"><input name="surfaceshader" type="surfaceshader" nodename="SR_{0}" /></surfacematerial>
"""


def document(**materials):
    inner = "".join(MATERIAL.format(name, value) for name, value in materials.items())
    return f'<materialx version="1.39" colorspace="lin_rec709">{inner}</materialx>'


def test_documents_of_materialx(tmp_path):
    file = tmp_path / "two.mtlx"
    file.write_text(document(A="0.5, 0.25, 1", B="2, 3, 4"))
    scene = gnurt.Scene()
    for name in ["A", "B", "other"]:
        scene.add_material(name)
    scene.add_mesh(*cube(), material=0)
    beside = np.eye(4)
    beside[0, 3] = 9
    scene.add_mesh(*cube(), material=1, transform=beside)

    def seen(x):
        front = gnurt.Camera(eye=(x + 0.5, 0.5, 4), target=(x + 0.5, 0.5, 0), fov=40)
        return np.asarray(scene.render(16, 12, spp=1, camera=front))[6, 8, :3]

    assert scene.shade("*", file) == [0, 1], "each has the one of its name"
    assert np.allclose(seen(0), (0.5, 0.25, 1)) and np.allclose(seen(9), (2, 3, 4))
    assert scene.shade("B", f"{file}:A", parameters={"emission_color": (1, 2, 0.5)}) == [1]
    assert np.allclose(seen(9), (1, 2, 0.5)), "a node, with a value"
    scene.set_material(0, "A", shader=document(C="7, 7, 7"))
    assert np.allclose(seen(0), 7), "a text"
    assert scene.shade("*", GLOW, parameters={"tint": 0.25}) == [0, 1, 2]
    assert np.allclose(seen(0), 0.25) and np.allclose(seen(9), 0.25)
    for arguments, what in [
        (("gold", file), "unknown name 'gold'; the scene has: 'A', 'B', 'other'"),
        (("other", file), "shader: .*A.*B"),
        (("A", tmp_path / "none.mtlx"), "shader: .*none.mtlx"),
        (("A", f"{file}:C"), "shader: .*C"),
        (("A", 3), "shader"),
    ]:
        with pytest.raises((ValueError, TypeError), match=what):
            scene.shade(*arguments)


def quad(z, half):
    return np.array([(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)], np.float32), np.array([(0, 1, 2), (0, 2, 3)])


def counted(name, body):
    """What a ceiling shows of an attribute of paths that come from a floor, which the camera sees through a sheet."""
    scene = gnurt.Scene()
    lamp = f'surface lamp () {{ int n = 0; getattribute("path:{name}", n); Ci = float(n) * emission(); }}'
    for height, half, shader in ((0, 5, f"surface floor () {{ Ci = {body}; }}"), (1, 1, "surface sheet () { Ci = transparent(); }"), (20, 60, lamp)):
        scene.add_mesh(*quad(height, half), material=scene.add_material(shader=shader))
    scene.add_light("environment", radiance=0)
    return float(np.asarray(scene.render(8, 8, spp=64, camera=gnurt.Camera(eye=(0, 0, 10), target=(0, 0, 0), up=(0, 1, 0), fov=3)))[..., :3].mean())


def test_paths_count_their_bounces():
    glossy = 'microfacet("ggx", N, vector(0), 0.2, 0.2, 0, 0)'
    for name, body, low, high in (
        ("diffuse_depth", "diffuse(N)", 0.88, 1.0),
        ("ray_depth", glossy, 0.94, 1.0),
        ("glossy_depth", "diffuse(N)", 0.0, 0.0),
        ("glossy_depth", "reflection(N)", 1.0, 1.0),
        # On the way there, and for some on the way from there.
        ("transparent_depth", "diffuse(N)", 1.2, 1.7),
        ("transparent_depth", glossy, 1.7, 2.0),
        ("transparent_depth", "reflection(N)", 2.0, 2.0),
    ):
        mean = counted(name, body)
        assert low - 1e-4 <= mean <= high + 1e-4, f"{name} after {body}: {mean}"
