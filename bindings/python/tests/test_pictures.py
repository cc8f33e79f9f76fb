# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import signal
import threading
import time

import numpy as np
import pytest

import gnurt
from conftest import cube, in_child

SMALL = {"spp": 2, "threads": 2}
FRONT = gnurt.Camera(eye=(0.5, 0.5, 4), target=(0.5, 0.5, 0), fov=40)


def red_cube():
    scene = gnurt.Scene()
    red = scene.add_material("red", color=(0.8, 0.1, 0.1), kind="matte")
    scene.add_mesh(*cube(), material=red, name="cube")
    return scene


def test_a_picture(tmp_path):
    picture = gnurt.load("builtin:cornell").render(40, 30, spp=4, layers=True)
    pixels = np.asarray(picture)
    assert pixels.shape == (30, 40, 4) and pixels.dtype == np.float32 and (picture.width, picture.height) == (40, 30)
    assert 0.01 < pixels[..., :3].mean() < 10 and np.array(picture, np.float64).dtype == np.float64
    assert picture["albedo"].shape == (30, 40, 3) and picture["depth"].shape == (30, 40)
    assert picture["id"].dtype == np.uint32 and set(picture["N"].shape) == {30, 40, 3} and "albedo" in picture.layers
    assert picture._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n" == picture.png(exposure=1, tone="clamp")[:8]
    clean = np.asarray(picture.denoise("built-in"))
    assert clean.shape == pixels.shape and (clean != pixels).any()
    for name in ("a.png", "a.exr", "a.hdr", "a.pfm"):
        picture.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 100, name
    with pytest.raises(ValueError, match="gif"):
        picture.save(tmp_path / "a.gif")
    with pytest.raises(OSError, match="nowhere"):
        picture.save(tmp_path / "nowhere" / "a.png")
    with pytest.raises(KeyError, match="unknown layer 'albdo'"):
        picture["albdo"]


def test_threads_and_passes_change_nothing():
    scene = gnurt.load("builtin:cornell")
    one, three = (np.asarray(scene.render(40, 30, spp=5, threads=n)) for n in (1, 3))
    assert (one == three).all()
    shares, pictures = [], []
    for picture in scene.accumulate(40, 30, spp=5, progress=shares.append):
        pictures.append(np.asarray(picture))
    assert len(pictures) == 4 and (pictures[-1] == one).all() and (pictures[0] != one).any()
    assert shares[-1] == 1 and shares == sorted(shares)
    assert (pictures[0] == np.asarray(scene.render(40, 30, spp=1))).all()


def test_growing_after_a_fork():
    scene = gnurt.load("builtin:cornell")
    growing = scene._grow({"width": 16, "height": 12, **SMALL})
    growing.grow(1)
    in_child(lambda: growing.grow(1))
    assert growing.grow(1)


def test_edits_show():
    scene = red_cube()
    lamp = scene.add_light("point", position=(0.5, 0.5, 6), intensity=50)
    camera = scene.add_camera(FRONT)
    again = scene.add_instance(0, np.eye(4) + np.array([[0, 0, 0, 1.5]] + [[0] * 4] * 3))
    green = scene.add_material("green", color=(0.1, 0.8, 0.1))

    def same_from_scratch(cubes, light, vertices=cube()[0], material=("red", (0.8, 0.1, 0.1), "matte")):
        other = gnurt.Scene()
        number = other.add_material(material[0], color=material[1], kind=material[2])
        for transform in cubes:
            other.add_mesh(vertices, cube()[1], material=number, transform=transform)
        other.add_light("point", position=(0.5, 0.5, 6), intensity=light)
        other.add_camera(FRONT)
        return (np.asarray(scene.render(32, 24, **SMALL)) == np.asarray(other.render(32, 24, **SMALL))).all()

    moved = np.eye(4)
    moved[0, 3] = 1.5
    assert same_from_scratch([np.eye(4), moved], 50)
    scene.update(again, visible=False)
    assert same_from_scratch([np.eye(4)], 50)
    scene.set_light(lamp, "point", position=(0.5, 0.5, 6), intensity=(20, 20, 20))
    assert same_from_scratch([np.eye(4)], 20)
    scene.update(0, vertices=cube()[0] * 0.5)
    assert same_from_scratch([np.eye(4)], 20, cube()[0] * 0.5)
    scene.update(0, transform=moved, material=green)
    assert same_from_scratch([moved], 20, cube()[0] * 0.5, ("green", (0.1, 0.8, 0.1), "principled"))
    scene.set_material(green, "mirror", kind="mirror")
    assert same_from_scratch([moved], 20, cube()[0] * 0.5, ("mirror", 1, "mirror"))
    assert scene.cameras == [FRONT] and camera == 0
    assert scene.materials == ["red", "mirror"] and len(scene.instances) == 2
    assert "24 triangles" in repr(scene) or "12 triangles" in repr(scene)


