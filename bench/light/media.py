# SPDX-License-Identifier: GPL-3.0-or-later
"""Twelve scenes of media beside Mitsuba's `volpathmis`: `python3 bench/light/media.py PROGRAM [--spp 512] [--volpath] [--time] [SCENE...]`.

Needs mitsuba and numpy. Each scene is written twice: as a file of pbrt for PROGRAM, and as Mitsuba's dictionary. Prints the ratio of the
means of both pictures by colour, and its standard error from the pixels' differences between four renderings.

`--time`: equal error instead: the variance of pixels times processor seconds of one thread, ours over Mitsuba's (`llvm_ad_rgb`, its own
roulette, compiled before), as bench/renderers/own_materials.py.
"""

import argparse
import math
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb" if "--time" in sys.argv else "scalar_rgb")

WIDTH, HEIGHT, DEPTH, RUNS = 48, 36, 500, 4
T = mi.ScalarTransform4f
CORNERS = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
FACES = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]


def triple(value):
    return list(value) if isinstance(value, (list, tuple)) else [value] * 3


def smoke():
    """Densities of 12 x 10 x 8 cells, [z, y, x]: a ball with a dense and an empty part."""
    z, y, x = np.meshgrid(*[(np.arange(n) + 0.5) / n * 2 - 1 for n in (8, 10, 12)], indexing="ij")
    away = np.sqrt(x * x + y * y + z * z)
    return np.clip(1 - away, 0, None).astype(np.float32) * (1 + 2 * (x > 0.2)) * (1 - (y > 0.4))


class Medium:
    """A medium: coefficients, the mean cosine, and perhaps a grid in the cube."""

    def __init__(self, absorption, scattering, g=0.0, grid=None):
        self.absorption, self.scattering, self.g, self.grid = triple(absorption), triple(scattering), g, grid

    def ours(self, name):
        kind = "homogeneous" if self.grid is None else "uniformgrid"
        text = f'MakeNamedMedium "{name}" "string type" "{kind}" "float g" {self.g}\n'
        for key, value in (("sigma_a", self.absorption), ("sigma_s", self.scattering)):
            text += f'  "rgb {key}" [{" ".join(map(str, value))}]\n'
        if self.grid is not None:
            nz, ny, nx = self.grid.shape
            text += f'  "integer nx" {nx} "integer ny" {ny} "integer nz" {nz} "point3 p0" [-1 -1 -1] "point3 p1" [1 1 1]\n'
            text += f'  "float density" [{" ".join(map(str, self.grid.ravel()))}]\n'
        return text

    def theirs(self):
        extinction = [a + s for a, s in zip(self.absorption, self.scattering)]
        albedo = [s / e if e else 0 for s, e in zip(self.scattering, extinction)]
        phase = {"type": "hg", "g": self.g} if self.g else {"type": "isotropic"}
        if self.grid is None:
            return {
                "type": "homogeneous",
                # Colours are at most 1.
                "sigma_t": {"type": "rgb", "value": [e / max(extinction) for e in extinction]},
                "scale": max(extinction),
                "albedo": {"type": "rgb", "value": albedo},
                "phase": phase,
            }
        # A rim of zeros, as pbrt's grids end: Mitsuba repeats the outermost cells.
        grid = np.pad(self.grid, 1) * extinction[0]
        cells = [n / (n - 2) for n in grid.shape[::-1]]
        place = T().scale(cells) @ T().translate([-1, -1, -1]) @ T().scale([2, 2, 2])
        volume = {"type": "gridvolume", "grid": mi.VolumeGrid(grid[..., None].astype(np.float32)), "to_world": place, "filter_type": "trilinear"}
        return {"type": "heterogeneous", "sigma_t": volume, "albedo": {"type": "rgb", "value": albedo}, "phase": phase}


def cube(size, middle):
    points = [tuple(size * x + m for x, m in zip(corner, middle)) for corner in CORNERS]
    return points, FACES


