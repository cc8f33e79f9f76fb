# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares another renderer's path tracer with gnurt's at equal error, on the interiors and against their references.

Both errors fall as one over the samples (a little faster with low-discrepancy numbers), so error times seconds is what a
renderer is worth, whatever the number of samples. Seconds are those of processors, over all threads, so that a busy machine
may be used, and those of rendering alone. 
"""
import argparse
import os
import resource
import subprocess
import tempfile

import numpy as np

import interiors


def parser():
    """The arguments that all comparisons have."""
    result = argparse.ArgumentParser()
    result.add_argument("scenes")
    result.add_argument("references")
    result.add_argument("gnurt")
    result.add_argument("only", nargs="*")
    result.add_argument("--spp", type=int, default=64)
    result.add_argument("--threads", type=int, default=2)
    return result


def without_setup(run, spp):
    """CPU seconds of `spp` + 1 samples without what is done once: `run(n)` renders n samples and says its CPU seconds."""
    # What one sample costs holds all that is done once.
    once, all_of_it = run(1), run(spp + 1)
    return (all_of_it - once) * (spp + 1) / spp


def read_pfm(path):
    """A colour picture in PFM as float64 (rows, columns, 3), first row on top."""
    with open(path, "rb") as file:
        kind, size, scale = file.readline().strip(), file.readline().split(), float(file.readline())
        if kind != b"PF":
            raise ValueError(f"{path}: no PFM picture in colour (its first line is {kind!r})")
        values = np.frombuffer(file.read(), "<f4" if scale < 0 else ">f4")
    return values.reshape(int(size[1]), int(size[0]), 3)[::-1].astype(np.float64)


def run_gnurt(program, path, scene, spp, threads, folder):
    """The picture and the CPU seconds of gnurt's path tracer."""
    output = os.path.join(folder, "own.pfm")

    def run(spp):
        words = [program, "render", path, *interiors.gnurt_arguments(scene), "--force-diffuse", "--integrator=path"]
        words += ["--max-depth=9", f"--spp={spp}", f"-t={threads}", "-q", "-o", output]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(words, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    seconds = without_setup(run, spp)
    return read_pfm(output), seconds


def compare(arguments, name, read_exr, run_other):
    """Prints the table. `read_exr(path)`: a picture (rows, columns, 3); `run_other(parts, camera, spp, threads, folder)`:
    the other renderer's picture and CPU seconds, as `run_gnurt`."""
    print("| scene | renderer | spp | CPU seconds | relMSE | trimmed | mean error % | relMSE x s | trimmed x s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for scene in arguments.only or interiors.CAMERAS:
        reference = read_exr(os.path.join(arguments.references, f"{scene}-path9.exr"))
        variance = read_exr(os.path.join(arguments.references, f"{scene}-path9-var.exr"))
        with tempfile.TemporaryDirectory() as folder:
            own_path = os.path.join(arguments.scenes, scene, scene + ".obj")
            own = run_gnurt(arguments.gnurt, own_path, scene, arguments.spp, arguments.threads, folder)
            parts = interiors.read(arguments.scenes, scene)
            other = run_other(parts, interiors.CAMERAS[scene], arguments.spp, arguments.threads, folder)
        worth = []
        for renderer, (picture, seconds) in [("gnurt", own), (name, other)]:
            errors = interiors.rel_mse(picture, reference, variance)
            off = (picture.mean() / reference.mean() - 1) * 100
            worth.append([error * seconds for error in errors])
            row = [scene, renderer, arguments.spp, f"{seconds:.2f}", *(f"{e:.5f}" for e in errors), f"{off:+.2f}"]
            print("| " + " | ".join(map(str, row + [f"{w:.5f}" for w in worth[-1]])) + " |", flush=True)
        ratios = [theirs / own for own, theirs in zip(*worth)]
        print(f"| {scene} | **times faster at equal error** | | | | | | {ratios[0]:.2f} | {ratios[1]:.2f} |", flush=True)