def test_what_is_missing_is_added(tmp_path):
    scene = red_cube()
    lit = np.asarray(scene.render(32, 24, **SMALL))
    assert lit[12, 16, 0] > 2 * lit[12, 16, 1] > 0, "red, in a studio"
    scene.update(0, transform=np.diag([2.0, 2, 2, 1]))
    again, fresh = scene.render(32, 24, **SMALL), red_cube()
    fresh.update(0, transform=np.diag([2.0, 2, 2, 1]))
    assert (np.asarray(again) == np.asarray(fresh.render(32, 24, **SMALL))).all(), "the studio follows"
    scene.save(tmp_path / "a.glb")
    assert gnurt.load(tmp_path / "a.glb").instances == ["cube"]
    shapes = np.asarray(scene.render(32, 24, integrator="eyelight", camera=FRONT))
    assert shapes[..., 0].max() > 0
    day = red_cube()
    day.add_light("environment", sky="day", turn=30)
    assert np.asarray(day.render(32, 24, **SMALL))[0, 0, 2] > 0


def test_meshes_of_others():
    class Legacy:
        vertices, triangles = cube()
        vertex_colors = np.tile([1.0, 0, 0], (8, 1))

        def has_vertex_colors(self):
            return True

    white = {"kind": "matte", "color": 1}
    scene = gnurt.Scene()
    scene.add_mesh(Legacy(), material=scene.add_material(**white))
    pixel = np.asarray(scene.render(32, 24, camera=FRONT, **SMALL))[12, 16]
    assert pixel[0] > 0.1 and pixel[1] < 0.01
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(*cube(), process=False, vertex_colors=np.tile([255, 0, 0, 255], (8, 1)))
    other = gnurt.Scene()
    other.add_mesh(mesh, material=other.add_material(**white))
    assert (np.asarray(other.render(32, 24, camera=FRONT, **SMALL))[12, 16] == pixel).all()


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda s: s.render(0, 5), ValueError, "width: .*from 1"),
        (lambda s: s.render(5, 5.5), TypeError, "height: .*whole"),
        (lambda s: s.render(5, 5, sppp=3), TypeError, "sppp: unknown argument.*spp"),
        (lambda s: s.render(5, 5, integrator="pth"), ValueError, "integrator: .*path"),
        (lambda s: s.render(5, 5, camera=3), IndexError, "camera: 3 is out of range"),
        (lambda s: s.render(5, 5, camera="front"), ValueError, "camera: unknown name 'front'"),
        (lambda s: s.render(5, 5, camera=4.5), TypeError, "camera: .*gnurt.Camera"),
        (lambda s: s.render(5, 5, camera=gnurt.Camera((0, 0, 0), (0, 0, 0))), ValueError, "target"),
        (lambda s: s.render(5, 5, at=1), ValueError, "at: the scene has no animation"),
        (lambda s: s.render(5, 5, denoise="best"), ValueError, "denoise: "),
        (lambda s: s.render(5, 5, crop=(9, 9, 10, 10)), ValueError, "crop"),
        (lambda s: s.render(10**5, 10**5), (ValueError, MemoryError), "large|memory"),
        (lambda s: s.render(5, 5, noise=0.1, integrator="ir"), ValueError, "noise"),
        (lambda s: s.add_mesh(np.zeros((3, 3))), TypeError, "faces: are missing"),
        (lambda s: s.add_mesh(*cube(), material=7), IndexError, "material: 7 is out of range"),
        (lambda s: s.add_mesh(*cube(), colors=np.zeros((2, 4))), ValueError, r"colors: expected shape \(8, 4\)"),
        (lambda s: s.add_material(kind="wood"), ValueError, "kind: .*principled"),
        (lambda s: s.add_material(roughness=2), ValueError, "roughness: .*0 to 1"),
        (lambda s: s.add_material(color="red"), TypeError, "color: expected 3 finite numbers"),
        (lambda s: s.add_material(kind="mirror", metallic=1), TypeError, "metallic: unknown argument"),
        (lambda s: s.add_light("sun"), ValueError, "kind: .*directional"),
        (lambda s: s.add_light("point"), ValueError, "position: a point light needs one"),
        (lambda s: s.add_light("spot", position=(0, 0, 1), direction=(0, 0, -1), edge="round"), ValueError, "edge: .*smooth"),
        (lambda s: s.add_light("point", position=(0, 0, 1), radius=-1), ValueError, "radius"),
        (lambda s: s.add_light("environment", sky="night"), ValueError, "sky: .*evening"),
        (lambda s: s.add_light("environment", picture="nowhere.hdr"), OSError, "nowhere.hdr"),
        (lambda s: s.update(5), IndexError, "instance: 5 is out of range"),
        (lambda s: s.update(0, vertices=np.zeros((2, 3))), ValueError, r"vertices: .*\(8, 3\)"),
        (lambda s: gnurt.load("nowhere.glb"), OSError, "nowhere.glb"),
        (lambda s: gnurt.load("builtin:cornel"), ValueError, "cornell"),
    ],
)
def test_wrong_arguments(call, error, words):
    scene = red_cube()
    before = repr(scene)
    with pytest.raises(error, match=words):
        call(scene)
    assert repr(scene).split(",")[0] == before.split(",")[0]


