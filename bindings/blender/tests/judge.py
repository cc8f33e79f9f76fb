# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders scenes with GNU RT and Cycles at equal light, and compares the means of pictures, channels and objects.

The worst block of pixels of each channel is printed and not judged: means of whole pictures hide faults that lie in a part of them.

Usage: python judge.py [--samples N] [--out FOLDER] [SCENE ...]
"""

import argparse
import pathlib
import sys
import time

from common import bpy, mask, np, png, render, start
from scenes import SCENES
import node_scenes  # noqa: F401  it fills SCENES

BAR = 0.03
# Edge of a block in pixels.
BLOCK = 16


def worst_block(ours, theirs):
    """The largest difference of a block of one channel beyond its noise, as a share of the block's brightness, and its top and left.

    Noise is four standard errors of the mean, from differences between neighbours in the difference of both pictures.
    """
    difference, found = ours - theirs, []
    floor = 0.1 * max(theirs.mean(), 1e-3)
    for top in range(0, difference.shape[0] - BLOCK + 1, BLOCK):
        for left in range(0, difference.shape[1] - BLOCK + 1, BLOCK):
            of = slice(top, top + BLOCK), slice(left, left + BLOCK)
            steps = np.diff(difference[of], axis=0)
            noise = np.sqrt((steps**2).mean() / 2) / BLOCK
            beyond = max(abs(difference[of].mean()) - 4 * noise, 0)
            found.append((beyond / max(theirs[of].mean(), floor), top, left))
    return max(found)


def judge(name, samples, out):
    start()
    SCENES[name]()
    began = time.monotonic()
    ours = render("GNURT", samples)
    middle = time.monotonic()
    theirs = render("CYCLES", samples)
    seconds = middle - began, time.monotonic() - middle
    parts = np.zeros(ours.shape[:2], int) if bpy.context.scene.get("means only") else mask()
    worst, block, lines = 0.0, 0.0, []

    def compare(what, a, b):
        nonlocal worst
        error = abs(a.mean() - b.mean()) / max(b.mean(), 1e-3)
        worst = max(worst, error)
        lines.append(f"{what} {a.mean():.4f}/{b.mean():.4f}")

    compare("all", ours[..., :3], theirs[..., :3])
    compare("opacity", ours[..., 3], theirs[..., 3])
    for index in np.unique(parts):
        if index and (parts == index).sum() >= 60:
            compare(f"#{index}", ours[parts == index][:, :3], theirs[parts == index][:, :3])
    for channel, colour in enumerate("RGBA"):
        a, b = ours[..., channel], theirs[..., channel]
        if channel < 3:
            compare(colour, a, b)
        share, top, left = worst_block(a, b)
        lines.append(f"{colour} {100 * share:.1f} % at {left},{top}")
        block = max(block, share)
    if out:
        png(out / f"{name}.png", ours, theirs)
    return worst, block, lines, seconds


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*")
    given = parser.parse_args()
    if given.out:
        given.out.mkdir(parents=True, exist_ok=True)
    failed = 0
    for name in given.scenes or SCENES:
        worst, block, lines, seconds = judge(name, given.samples, given.out)
        failed += worst > BAR
        for line in bpy.context.scene.gnurt.warnings.splitlines():
            print("     warned:", line)
        print(f"{'ok  ' if worst <= BAR else 'FAIL'} {name:18} {100 * worst:5.2f} % {100 * block:5.1f} %  {seconds[0]:.1f} s / {seconds[1]:.1f} s  {' '.join(lines)}", flush=True)
    print(f"{failed} of {len(given.scenes or SCENES)} scenes beyond {100 * BAR:.0f} %")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