class Scene:
    """Bodies, lamps and a camera, in both programs' words."""

    def __init__(self, eye=(0.4, 0.8, -5), target=(0, 0, 0), fov=40, sky=1.0):
        self.eye, self.target, self.fov = eye, target, fov
        self.text, self.inside_of_camera = "", None
        rgb = " ".join(map(str, triple(sky)))
        self.head = f'LightSource "infinite" "rgb L" [{rgb}]\n' if sky else ""
        self.dictionary = {"type": "scene"}
        if sky:
            self.dictionary["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": triple(sky)}}

    def media(self, **media):
        self.named = {name: medium.theirs() for name, medium in media.items()}
        self.head += "".join(medium.ours(name) for name, medium in media.items())
        return self

    def add(self, points, faces, ours, theirs, inside=None, outside=None, light=None):
        mesh = mi.Mesh("body", len(points), len(faces))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = [x for point in points for x in point]
        parameters["faces"] = [i for face in faces for i in face]
        parameters.update()
        number = len(self.dictionary)
        path = Path(self.folder) / f"{number}.ply"
        mesh.write_ply(str(path))
        body = {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": theirs}
        for key, name in (("interior", inside), ("exterior", outside)):
            if name:
                body[key] = self.named[name]
        if light:
            body["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": triple(light)}}
        self.dictionary[f"body{number}"] = body
        lamp = f'AreaLightSource "diffuse" "rgb L" [{" ".join(map(str, triple(light)))}]\n' if light else ""
        medium = f'MediumInterface "{inside or ""}" "{outside or ""}"\n' if inside or outside else ""
        numbers = " ".join(str(i) for face in faces for i in face)
        places = " ".join(f"{x:.7f}" for point in points for x in point)
        self.text += f'AttributeBegin\n{lamp}{medium}{ours}\nShape "trianglemesh" "integer indices" [{numbers}] "point3 P" [{places}]\nAttributeEnd\n'
        return self

    def boundary(self, inside, outside=None, size=1.0, middle=(0, 0, 0)):
        return self.add(*cube(size, middle), 'Material "interface"', {"type": "null"}, inside, outside)

    def glass(self, inside, ior=1.5, size=1.0, middle=(0, 0, 0)):
        theirs = {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
        return self.add(*cube(size, middle), f'Material "dielectric" "float eta" {ior}', theirs, inside)

    def floor(self, height=-1.2):
        points = [(-4, height, -4), (4, height, -4), (4, height, 4), (-4, height, 4)]
        theirs = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.4, 0.2]}}}
        return self.add(points, [(0, 2, 1), (0, 3, 2)], 'Material "diffuse" "rgb reflectance" [0.6 0.4 0.2]', theirs)

    def lamp(self, size, middle, light):
        black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0, 0, 0]}}
        return self.add(*cube(size, middle), 'Material "diffuse" "rgb reflectance" [0 0 0]', black, light=light)


def scenes(folder):
    Scene.folder = folder
    grey = Medium(0.2, 0.8)
    red = Medium((0.05, 0.4, 0.9), (1.5, 1.0, 0.4))
    yield "fog", Scene().media(m=grey).boundary("m").floor()
    yield "coloured", Scene().media(m=red).boundary("m").floor()
    yield "forward", Scene(sky=0.2).media(m=Medium(0.1, 3.0, 0.8)).boundary("m").floor().lamp(0.3, (0, 3, 2), 40)
    yield "backward", Scene(sky=0.2).media(m=Medium(0.1, 3.0, -0.5)).boundary("m").floor().lamp(0.3, (0, 3, 2), 40)
    yield "smoke", Scene().media(m=Medium(1.0, 4.0, 0.3, smoke())).boundary("m").floor()
    inside = Scene(eye=(0.2, 0.1, -0.6), fov=70).media(m=red).boundary("m").floor()
    # GNU RT finds by itself where the camera is.
    inside.inside_of_camera = "m"
    yield "inside", inside
    nested = Scene().media(m=grey, n=Medium((2.0, 0.5, 0.1), (2.0, 3.0, 4.0), 0.5))
    yield "nested", nested.boundary("m").boundary("n", "m", 0.5).floor()
    yield "chromatic", Scene().media(m=Medium((0.0, 0.1, 6.0), (20.0, 2.0, 0.5))).boundary("m").floor()
    yield "skin", Scene().media(m=Medium((0.03, 0.17, 0.48), (7.4, 8.8, 10.1), 0.0)).glass("m", 1.4).floor()
    yield "wax", Scene(sky=0.3).media(m=Medium((0.02, 0.1, 0.4), (12.0, 12.0, 10.0), 0.7)).glass("m", 1.3).floor().lamp(0.4, (2, 3, -2), 20)
    yield "glass", Scene().media(m=Medium((0.1, 0.5, 1.0), 0.0)).glass("m").floor()
    yield "lamp", Scene(sky=0.0).media(m=Medium(0.05, 0.25)).boundary("m", size=1.0).floor().lamp(0.05, (0.1, 0.3, 0.2), 100)