def test_ctrl_c():
    # Programs in the background of a shell begin without a handler.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        gnurt.load("builtin:cornell").render(400, 300, spp=100_000)
    assert time.monotonic() - begin < 20

    def refuse(done):
        raise RuntimeError(f"enough at {done}")

    with pytest.raises(RuntimeError, match="enough"):
        gnurt.load("builtin:cornell").render(400, 300, spp=100_000, progress=refuse)


def test_others_run_meanwhile():
    scene, counted = gnurt.load("builtin:cornell"), []
    thread = threading.Thread(target=lambda: scene.render(100, 80, spp=16))
    thread.start()
    while thread.is_alive():
        counted.append(1)
        time.sleep(0.001)
    assert len(counted) > 5


def test_others_run_while_scenes_are_described(tmp_path):
    """Neither they nor the scene wait for a picture that is read, or a shader that is compiled."""
    body = "".join(f"c += noise (P * {i}.5) * sin (c * {i}.25);" for i in range(1000))
    scene, sky = red_cube(), tmp_path / "sky.pfm"
    sky.write_bytes(b"PF\n2048 1024\n-1\n" + np.ones(2048 * 1024 * 3, np.float32).tobytes())
    for call in (
        lambda: scene.add_light("environment", picture=sky),
        lambda: scene.add_material("heavy", shader=f"surface heavy () {{ color c = 0; {body} Ci = c * emission (); }}"),
    ):

        def share():
            """Of the call's time, during which this thread could do nothing."""
            # Without a global lock, a thread that starts may keep the processor of the one that started it.
            begin, times = threading.Event(), []
            job = threading.Thread(target=lambda: (begin.wait(), times.append(time.monotonic()), call(), times.append(time.monotonic())))
            job.start()
            begin.set()
            while job.is_alive():
                assert len(scene.cameras) == 0
                times.append(time.monotonic())
            times.sort()
            return np.diff(times).max() / (times[-1] - times[0])

        assert min(share() for _ in range(5)) < 0.6


