#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics: variance times processor seconds of `gnurt render` with and without searches, and with virtual lights.

    caustics.py PROGRAM FOLDER [--size 80x60] [--seeds 6] [--lamps area,point,sun] [--choices off=256,auto=16,bir=16]

Writes three scenes to FOLDER: a ball of glass and a ring of mirror on a floor, with a small, a point and a distant lamp. A choice is one of
`--caustics`, or an integrator, with its samples. Needs numpy.
"""

import argparse
import math
import os

import numpy as np
from guiding import read_pfm, run


def ring(inner, outer, height, parts=96):
    points, normals, indices = [], [], []
    for a, b, normal in [
        ((outer, 0), (outer, height), (1, 0)),
        ((outer, height), (inner, height), (0, 1)),
        ((inner, height), (inner, 0), (-1, 0)),
    ]:
        first = len(points)
        for i in range(parts + 1):
            angle = 2 * math.pi * i / parts
            x, y = math.cos(angle), math.sin(angle)
            for r, z in (a, b):
                points.append((r * x, r * y, z))
                normals.append((normal[0] * x, normal[0] * y, normal[1]))
        for k in range(first, first + 2 * parts, 2):
            indices += [k, k + 2, k + 1, k + 1, k + 2, k + 3]
    flat = lambda vectors: " ".join(f"{x:.6g}" for v in vectors for x in v)
    return f'Shape "trianglemesh" "point3 P" [{flat(points)}] "normal N" [{flat(normals)}] "integer indices" [{" ".join(map(str, indices))}]'


LAMPS = {
    "area": 'AttributeBegin\nAreaLightSource "diffuse" "rgb L" [400 380 340]\nTranslate -2 1.5 4\nShape "sphere" "float radius" [0.06]\nAttributeEnd',
    "point": 'LightSource "point" "rgb I" [4.52 4.3 3.845] "point3 from" [-2 1.5 4]',
    "sun": 'LightSource "distant" "rgb L" [0.25 0.24 0.22] "point3 from" [-2 1.5 4] "point3 to" [0 0 0]',
}


def scene(lamp):
    return f"""LookAt 0 -6 4.2  0 0 0.2  0 0 1
Camera "perspective" "float fov" [36]
WorldBegin
MakeNamedMaterial "ring" "string type" "conductor"
{LAMPS[lamp]}
LightSource "infinite" "rgb L" [0.01 0.012 0.015]
Material "diffuse" "rgb reflectance" [0.6 0.58 0.55]
Shape "trianglemesh" "point3 P" [-8 -8 0 8 -8 0 8 8 0 -8 8 0] "integer indices" [0 1 2 0 2 3]
AttributeBegin
Material "dielectric" "float eta" [1.5] "float roughness" [0]
Translate -0.9 0 0.75
Shape "sphere" "float radius" [0.75]
AttributeEnd
AttributeBegin
NamedMaterial "ring"
Translate 1.1 -0.1 0.01
{ring(0.78, 0.85, 0.45)}
AttributeEnd
"""


MIRROR = "surface mirror(color tint = color(0.95, 0.8, 0.5)) { Ci = tint * reflection(N); }\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--size", default="80x60")
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--lamps", default="area,point,sun")
    parser.add_argument("--choices", default="off=256,auto=16,bir=16")
    options = parser.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    mirror, output = (os.path.join(options.folder, name) for name in ("mirror.osl", "picture.pfm"))
    with open(mirror, "w", encoding="utf-8") as file:
        file.write(MIRROR)
    for lamp in options.lamps.split(","):
        path = os.path.join(options.folder, f"caustics-{lamp}.pbrt")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene(lamp))
        taken = {}
        for choice, spp in (choice.split("=") for choice in options.choices.split(",")):
            how = ["--integrator", "path", "--caustics", choice] if choice in ("off", "on", "auto") else ["--integrator", choice]
            rest = ["-r", options.size, "--max-depth", "9", "-t", "1", "--denoise=none", "-q", "--shader", f"ring={mirror}", "-o", output]
            command = [options.program, "render", path, *rest, *how]
            (start, _), pictures, seconds = run([*command, "--spp", "1"]), [], []
            for seed in range(1, options.seeds + 1):
                seconds.append(run([*command, "--spp", spp, "--seed", str(seed)])[0] - start)
                pictures.append(read_pfm(output))
            taken[choice] = (np.array(pictures), np.median(seconds) / int(spp), int(spp))
        mean = np.mean([pictures.mean(0) for pictures, _, _ in taken.values()], axis=0).mean(-1)
        height, width = mean.shape
        padded = np.pad(mean, 2, mode="edge")
        smooth = sum(padded[i : i + height, j : j + width] for i in range(5) for j in range(5)) / 25
        weight, first = 1 / (smooth**2 + 0.01 * mean.mean() ** 2), None
        for choice, (pictures, seconds, spp) in taken.items():
            errors = pictures.var(0, ddof=1).mean(-1) * weight * spp
            most = np.sort(errors.ravel())[: -max(1, errors.size // 1000)].mean()
            first = first or (errors.mean(), most, seconds)
            variance, time = errors.mean() / first[0], seconds / first[2]
            print(
                f"{lamp:6} {choice:5} mean {pictures.mean():.5f} relMSE of a sample {errors.mean():.3f} variance {variance:.4f} time {time:.2f} "
                f"product {variance * time:.4f} without the worst thousandth {most / first[1] * time:.4f}",
                flush=True,
            )


main()