def ours(program, scene, folder, spp, seed, *more):
    numbers = " ".join(map(str, (*scene.eye, *scene.target, 0, 1, 0)))
    text = f'LookAt {numbers}\nCamera "perspective" "float fov" {scene.fov}\n'
    text += "WorldBegin\n"
    path, picture = folder / "scene.pbrt", folder / "picture.pfm"
    path.write_text(text + scene.head + scene.text)
    command = [program, "render", path, "--integrator", "path", "--spp", str(spp), "--seed", str(seed), "--max-depth", str(DEPTH)]
    command += ["-r", f"{WIDTH}x{HEIGHT}", "--denoise=none", "--filter", "box", "-q", "-o", picture, *more]
    if "sky" not in scene.dictionary:
        command += ["--environment", "0,0,0"]
    subprocess.run(command, check=True)
    return np.array(mi.Bitmap(str(picture)))[..., :3]


def loaded(scene, spp, integrator, **more):
    scene.dictionary["integrator"] = {"type": integrator, "max_depth": DEPTH, **more}
    scene.dictionary["sensor"] = {
        "type": "perspective", "fov": scene.fov, "fov_axis": "smaller",
        "to_world": T().look_at(list(scene.eye), list(scene.target), [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}},
        "sampler": {"type": "independent", "sample_count": spp},
    }
    body = scene.inside_of_camera
    if body:
        scene.dictionary["sensor"]["medium"] = scene.named[body]
    return mi.load_dict(scene.dictionary)


def theirs(scene, spp, integrator):
    scene = loaded(scene, spp, integrator, rr_depth=10 * DEPTH)
    return [np.array(mi.render(scene, seed=seed + 1))[..., :3] for seed in range(RUNS)]


def equal_error(arguments, name, scene, folder):
    """Our product of variance and time over Mitsuba's."""
    import drjit

    drjit.set_thread_count(1)
    spp, integrator = arguments.spp, "volpath" if arguments.volpath else "volpathmis"
    used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    rival = loaded(scene, spp, integrator)
    np.array(mi.render(rival, seed=99))
    pictures, seconds = ([], []), ([], [])

    def own(samples, seed):
        start = used()
        picture = ours(arguments.program, scene, folder, samples, seed, "-t", "1")
        return picture, used() - start

    once = min(own(1, seed)[1] for seed in (1, 2))
    for seed in range(1, RUNS + 1):
        picture, taken = own(spp + 1, seed)
        pictures[0].append(picture)
        seconds[0].append(taken - once)
        start = time.process_time()
        pictures[1].append(np.array(mi.render(rival, seed=seed))[..., :3])
        seconds[1].append(time.process_time() - start)
    errors = []
    for stack in map(np.array, pictures):
        mean = stack.mean((0, 3))
        errors.append(np.sort((stack.var(0, ddof=1).mean(-1) / (mean**2 + 0.01 * mean.mean() ** 2)).ravel()))
    times = [float(np.median(each)) for each in seconds]
    most = [np.mean(error[: -max(1, len(error) // 1000)]) for error in errors]
    variance = errors[0].mean() / errors[1].mean()
    product = variance * times[0] / times[1]
    print(
        f"{name:10} variance {variance:.3f} time {times[0]:.2f} s over {times[1]:.2f} s = {times[0] / times[1]:.3f} "
        f"product {product:.3f} without the worst thousandth {most[0] / most[1] * times[0] / times[1]:.3f}",
        flush=True,
    )
    return product


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program")
    arguments.add_argument("--spp", type=int, default=256)
    arguments.add_argument("--volpath", action="store_true", help="the integrator volpath in place of volpathmis")
    arguments.add_argument("--time", action="store_true", help="variance times time in place of means")
    arguments.add_argument("scenes", nargs="*")
    arguments = arguments.parse_intermixed_args()
    products = []
    with tempfile.TemporaryDirectory() as folder:
        for name, scene in scenes(folder):
            if arguments.scenes and name not in arguments.scenes:
                continue
            if arguments.time:
                products.append(equal_error(arguments, name, scene, Path(folder)))
                continue
            a = [ours(arguments.program, scene, Path(folder), arguments.spp, seed + 1) for seed in range(RUNS)]
            b = theirs(scene, arguments.spp, "volpath" if arguments.volpath else "volpathmis")
            means = [np.array([picture.mean((0, 1)) for picture in pictures]) for pictures in (a, b)]
            ratio = means[0].mean(0) / means[1].mean(0)
            error = np.sqrt(sum((m.std(0, ddof=1) / m.mean(0)) ** 2 for m in means) / RUNS)
            print(f"{name:10}", *(f"{r:.4f} +- {e:.4f}" for r, e in zip(ratio, error)), flush=True)
    if products:
        print(f"geometric mean of products {math.exp(np.mean(np.log(products))):.3f}")


if __name__ == "__main__":
    main()