def test_lenses_and_projections(tmp_path):
    scene = red_cube()
    flat = gnurt.Camera((0.5, 0.5, 4), (0.5, 0.5, 0), projection="orthographic", view_height=2, name="flat")
    seen = np.asarray(scene.render(40, 40, integrator="normals", camera=flat))[..., 3]
    assert abs(seen.sum() - 20 * 20) < 4, "parallel rays: a cube of 1 in a picture of 2"
    scene.add_camera(flat)
    scene.add_camera(gnurt.Camera((0, 0, 5), (0, 0, 0), aperture=0.5, focus=3))
    assert scene.cameras[0] == flat and scene.cameras[1].focus == 3 and "aperture=0.5" in repr(scene.cameras[1])
    sharp, soft = (
        np.asarray(scene.render(40, 40, integrator="eyelight", spp=16, camera=gnurt.Camera((0.5, 0.5, 4), (0.5, 0.5, 0), **lens)))
        for lens in ({}, {"aperture": 0.5, "focus": 1})
    )
    assert np.abs(np.diff(sharp[20, :, 3])).max() > 2 * np.abs(np.diff(soft[20, :, 3])).max(), "edges are soft"
    for wrong, message in (
        ({"projection": "fishy"}, "projection: expected one of perspective"),
        ({"view_height": 2}, "view_height: is of orthographic cameras"),
        ({"aperture": -1}, "aperture"),
        ({"focus": 0}, "focus"),
        ({"fov": 200}, "angle of view"),
        ({"lens": 35, "fov": 40}, "lens: conflicts with fov"),
        ({"lens": 0}, "lens: expected a focal length"),
        ({"shift": (0, 2000)}, "shift is"),
        ({"shift": (0, 0.1), "projection": "panorama"}, "a panorama has no shift"),
    ):
        with pytest.raises(ValueError, match=message):
            scene.add_camera(gnurt.Camera((0, 0, 5), (0, 0, 0), **wrong))
    with pytest.raises(TypeError, match="shift: expected 2 finite numbers"):
        scene.add_camera(gnurt.Camera((0, 0, 5), (0, 0, 0), shift=(1, 2, 3)))
    # A focal length of half the sensor's height is an angle of 90 degrees.
    shifted = gnurt.Camera((0.5, 0.5, 2), (0.5, 0.5, 0), lens=12, sensor=24, shift=(0.25, -0.125))
    assert abs(shifted.fov - 90) < 1e-6 and "shift=(0.25, -0.125)" in repr(shifted)
    at = scene.render(41, 41, integrator="eyelight", spp=1, camera=shifted, layers=["position"])["P"][20, 20]
    assert np.abs(at - (1.0, 0.25, 1)).max() < 2 / 41, f"the middle shows what is a quarter of 2 to the right: {at}"
    scene.add_camera(shifted)
    assert scene.cameras[-1] == shifted
    with pytest.raises(ValueError, match="shutter: .*at=SECONDS"):
        scene.render(8, 8, shutter=1)
    wind = gnurt.load("builtin:wind")
    still, moving = (
        np.asarray(wind.render(32, 24, integrator="eyelight", spp=4, at=0.5, shutter=s))[..., :3] for s in (0, 0.4)
    )
    assert (still != moving).any() and abs(still.mean() - moving.mean()) < 0.1 * still.mean()


def test_skies():
    def under(*skies):
        scene = gnurt.Scene()
        scene.add_mesh(np.array([[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]]), np.array([[0, 1, 2], [0, 2, 3]]))
        light = scene.add_light("environment", sky=skies[0])
        pictures = []
        for sky in [None, *skies[1:]]:
            if sky is not None:
                scene.set_light(light, "environment", sky=sky)
            camera = gnurt.Camera((0, 2, 7), (0, 1, 0))
            pictures.append(np.asarray(scene.render(32, 24, spp=4, camera=camera)))
        return pictures[-1]

    for skies in (("day", "evening"), ("evening", "overcast"), ("overcast", "day"), ("day", "overcast", "evening")):
        assert np.allclose(under(*skies).mean((0, 1)), under(skies[-1]).mean((0, 1)), rtol=0.05), skies


