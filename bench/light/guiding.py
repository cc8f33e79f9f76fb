#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Guided paths beside unguided ones: variance times processor seconds of `gnurt render`.

    guiding.py PROGRAM FOLDER [SCENE ...] [--spp 64] [--size 160x120] [--seeds 3] [--choices off,on,auto] [--before PROGRAM]

FOLDER holds the unpacked scenes and their cameras.json (the first view is taken); a SCENE with a path is a file that is seen from its own
camera. `--before` is an older program, which does not know `--guide`: choice `before`. relMSE is the variance between seeds over the squared mean of all pictures, smoothed over 5x5 pixels, plus a hundredth of
the squared mean. Seconds are user and system time of one thread, without those of a picture of one sample. Needs numpy.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile

import numpy as np


def read_pfm(path):
    with open(path, "rb") as file:
        kind, size = file.readline().strip(), file.readline().split()
        file.readline()
        width, height = map(int, size)
        return np.frombuffer(file.read(), "<f4").reshape(height, width, 3 if kind == b"PF" else 1).astype(float)


def run(command):
    """Processor seconds, and the messages."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stderr


def weights(pictures):
    mean = np.mean(pictures, axis=0).mean(-1)
    padded = np.pad(mean, 2, mode="edge")
    height, width = mean.shape
    smooth = sum(padded[i : i + height, j : j + width] for i in range(5) for j in range(5)) / 25
    return 1 / (smooth**2 + 0.01 * mean.mean() ** 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("scenes", nargs="*", default=["veach-ajar", "veach-bidir", "breakfast-room", "modern-hall", "white-room", "office", "conference", "classroom", "soda"])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--choices", default="off,on,auto")
    parser.add_argument("--before")
    options = parser.parse_args()
    with open(os.path.join(options.folder, "cameras.json"), encoding="utf-8") as file:
        cameras = json.load(file)
    folder = tempfile.mkdtemp()
    for scene in options.scenes:
        arguments = [scene]
        if os.sep not in scene:
            view = cameras[scene][0]
            place = [f"--{name}=" + ",".join(map(str, view[name])) for name in ("eye", "target", "up")]
            arguments = [f"{options.folder}/{scene}/{scene}.obj", *place, f"--fov={view['vfov']}"]

        def render(choice, spp, seed):
            program = [options.before] if choice == "before" else [options.program]
            guide = [] if choice == "before" else ["--guide", choice]
            output = os.path.join(folder, "picture.pfm")
            rest = ["-r", options.size, "--spp", str(spp), "--seed", str(seed), "--integrator", "path", "--max-depth", "9", "-t", "1", "-v", "-o", output]
            seconds, told = run([*program, "render", *arguments, *rest, *guide])
            return read_pfm(output), seconds, [line for line in told.splitlines() if "guide:" in line][-1:]

        choices = options.choices.split(",")
        start = min(render(choices[0] if choices[0] == "before" else "off", 1, 0)[1] for _ in range(2))
        taken = {choice: [] for choice in choices}
        for seed in range(1, options.seeds + 1):
            for choice in choices:
                taken[choice].append(render(choice, options.spp, seed))
        weight = weights([picture for of_choice in taken.values() for picture, _, _ in of_choice])
        first = None
        for choice, of_choice in taken.items():
            pictures = np.array([picture for picture, _, _ in of_choice])
            error = (pictures.var(0, ddof=1).mean(-1) * weight).mean()
            seconds = np.median([seconds for _, seconds, _ in of_choice]) - start
            first = first or (error, seconds)
            variance, time = error / first[0], seconds / first[1]
            told = " ".join(of_choice[-1][2])
            print(f"{scene:16} {choice:6} relMSE {error:.5f} {seconds:6.2f} s mean {pictures.mean():.5f} variance {variance:.3f} time {time:.3f} product {variance * time:.3f} {told}", flush=True)


if __name__ == "__main__":
    main()
