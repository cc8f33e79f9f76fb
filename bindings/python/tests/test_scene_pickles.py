# SPDX-License-Identifier: GPL-3.0-or-later
"""Pickled and copied scenes give the same pictures, in this process and in others."""

import copy
import multiprocessing
import pickle
import warnings

import numpy as np
import pytest

import gnurt
from conftest import cube

FRONT = gnurt.Camera(eye=(1.5, 1.2, 5), target=(1.0, 0.7, 0), fov=50, aperture=0.05, name="front")
SURFACE = """#include "half.h"
surface checks(color tint = 1, int times = 1, string how = "plain", output vector displacement = 0) {
    displacement = 0.02 * N * sin(20 * u);
    Ci = HALF * tint * times * (color) texture("pattern", u, v) * diffuse(N); }"""
LAMP = "light lamp(color power = 1) { L = power; lightdist = 10; }"


def seen(scene, camera="front", **options):
    return np.asarray(scene.render(24, 18, spp=2, camera=camera, **options)).tobytes()


def full(folder):
    """A scene with all that there is."""
    scene, random = gnurt.Scene(), np.random.default_rng(7)
    colors = scene.add_texture(random.integers(0, 255, (8, 8, 3), np.uint8), wrap=("mirror", "clamp"))
    heights = scene.add_texture(random.random((4, 4)), filter="nearest", name="heights")
    gnurt.Picture(random.random((4, 6, 3)).astype(np.float32)).save(folder / "picture.png")
    file = scene.add_texture(folder / "picture.png", colorspace="linear")
    (folder / "half.h").write_text("#define HALF 0.5\n")
    (folder / "checks.osl").write_text(SURFACE)
    shader = {"shader": folder / "checks.osl", "parameters": {"tint": (0.9, 0.5, 0.1), "times": 2}}
    smoke = scene.add_medium("smoke", density=random.random((3, 2, 2)), scattering=0.5, transform=np.eye(4))
    milk = scene.add_medium("milk", scattering=(1, 2, 3), absorption=0.1, anisotropy=0.3, priority=2)
    materials = [
        scene.add_material("maps", color_texture=(colors, (2, 0, 0, 2, 0.1, 0)), metallic_roughness_texture=file, normal_texture=file, normal_scale=0.5),
        scene.add_material("layers", clearcoat=1, clearcoat_texture=heights, sheen_color=1, sheen_color_texture=colors, iridescence=1, iridescence_texture=heights),
        scene.add_material("skin", subsurface=0.5, subsurface_radius=0.1, emission=0.1, emission_texture=colors, bump_texture=heights, bump_height=0.1),
        scene.add_material("leaf", opacity_texture=heights, opacity_channel="red", opacity_cutoff=0.4, diffuse_transmission=0.5),
        scene.add_material("glass", kind="glass", ior=1.4, roughness=0.1, dispersion=1, attenuation_color=0.5, attenuation_distance=0.3),
        scene.add_material("filled", kind="boundary", medium=milk),
        scene.add_material("rough", displacement_texture=heights, displacement_scale=0.05, displacement_levels=2),
        scene.add_material("checks", **shader, textures={"pattern": colors}, displacement_levels=2),
    ]
    vertices, faces = cube()
    texcoords = vertices[:, :2] * 2 + vertices[:, 2:]
    keys = [vertices, vertices + (0, 0.2, 0)]
    for i, material in enumerate(materials):
        place = np.eye(4)
        place[:3, :3] *= 0.6
        place[:3, 3] = i % 4 * 0.8 - 0.3, i // 4 * 0.9, 0
        colored = {"colors": random.random((8, 4)), "attributes": {"weight": random.random(8)}, "face_attributes": {"side": np.arange(12.0)}}
        scene.add_mesh(vertices, faces, name=f"cube {i}", texcoords=texcoords, material=material, transform=place, **colored, moments={"vertices": keys} if i == 0 else None)
    moved = np.eye(4)
    moved[:3, 3] = 0.3, -0.8, -1
    scene.add_instance(0, moved)
    scene.update(1, rays=("camera", "other"))
    scene.add_curves(random.random((8, 3)) + (0, 1.6, 0), 0.02, counts=(4, 4), material=materials[2])
    scene.add_points(random.random((5, 3)) * (3, 0.2, 1), random.random(5) * 0.1, colors=random.random((5, 4)))
    scene.add_light("point", position=(0, 3, 2), intensity=4)
    scene.add_light("spot", position=(2, 3, 2), direction=(0, -1, -0.5), intensity=(5, 3, 1))
    scene.add_light("directional", direction=(0.1, -1, -0.3), irradiance=0.3, angle=2)
    scene.add_light("environment", texture=colors, radiance=0.4, turn=30)
    scene.add_light_shader(LAMP, parameters={"power": (0.1, 0.2, 0.3)})
    scene.set("lights.0.group=key")
    scene.add_camera(FRONT)
    scene.add_camera(gnurt.Camera((0, 0, 3), (0, 0, 0), projection="orthographic", view_height=4, shift=(0.1, 0)))
    assert smoke == 0
    return scene


MOVED = {"motion": {"meshes": [0], "instances": {8: [np.eye(4), np.diag([1.2, 1, 1, 1])]}}}