def test_layers_of_light():
    scene = gnurt.load("builtin:cornell")
    scene.set("materials.light.group=lamp")
    parts = ["diffuse", "glossy", "transmission", "volume", "emission", "environment"]
    picture = scene.render(24, 18, spp=4, layers=[*parts, "caustic=C<RD><.S>+L"], light_groups=True)
    whole = np.asarray(picture)[..., :3]
    assert np.allclose(sum(picture[name] for name in parts), whole, atol=1e-5, rtol=1e-5)
    assert picture.light_groups == ["lamp", "rest"] and "caustic" in picture.layers
    assert np.allclose(picture["light.lamp"] + picture["light_rest"], whole, atol=1e-5, rtol=1e-5)
    relit = picture.relight(lamp=(2, 1, 0), rest=0)
    assert np.allclose(np.asarray(relit)[..., :3], whole * (2, 1, 0), atol=1e-5, rtol=1e-5)
    grown = list(scene.accumulate(24, 18, spp=4, layers="direct,indirect,emission,environment"))[-1]
    assert np.allclose(sum(grown[name] for name in ["direct", "indirect", "emission", "environment"]), whole, atol=1e-5, rtol=1e-5)
    with pytest.raises(ValueError, match="unknown layer 'dirct'"):
        scene.render(8, 8, layers="dirct")
    with pytest.raises(ValueError, match="called 'kye'; light groups are: lamp"):
        scene.render(8, 8, layers=["light:kye"])
    with pytest.raises(ValueError, match="unsupported with the integrator bir"):
        scene.render(8, 8, layers=["diffuse"], integrator="bir")
    virtual = scene.render(8, 8, layers=["emission", "environment", "direct", "indirect"], integrator="bir")
    parts = sum(virtual[name] for name in ["emission", "environment", "direct", "indirect"])
    assert np.allclose(parts, np.asarray(virtual)[..., :3], atol=1e-5, rtol=1e-5), "the parts of virtual lights"
    with pytest.raises(ValueError, match="unknown light group 'lmap'"):
        picture.relight(lmap=2)
    with pytest.raises(ValueError, match="unknown name 'nothing'"):
        scene.set("materials.nothing.group=a")


def test_mattes():
    scene = gnurt.load("builtin:spheres")
    picture = scene.render(40, 30, spp=4, layers="cryptomatte", crypto_depth=8)
    names = json.loads(next(v for k, v in picture.metadata.items() if k.endswith("manifest") and "red" in v))
    total = sum(picture.matte(name) for name in scene.instances)
    assert np.allclose(total, np.asarray(picture)[..., 3], atol=1e-6) and "red" in names
    assert picture.matte("checkerboard", "material").max() == 1 and picture.matte("nothing").max() == 0
    with pytest.raises(KeyError, match="cryptomatte"):
        scene.render(8, 8).matte("red")


def test_meshes_bend():
    vertices, faces = cube()
    normals = np.tile([0.0, 0, 1], (8, 1))

    def shown(motion, **properties):
        scene = gnurt.Scene()
        red = scene.add_material("red", color=(0.8, 0.1, 0.1), kind="matte")
        scene.add_mesh(vertices, faces, material=red, normals=normals, **properties)
        scene.add_light("environment", radiance=1)
        options = {"spp": 64, "camera": FRONT, "threads": 2}
        return [np.asarray(scene.render(32, 24, motion=how, **options)) for how in (motion, None)]

    shift = np.array([1.0, 0.5, 0])
    places = [np.eye(4) for _ in range(3)]
    places[1][:3, 3], places[2][:3, 3] = shift / 4, shift
    keys = [vertices + place[:3, 3] for place in places]
    bent, still = shown({"meshes": [0]}, moments={"vertices": keys, "normals": [normals] * 3})
    moved, _ = shown({"instances": {0: places}})
    assert np.abs(bent - moved).mean() < 0.01 and np.abs(bent - still).mean() > 0.05
    # Without motion it has its own shape, also after it was bent.
    assert np.allclose(still, shown(None)[0], atol=1e-5)
    for motion, properties, message in (
        ({"meshes": [7]}, {}, "instance 7 is out of range"),
        ({"meshes": [0]}, {}, "has no moments"),
        ({"meshes": [0]}, {"moments": {"vertices": keys}}, "normals at some moments"),
        ({"meshes": "all"}, {}, "list of numbers"),
    ):
        with pytest.raises((ValueError, IndexError, TypeError), match=message):
            shown(motion, **properties)


