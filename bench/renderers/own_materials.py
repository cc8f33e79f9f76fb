# SPDX-License-Identifier: GPL-3.0-or-later
"""Times path tracing by Mitsuba 3 and by gnurt on interiors with their own glass, metal, plastic and textures, at equal error.

    python3 own_materials.py SCENES CAMERAS GNURT [--variant llvm_ad_rgb] [--spp 16] [--pictures 6] [--json FILE] [SCENE ...]

SCENES is the folder of unpacked scenes, CAMERAS their cameras.json (the first view is taken), GNURT the program. Each program renders
independent pictures; the error is their variance over pixels, so that no reference is needed and each is measured against its own
mean: plastics and rough metal are Mitsuba's own models, which differ a little from ours (docs/materials.md), matte, mirrors and smooth
glass are the same. relMSE = variance over (smoothed mean squared + a hundredth of the picture's squared mean), as in `bench light`.
One thread, one process each, in turns; CPU seconds without reading, trees and kernels. Needs `pip install mitsuba numpy` and, for llvm
variants, a libLLVM (DRJIT_LIBLLVM_PATH). Source: original.
"""
import argparse
import json
import math
import os
import resource
import subprocess
import tempfile
import time

import mitsuba as mi
import numpy as np

import equal_error
import interiors
import mitsuba_path

DEPTH = 9
MIRROR_EXPONENT = 1000.0


def read_phong(path):
    """The statements of each material of an MTL file that say how it scatters."""
    materials, current = {}, None
    for line in open(path, errors="replace"):
        words = line.split()
        if words[:1] == ["newmtl"]:
            current = materials.setdefault(words[1], {})
        elif words and words[0] in ("Kd", "Ks", "Tf", "Ns", "Ni", "d", "illum", "map_d"):
            current[words[0]] = words[1:]
    return materials


def bsdf(phong, part, reflectance):
    """Mitsuba's model that is nearest to what gnurt makes of an MTL material (crates/scene/src/io/obj/material.rs)."""
    number = lambda key, default: float(phong[key][0]) if key in phong else default
    colour = lambda key, default: [float(x) for x in phong[key][:3]] if key in phong else default
    rgb = lambda value: {"type": "rgb", "value": list(value)}
    kd, ks = colour("Kd", [0.0] * 3), colour("Ks", [0.0] * 3)
    mean = lambda c: sum(c) / 3
    exponent, opacity = number("Ns", None), number("d", 1.0)
    alpha = math.sqrt(2 / (exponent + 2)) if exponent is not None else None
    twosided = lambda nested: {"type": "twosided", "nested": nested}
    illum, black = int(number("illum", 2)), mean(kd) == 0 and not part.texture
    if illum in (4, 6, 7, 9) or (opacity < 1 and black and ("Tf" in phong or number("Ni", 1.0) > 1)):
        return {"type": "dielectric", "int_ior": number("Ni", 1.5), "ext_ior": 1.0, "specular_transmittance": rgb(colour("Tf", [1.0] * 3))}
    if (illum in (3, 5) and mean(ks) > mean(kd)) or (black and mean(ks) >= 0.2):
        metal = {"material": "none", "specular_reflectance": rgb(ks)}
        if exponent is None or exponent >= MIRROR_EXPONENT:
            made = twosided({"type": "conductor", **metal})
        else:
            made = twosided({"type": "roughconductor", "distribution": "ggx", "alpha": alpha, **metal})
    elif exponent is not None and mean(ks) > 0 and not black:
        root = math.sqrt(min(mean(ks), 0.95))
        ior = (1 + root) / (1 - root)
        plastic = {"diffuse_reflectance": reflectance, "int_ior": ior, "ext_ior": 1.0, "nonlinear": False}
        # Mitsuba has no rough plastic that is nearly smooth.
        if alpha < 0.02:
            made = twosided({"type": "plastic", **plastic})
        else:
            made = twosided({"type": "roughplastic", "distribution": "ggx", "alpha": alpha, **plastic})
    else:
        made = twosided({"type": "diffuse", "reflectance": reflectance})
    return {"type": "mask", "opacity": opacity, "nested": made} if opacity < 1 else made


def reflectance(part):
    """Kd times map_Kd."""
    if not part.texture:
        return {"type": "rgb", "value": list(part.reflectance)}
    bitmap = mi.Bitmap(part.texture).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    data = (np.array(bitmap) * np.array(part.reflectance, np.float32)).astype(np.float32)
    return {"type": "bitmap", "data": mi.TensorXf(data), "raw": True, "filter_type": "bilinear", "wrap_mode": "repeat"}


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
        self.words = [arguments.gnurt, "render", path, *interiors.camera_arguments(camera), "--integrator=path"]
        self.words += [f"--max-depth={DEPTH}", "-t=1", "-q", "--filter=box"]
        self.output = os.path.join(folder, "own.pfm")
        self.once = min(self.run(1, seed) for seed in (0, 1))

    def run(self, spp, seed):
        return cpu_of([*self.words, f"--spp={spp}", f"--seed={seed}", "-o", self.output])

    def render(self, spp, seed):
        # What one sample costs holds all that is done once.
        seconds = (self.run(spp + 1, seed) - self.once) * (spp + 1) / spp
        return equal_error.read_pfm(self.output), seconds, spp + 1


class Mitsuba:
    def __init__(self, arguments, scene, camera, folder):
        parts = interiors.read(arguments.scenes, scene)
        phong = read_phong(os.path.join(arguments.scenes, scene, scene + ".mtl"))
        bsdfs = {part.name: bsdf(phong[part.name], part, reflectance(part)) for part in parts}
        self.scene = mitsuba_path.load_scene(parts, camera, folder, bsdfs, DEPTH)
        mi.render(self.scene, spp=arguments.spp, seed=99).numpy()  # compiles

    def render(self, spp, seed):
        start = time.process_time()
        picture = mi.render(self.scene, spp=spp, seed=seed).numpy().astype(np.float64)
        return picture, time.process_time() - start, spp


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
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--pictures", type=int, default=6)
    parser.add_argument("--size", type=int, nargs=2, default=(256, 192))
    parser.add_argument("--json")
    arguments = parser.parse_intermixed_args()
    mi.set_variant(arguments.variant)
    import drjit as dr

    dr.set_thread_count(1)
    views, found, shares = json.load(open(arguments.cameras)), [], []
    print("| scene | renderer | spp | CPU s | relMSE | trimmed | mean | relMSE x s | trimmed x s |\n|---|---|---|---|---|---|---|---|---|")
    for scene in arguments.only:
        camera, worth = camera_of(views, scene, arguments.size), []
        with tempfile.TemporaryDirectory() as folder:
            programs = [Gnurt(arguments, scene, camera, folder), Mitsuba(arguments, scene, camera, folder)]
            taken = [[], []]
            for seed in range(arguments.pictures):
                for program, into in zip(programs, taken):
                    into.append(program.render(arguments.spp, seed))
        for name, rendered in zip(("gnurt", f"Mitsuba {mi.__version__}"), taken):
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
