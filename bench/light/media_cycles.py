# SPDX-License-Identifier: GPL-3.0-or-later
"""Media, skin and hair beside Cycles at equal error: `python3 bench/light/media_cycles.py [--spp 64] [--pictures 4] [SCENE...]`.

Needs bpy and the package of GNU RT for Python (bindings/python, built for release). Scenes are those of bindings/blender/tests; each engine renders each scene with
several seeds, one thread, by turns. Prints the variance of pixels relative to each engine's own mean (what differs between the engines' materials does
not count), processor seconds less those of one sample, and the product of both ratios, ours over Cycles'.
"""

import argparse
import math
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bindings/blender/tests"))
from common import bpy, np, render, start  # noqa: E402
from scenes import SCENES  # noqa: E402

CHOSEN = ["world_fog", "camera_in_fog", "volume_nodes", "volumes_in_glass", "smoke", "fire", "lamps_and_smoke", "subsurface", "skin", "principled_subsurface"]
ENGINES = ["GNURT", "CYCLES"]


def taken(engine, samples, seed):
    """A picture and processor seconds."""
    scene = bpy.context.scene
    scene.cycles.seed = seed
    scene.gnurt.seed = seed
    before = sum(os.times()[:2])
    picture = render(engine, samples)[..., :3].astype(np.float64)
    return picture, sum(os.times()[:2]) - before


def compare(name, samples, pictures):
    start()
    SCENES[name]()
    scene = bpy.context.scene
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.gnurt.threads = 1
    once = {engine: min(taken(engine, 1, seed)[1] for seed in (1, 2)) for engine in ENGINES}
    found, seconds = {engine: [] for engine in ENGINES}, {engine: [] for engine in ENGINES}
    for seed in range(1, pictures + 1):
        for engine in ENGINES if seed % 2 else ENGINES[::-1]:
            picture, used = taken(engine, samples + 1, seed)
            found[engine].append(picture)
            seconds[engine].append(max(used - once[engine], 1e-3))
    errors, medians, means = [], [], []
    for engine in ENGINES:
        stack = np.array(found[engine])
        mean = stack.mean((0, 3))
        error = stack.var(0, ddof=1).mean(-1) / (mean**2 + 0.01 * mean.mean() ** 2)
        errors.append(np.sort(error.ravel()))
        medians.append(float(np.median(seconds[engine])))
        means.append(stack.mean())
    variance = errors[0].mean() / errors[1].mean()
    calm = [error[: -max(1, len(error) // 1000)].mean() for error in errors]
    speed = medians[0] / medians[1]
    print(
        f"{name:22} variance {variance:.3f} time {medians[0]:.2f} s over {medians[1]:.2f} s = {speed:.3f} product {variance * speed:.3f} "
        f"without the worst thousandth {calm[0] / calm[1] * speed:.3f} means {means[0]:.4f} {means[1]:.4f}",
        flush=True,
    )
    return variance * speed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--pictures", type=int, default=4)
    parser.add_argument("scenes", nargs="*")
    given = parser.parse_args()
    products = [compare(name, given.spp, given.pictures) for name in given.scenes or CHOSEN]
    print(f"geometric mean of products {math.exp(np.mean(np.log(products))):.3f}, most {max(products):.3f}")


if __name__ == "__main__":
    main()