def test_a_camera_that_moves_alone_blurs():
    scene = red_cube()
    scene.add_light("environment", radiance=1)
    aside = gnurt.Camera(eye=(1.5, 0.5, 4), target=(1.5, 0.5, 0), fov=40)
    back = np.eye(4)
    back[0, 3] = -1
    options = {"spp": 64, "camera": FRONT}
    seen, moved, still = (
        np.asarray(scene.render(32, 24, motion=motion, **options)) for motion in ({"cameras": [FRONT, aside]}, {"instances": {0: [np.eye(4), back]}}, None)
    )
    assert np.abs(seen - moved).mean() < 0.01 and np.abs(seen - still).mean() > 0.05


def test_the_working_space(tmp_path):
    import pickle

    albedo, light = np.array([0.8, 0.2, 0.1]), np.array([0.2, 1.0, 3.0])
    matrix = np.array([[0.61309732, 0.33952285, 0.04737928], [0.07019422, 0.91635557, 0.01345259], [0.02061560, 0.10956983, 0.86981512]])
    expected = {"rec709": albedo * light, "acescg": np.linalg.solve(matrix, (matrix @ albedo) * (matrix @ light))}
    scenes = []
    for shader in (None, "surface red() { Ci = color(0.8, 0.2, 0.1) * diffuse(N); }"):
        scene = gnurt.Scene()
        red = scene.add_material("red", shader=shader) if shader else scene.add_material("red", color=albedo, kind="matte")
        scene.add_mesh([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]], material=red)
        scene.add_light("environment", radiance=light)
        scenes.append(scene)
    above = gnurt.Camera(eye=(0, 0, 2), target=(0, 0, 0), fov=5)
    for scene in scenes:
        # There and back.
        for space in ("acescg", "rec709", "acescg"):
            picture = scene.render(8, 8, spp=64, camera=above, working_space=space)
            mean = np.asarray(picture)[..., :3].mean(axis=(0, 1))
            assert np.allclose(mean, expected[space], atol=0.01, rtol=0.01), (space, mean)
    for name, options, red in (("a.exr", {}, 0.713), ("b.exr", {"primaries": "rec709"}, 0.64)):
        pickle.loads(pickle.dumps(picture)).save(tmp_path / name, exact=True, **options)
        head = (tmp_path / name).read_bytes()
        at = head.index(b"chromaticities\0chromaticities\0") + 34
        assert np.frombuffer(head[at : at + 4], "<f4")[0] == np.float32(red), name
        assert np.allclose(np.asarray(gnurt.Picture(tmp_path / name)), np.asarray(picture), atol=1e-4)
    with pytest.raises(ValueError, match="working_space: .*valid.*rec709, acescg"):
        scene.render(8, 8, working_space="aces")


def test_blue_noise_cancels_out_between_neighbours():
    """Noise is the difference of two seeds; means of 4 x 4 pixels have less of it than of white noise."""
    scene = gnurt.load("builtin:cornell")

    def noise(kind):
        pictures = (scene.render(64, 64, spp=1, seed=seed, max_depth=2, pixel_noise=kind) for seed in (1, 2))
        first, second = (np.minimum(np.asarray(picture)[..., 0], 1) for picture in pictures)
        difference = first - second
        return np.square(difference.reshape(16, 4, 16, 4).mean(axis=(1, 3))).mean()

    assert noise("blue") < 0.7 * noise("white")
    with pytest.raises(ValueError, match="white, blue"):
        scene.render(8, 8, spp=1, pixel_noise="pink")