@pytest.mark.parametrize("how", [lambda scene: pickle.loads(pickle.dumps(scene)), copy.copy, copy.deepcopy])
def test_pictures_stay_the_same(how, tmp_path):
    scene = full(tmp_path)
    expected = [seen(scene, **options) for options in ({}, {"camera": 1}, MOVED, {"working_space": "acescg"})]
    other = how(scene)
    # The copy does not need the files of its shaders and textures.
    for name in ("half.h", "checks.osl", "picture.png"):
        (tmp_path / name).unlink()
    assert type(other) is gnurt.Scene and repr(other) == repr(scene)
    assert [seen(other, **options) for options in ({}, {"camera": 1}, MOVED, {"working_space": "acescg"})] == expected
    assert other.cameras == scene.cameras and other.materials == scene.materials and other.instances == scene.instances
    assert len(set(expected)) == 4, "each of these is another picture"


def test_copies_are_edited_alone(tmp_path):
    scene = full(tmp_path)
    before = seen(scene)
    for other in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        other.update(0, transform=np.diag([0.1, 0.1, 0.1, 1]))
        other.set_texture(0, np.zeros((2, 2, 3), np.uint8))
        other.set_light(0, "point", position=(0, 0, 5), intensity=9)
        other.set_material(1, color=0.1)
        other.add_mesh(*cube(), material=0)
        assert seen(other) != before and seen(scene) == before


def test_suns_stay_with_their_skies():
    scene = gnurt.Scene()
    scene.add_mesh(*cube())
    scene.add_camera(FRONT)
    sky = scene.add_light("environment", sky="day")
    for other in (pickle.loads(pickle.dumps(scene)), copy.copy(scene)):
        assert seen(other) == seen(scene)
        other.set_light(sky, "environment", sky="overcast")
        assert "2 lights" in repr(other), "the sky's sun was replaced"


def test_animations_and_builtin_scenes():
    for name, options in (("wind", {"at": 1.3, "shutter": 0.1}), ("cornell", {}), ("island", {})):
        scene = gnurt.load(f"builtin:{name}")
        other = pickle.loads(pickle.dumps(scene))
        assert other.animations == scene.animations
        assert seen(other, None, **options) == seen(scene, None, **options), name
    # Also where another time was shown before.
    scene.render(8, 6, spp=1)
    assert seen(pickle.loads(pickle.dumps(scene)), None) == seen(scene, None)


def test_shaders_of_files(tmp_path):
    (tmp_path / "glow.osl").write_text("surface glow(color tint = 1) { Ci = tint * emission(); }")
    (tmp_path / "a.mtl").write_text("newmtl glow\ngnurt_shader glow.osl tint=0.5,0.25,1\n")
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nusemtl glow\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    camera = gnurt.Camera((0.3, 0.3, 1), (0.3, 0.3, 0))
    scene = gnurt.load(tmp_path / "a.obj")
    data, expected = pickle.dumps(scene), seen(scene, camera)
    (tmp_path / "glow.osl").unlink()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert seen(pickle.loads(data), camera) == expected


def test_materials_of_materialx(tmp_path):
    document = '<materialx version="1.39"><standard_surface name="S" type="surfaceshader"><input name="base_color" type="color3" value="0.9, 0.1, 0.2"/></standard_surface><surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial></materialx>'
    (tmp_path / "d.mtlx").write_text(document)
    for shader in (document, f"{tmp_path / 'd.mtlx'}:M"):
        scene = gnurt.Scene()
        scene.add_camera(FRONT)
        scene.add_mesh(*cube(), material=scene.add_material("x", shader=shader, parameters={"metalness": 0.5}))
        assert seen(pickle.loads(pickle.dumps(scene))) == seen(scene)


class Named(gnurt.Scene):
    def __new__(cls, title):
        scene = super().__new__(cls)
        scene.title = title
        return scene

    def __init__(self, title):
        pass


def test_derived_classes():
    scene = Named("a")
    scene.add_mesh(*cube())
    for other in (pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene)):
        assert type(other) is Named and other.title == "a" and len(other.instances) == 1


def test_other_processes(tmp_path):
    scene = full(tmp_path)
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(seen, [scene] * 2) == [seen(scene)] * 2


def test_damaged_states_are_errors(tmp_path):
    scene = full(tmp_path)
    good = scene.__getstate__()
    damaged = [
        ({"scene": b"no scene"}, "these are no bytes of a scene"),
        ({"scene": good["scene"][:-9]}, "damaged"),
        ({"surfaces": []}, "a shader of the scene is missing"),
        ({"displacements": []}, "a shader of the scene is missing"),
        ({"suns": {3: 99}}, "a light is missing"),
    ]
    other = gnurt.Scene()
    for changed, message in damaged:
        with pytest.raises(ValueError, match=f"pickled scene: .*{message}"):
            other.__setstate__({**good, **changed})
    without = {name: value for name, value in good.items() if name != "lights"}
    with pytest.raises(ValueError, match="pickled scene: it has no 'lights'"):
        other.__setstate__(without)
    (path, texts, *rest), *_ = good["surfaces"]
    with pytest.raises(ValueError, match="pickled scene: .*checks.osl"):
        other.__setstate__({**good, "surfaces": [(path, [(name, "surface {") for name, _ in texts], *rest)]})
    with pytest.raises(ValueError, match="a picture of a shader is missing"):
        other.__setstate__({**good, "surfaces": [(path, texts, *rest[:-1], [("pattern", 99)])]})
    assert other.instances == [], "it is as it was"
