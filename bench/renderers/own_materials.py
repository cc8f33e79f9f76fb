# SPDX-License-Identifier: GPL-3.0-or-later
"""Times path tracing by another renderer and by gnurt on interiors with their own glass, metal, plastic and textures, at equal error.

    python3 own_materials.py SCENES CAMERAS GNURT [--against mitsuba] [--variant llvm_ad_rgb] [--spp 16] [--pictures 6] [--json FILE] [SCENE ...]

SCENES is the folder of unpacked scenes, CAMERAS their cameras.json (the first view is taken), GNURT the program, the other one Mitsuba 3 or
Blender's Cycles (own_mitsuba.py, own_cycles.py). Each program renders independent pictures; the error is their variance over pixels, so that
no reference is needed and each is measured against its own mean: plastics and rough metal are the other's own models, which differ a little
from ours (docs/reference/materials.md), matte, mirrors and smooth glass are the same. relMSE = variance over (smoothed mean squared + a hundredth of
the picture's squared mean), as in `bench light`. One thread, one process each, in turns; CPU seconds without reading, trees and kernels.
Needs `pip install numpy`. 
"""
import argparse
import importlib
import json
import math
import os
import resource
import subprocess
import tempfile

import numpy as np

import equal_error
import interiors
import own_models

DEPTH = 9
RIVALS = {"mitsuba": ("own_mitsuba", "Mitsuba"), "cycles": ("own_cycles", "Cycles")}


def camera_of(views, scene, size):
    view = views[scene][0]
    return (view["eye"], view["target"], view["up"], view["vfov"], *size)


def cpu_of(words):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Gnurt:
    def __init__(self, arguments, scene, camera, folder):
        path = os.path.join(arguments.scenes, scene, scene + ".obj")
        self.words = [arguments.gnurt, "render", path, *interiors.camera_arguments(camera)]
        self.words += [f"--max-depth={DEPTH}", "-t=1", "-q", "--filter=box", *(arguments.own or "--integrator=path").split()]
        self.output = os.path.join(folder, "own.pfm")
        # A pilot that chooses the integrator is part of the rendering.
        rendering, self.words = self.words, [word.replace("=auto", "=path") for word in self.words]
        self.once = min(self.run(1, seed) for seed in (0, 1))
        self.words = rendering

    def run(self, spp, seed):
        return cpu_of([*self.words, f"--spp={spp}", f"--seed={seed}", "-o", self.output])

    def render(self, spp, seed):
        # What one sample costs holds all that is done once.
        seconds = (self.run(spp + 1, seed) - self.once) * (spp + 1) / spp
        return equal_error.read_pfm(self.output), seconds, spp + 1


def smoothed(picture):
    """Means of 5 x 5 pixels and all channels."""
    grey = np.pad(picture.mean(axis=-1), 2, mode="edge")
    rows, columns = picture.shape[:2]
    return sum(grey[y : y + rows, x : x + columns] for y in range(5) for x in range(5)) / 25


def rel_mse(pictures):
    """Of one of them; and without the worst thousandth of the pixels."""
    stack = np.stack(pictures)
    mean, variance = stack.mean(axis=0), stack.var(axis=0, ddof=1).mean(axis=-1)
    pixels = np.sort((variance / (smoothed(mean) ** 2 + 0.01 * mean.mean() ** 2)).ravel())
    return pixels.mean(), pixels[: len(pixels) * 999 // 1000].mean(), mean.mean()


def main():
    parser = argparse.ArgumentParser()
    for name in ("scenes", "cameras", "gnurt"):
        parser.add_argument(name)
    parser.add_argument("only", nargs="*", default=["conference", "veach-ajar", "white-room", "modern-hall", "breakfast-room"])
    parser.add_argument("--against", choices=RIVALS, default="mitsuba")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--pictures", type=int, default=6)
    parser.add_argument("--size", type=int, nargs=2, default=(256, 192))
    parser.add_argument("--json")
    parser.add_argument("--own", default="", help="arguments of gnurt, in one word, in place of --own=--integrator=path")
    arguments = parser.parse_intermixed_args()
    file, rival = RIVALS[arguments.against]
    rival = getattr(importlib.import_module(file), rival)
    views, found, shares = json.load(open(arguments.cameras)), [], []
    print("| scene | renderer | spp | CPU s | relMSE | trimmed | mean | relMSE x s | trimmed x s |\n|---|---|---|---|---|---|---|---|---|")
    for scene in arguments.only:
        camera, worth = camera_of(views, scene, arguments.size), []
        textured = {part.name: bool(part.texture) for part in interiors.read(arguments.scenes, scene)}
        phong = own_models.read_phong(os.path.join(arguments.scenes, scene, scene + ".mtl"))
        models = {name: own_models.model(phong[name], textured[name]) for name in textured}
        with tempfile.TemporaryDirectory() as folder:
            programs = [Gnurt(arguments, scene, camera, folder), rival(arguments, scene, models, camera, DEPTH, folder)]
            taken = [[], []]
            for seed in range(arguments.pictures):
                for program, into in zip(programs, taken):
                    into.append(program.render(arguments.spp, seed))
        for name, rendered in zip(("gnurt", rival.name), taken):
            error, trimmed, mean = rel_mse([picture for picture, _, _ in rendered])
            seconds, spp = float(np.median([s for _, s, _ in rendered])), rendered[0][2]
            worth.append((error * seconds, trimmed * seconds))
            row = {"scene": scene, "renderer": name, "spp": spp, "cpu_seconds": seconds, "rel_mse": error, "trimmed": trimmed, "mean": mean}
            found.append(row)
            print(f"| {scene} | {name} | {spp} | {seconds:.2f} | {error:.5f} | {trimmed:.5f} | {mean:.4f} | {worth[-1][0]:.5f} | {worth[-1][1]:.5f} |", flush=True)
        shares.append([own / theirs for own, theirs in zip(*worth)])
        print(f"| {scene} | **our time over theirs at equal error** | | | | | | {shares[-1][0]:.3f} | {shares[-1][1]:.3f} |", flush=True)
        if arguments.json:
            kept = {"pictures": arguments.pictures, "size": list(arguments.size), "depth": DEPTH, "threads": 1, "rows": found}
            json.dump(kept, open(arguments.json, "w"), indent=1)
    means = [math.exp(float(np.mean(np.log(column)))) for column in zip(*shares)]
    print(f"| geometric mean | | | | | | | {means[0]:.3f} | {means[1]:.3f} |")


if __name__ == "__main__":
    main()
