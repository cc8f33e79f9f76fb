#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of the denoisers on sixteen scenes: denoise.py GNURT SCENES WORK [--small] [--references N] [SCENE ...]

Needs numpy and OpenEXR (PyPI), and OIDN_LIB for Open Image Denoise (PyPI's pyoidn carries the library). Renders what WORK lacks:
16 samples at 192x144, or with --small 8 samples at 64x64 (seed 0, `--layers denoise`), clean ones by both denoisers, and references
under other seeds. OIDN gets albedo and normal of first hits (`oidn`), and those seen through mirrors and glass (`oidn-seen`).
A squared error is the product of the differences to two halves of the references: their noise is in neither mean.
Prints relMSE, the same without the worst thousandth of the pixels, the worst 16 x 16 tile, FLIP at the exposure of the reference,
and the change of the mean; then ratios to `oidn`.
"""
import argparse, json, os, subprocess
import numpy as np
import OpenEXR

ALL = ("office conference white-room breakfast-room modern-hall veach-bidir veach-ajar sponza soda classroom cornell-box "
       "graz cornell materials spheres slit").split()
BUILT_IN = {"cornell", "materials", "spheres", "slit"}
SQUARE = {"veach-bidir", "cornell-box"}
SKY = {"sponza": ["builtin:day", "155"], "breakfast-room": ["builtin:evening", "175"]}


def arguments(scenes, name, cameras, small):
    size = "64x64" if small else "144x144" if name in SQUARE else "192x144"
    common = ["-r", size, "--integrator", "path"] + (["--max-depth", "5"] if small else [])
    if name in BUILT_IN:
        return ["builtin:" + name, *common]
    camera = cameras[name][0]
    place = [f"--{key}=" + ",".join(map(str, camera[key])) for key in ("eye", "target", "up")]
    sky = SKY.get(name)
    around = ["--environment", sky[0], "--environment-turn", sky[1]] if sky else []
    return [os.path.join(scenes, name, name + ".obj"), *common, f"--fov={camera['vfov']}", *place, *around]


def make(path, command):
    if not os.path.exists(path):
        unfinished = path.replace(".exr", ".unfinished.exr")
        subprocess.run([part if part != "OUT" else unfinished for part in command], check=True)
        os.rename(unfinished, path)


def colors(path):
    with OpenEXR.File(path) as file:
        channels = file.channels()
        rgb = channels["RGBA" if "RGBA" in channels else "RGB"].pixels[..., :3].astype(np.float64)
        if "background.A" in channels or "background" in channels or "background.R" in channels:
            behind = channels.get("background")
            if behind is not None:
                rgb = rgb + behind.pixels[..., :3]
            else:
                rgb = rgb + np.stack([channels["background." + c].pixels for c in "RGB"], -1)
        return rgb


def write(path, rgb):
    channels = {"RGB": np.ascontiguousarray(rgb, dtype=np.float32)}
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels) as file:
        file.write(path)


def errors(picture, references):
    """Per pixel."""
    mean = sum(references) / len(references)
    halves = [sum(half) / len(half) for half in (references[0::2], references[1::2])]
    return ((picture - halves[0]) * (picture - halves[1]) / (mean * mean + 0.01)).mean(axis=2)


def summary(error):
    ordered = np.sort(error.ravel())
    worst = max(1, round(len(ordered) * 0.001))
    high, wide = (length // 16 for length in error.shape)
    tiles = error[:high * 16, :wide * 16].reshape(high, 16, wide, 16).mean(axis=(1, 3))
    return [ordered.mean(), ordered[:-worst].mean(), tiles.max()]


def flip(program, work, picture, reference):
    """With the reference's mean at a fifth of what a screen shows; as the screen's curve has no end, cut at 1."""
    scale = 0.2 / max(reference.mean(), 1e-9)
    paths = [os.path.join(work, f"flip-{i}.exr") for i in range(2)]
    for path, rgb in zip(paths, (picture, reference)):
        write(path, rgb * scale)
    found = subprocess.run([program, "diff", "--flip", *paths], capture_output=True, text=True)
    return float(next(line for line in found.stdout.splitlines() if line.startswith("FLIP")).split()[-1])


def first_hits(path):
    """The file without the layers of what is seen in mirrors and glass; the file itself if it has none."""
    target = path.replace("-noisy.exr", "-first-hits.exr")
    if os.path.exists(target):
        return target
    with OpenEXR.File(path, separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    kept = {name: pixels for name, pixels in channels.items() if not name.startswith("seen_")}
    if len(kept) == len(channels):
        return path
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, kept) as file:
        file.write(target)
    return target


def main():
    options = argparse.ArgumentParser()
    for name in ("program", "scenes", "work"):
        options.add_argument(name)
    options.add_argument("--small", action="store_true")
    options.add_argument("--references", type=int, default=2)
    options.add_argument("--spp", type=int, default=256, help="samples of one reference")
    options.add_argument("--only-references", action="store_true")
    options.add_argument("names", nargs="*")
    options = options.parse_intermixed_args()
    program, work = options.program, options.work
    with open(os.path.join(options.scenes, "cameras.json"), encoding="utf-8") as file:
        cameras = json.load(file)
    os.makedirs(work, exist_ok=True)
    all_of = {}
    for name in options.names or ALL:
        what = arguments(options.scenes, name, cameras, options.small)
        short = name + ("-small" if options.small else "")
        at = {kind: os.path.join(work, f"{short}-{kind}.exr") for kind in ("noisy", "built-in", "built-in-first", "oidn", "oidn-seen")}
        references = []
        for i in range(options.references):
            path = os.path.join(work, f"{short}-reference-{i}.exr")
            make(path, [program, "render", "-q", *what, "-o", "OUT", "--spp", str(options.spp), "--seed", str(101 + i),
                        "--layers", "background"])
            references.append(colors(path))
        if options.only_references:
            continue
        samples = "8" if options.small else "16"
        make(at["noisy"], [program, "render", "-q", *what, "-o", "OUT", "--spp", samples, "--seed", "0", "--layers", "denoise"])
        plain = first_hits(at["noisy"])
        ways = [("built-in", at["noisy"], "built-in")]
        if plain != at["noisy"]:
            ways.append(("built-in-first", plain, "built-in"))
        if "OIDN_LIB" in os.environ:
            ways.append(("oidn", plain, "oidn"))
            if plain != at["noisy"]:
                ways.append(("oidn-seen", at["noisy"], "oidn"))
        for kind, source, how in ways:
            make(at[kind], [program, "denoise", "-q", source, "-o", "OUT", f"--denoise={how}"])
        reference = sum(references) / len(references)
        found = {}
        for kind, path in at.items():
            if os.path.exists(path):
                picture = colors(path)
                found[kind] = [*summary(errors(picture, references)), flip(program, work, picture, reference),
                               100 * (picture.mean() / reference.mean() - 1)]
        parts = [f"{kind} {a:.5f} ({b:.5f}, {c:.4f}) F {d:.4f} {e:+.1f}%" for kind, (a, b, c, d, e) in found.items()]
        if "oidn" in found:
            for kind in found:
                ratios = np.array(found[kind][:4]) / np.maximum(found["oidn"][:4], 1e-12)
                all_of.setdefault(kind, []).append(ratios)
            parts.append("ratio %.2f (%.2f, %.2f) F %.2f" % tuple(all_of["built-in"][-1]))
        print(name.ljust(15), *parts, sep="  ", flush=True)
    for kind, ratios in all_of.items():
        print("geometric mean %-10s ratio %.2f (%.2f, %.2f) F %.2f" % (kind, *np.exp(np.log(np.maximum(ratios, 1e-9)).mean(axis=0))))


if __name__ == "__main__":
    main()
