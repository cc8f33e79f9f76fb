#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""relMSE of the denoisers on twelve scenes: denoise.py GNURT SCENES WORK [SCENE ...]

Needs numpy and OpenEXR (PyPI), and OIDN_LIB for Open Image Denoise. Renders what WORK lacks: 16 samples (seed 0), clean ones by
both denoisers, and REFERENCES independent references. A squared error is the product of the differences to two halves of those:
their noise is in neither mean. Prints relMSE, the same without the worst thousandth of the pixels, and the worst 16 x 16 tile.
"""
import json, os, subprocess, sys
import numpy as np
import OpenEXR

REFERENCES, SAMPLES = 6, 256
ALL = ("office conference white-room breakfast-room modern-hall veach-bidir veach-ajar sponza soda classroom cornell-box "
       "graz").split()
SQUARE = {"veach-bidir", "cornell-box"}
SKY = {"sponza": ["builtin:day", "155"], "breakfast-room": ["builtin:evening", "175"]}


def arguments(scenes, name, cameras):
    camera = cameras[name][0]
    place = [f"--{key}=" + ",".join(map(str, camera[key])) for key in ("eye", "target", "up")]
    size = "192x192" if name in SQUARE else "256x192"
    sky = SKY.get(name)
    around = ["--environment", sky[0], "--environment-turn", sky[1]] if sky else []
    file = os.path.join(scenes, name, name + ".obj")
    return [file, "-r", size, "--integrator", "path", f"--fov={camera['vfov']}", *place, *around]


def make(path, command):
    if not os.path.exists(path):
        unfinished = path.replace(".exr", ".unfinished.exr")
        subprocess.run([part if part != "OUT" else unfinished for part in command], check=True)
        os.rename(unfinished, path)


def colors(path):
    channels = OpenEXR.File(path).channels()
    return channels["RGBA" if "RGBA" in channels else "RGB"].pixels[..., :3].astype(np.float64)


def errors(path, references):
    """Per pixel."""
    picture, mean = colors(path), sum(references) / len(references)
    halves = [sum(half) / len(half) for half in (references[0::2], references[1::2])]
    return ((picture - halves[0]) * (picture - halves[1]) / (mean * mean + 0.01)).mean(axis=2)


def summary(error):
    ordered = np.sort(error.ravel())
    worst = max(1, round(len(ordered) * 0.001))
    high, wide = (length // 16 for length in error.shape)
    tiles = error[:high * 16, :wide * 16].reshape(high, 16, wide, 16).mean(axis=(1, 3))
    return np.array([ordered.mean(), ordered[:-worst].mean(), tiles.max()])


def main():
    program, scenes, work, *names = sys.argv[1:]
    with open(os.path.join(scenes, "cameras.json"), encoding="utf-8") as file:
        cameras = json.load(file)
    os.makedirs(work, exist_ok=True)
    ratios = []
    for name in names or ALL:
        what = arguments(scenes, name, cameras)
        at = {kind: os.path.join(work, f"{name}-{kind}.exr") for kind in ("noisy", "built-in", "oidn")}
        make(at["noisy"], [program, "render", "-q", *what, "-o", "OUT", "--spp", "16", "--seed", "0"])
        for how in ("built-in", "oidn"):
            make(at[how], [program, "convert", "-q", at["noisy"], "OUT", f"--denoise={how}"])
        references = []
        for i in range(REFERENCES):
            path = os.path.join(work, f"{name}-reference-{i}.exr")
            make(path, [program, "render", "-q", *what, "-o", "OUT", "--spp", str(SAMPLES), "--seed", str(101 + i)])
            references.append(colors(path))
        found = {kind: summary(errors(path, references)) for kind, path in at.items()}
        ratios.append(found["built-in"] / found["oidn"])
        parts = [f"{kind} {a:.5f} ({b:.5f}, {c:.4f})" for kind, (a, b, c) in found.items()]
        print(name.ljust(15), *parts, "ratio %.2f (%.2f, %.2f)" % tuple(ratios[-1]), sep="  ", flush=True)
    print("geometric mean  ratio %.2f (%.2f, %.2f)" % tuple(np.exp(np.log(ratios).mean(axis=0))))


if __name__ == "__main__":
    main()
