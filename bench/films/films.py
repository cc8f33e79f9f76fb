# SPDX-License-Identifier: GPL-3.0-or-later
"""Films that judge the filter over frames: `films.py GNURT FOLDER [--reference N] [--only NAME]`.

Writes five small animated scenes (moving camera, moving lamp, turning object, moving camera before a mirror and a pane, moving ball of
glass), renders each with 8 samples per pixel, filters frames together and one by one, and compares with many samples.
Needs numpy and OpenEXR, and OIDN_LIB for Open Image Denoise (PyPI's pyoidn carries the library), which gets albedo and normal of first hits.

Figures, smaller is better: `relMSE` of the frames; `change`: relative MSE of differences between consecutive frames;
`flicker`: mean absolute difference between frames where the reference stands still; FLIP, mean of three frames. All as ratios to OIDN's
single frames, if it is there, else to the built-in filter's. Radiance is clipped at 2. There are two references, under two seeds: the mean product of the differences
from both is the squared error without their noise. A reference has one seed for all frames, so that what stands still is exactly still in it.
"""

import json
import os
import pathlib
import struct
import subprocess
import sys

import numpy as np
import OpenEXR

FRAMES, SIZE, FPS = 12, (160, 120), 24


class Gltf:
    """A scene made of boxes, quads and one clip."""

    def __init__(self):
        self.data = b""
        self.json = {"asset": {"version": "2.0"}, "buffers": [], "bufferViews": [], "accessors": [], "meshes": [],
                     "materials": [], "nodes": [], "cameras": [], "scenes": [{"nodes": []}], "scene": 0,
                     "animations": [{"name": "film", "samplers": [], "channels": []}]}

    def put(self, values, kind, width):
        raw = struct.pack("<%d%s" % (len(values), "I" if kind == 5125 else "f"), *values)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw)})
        self.data += raw
        accessor = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": kind,
                    "count": len(values) // width, "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[width]}
        if width == 3:
            rows = [values[i::3] for i in range(3)]
            accessor.update(min=[min(r) for r in rows], max=[max(r) for r in rows])
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def material(self, color, roughness=1.0, metallic=0.0, emission=None):
        material = {"pbrMetallicRoughness": {"baseColorFactor": color + [1.0], "roughnessFactor": roughness,
                                             "metallicFactor": metallic}}
        if emission:
            material["emissiveFactor"] = [1.0, 1.0, 1.0]
            material["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": emission}}
            self.json["extensionsUsed"] = ["KHR_materials_emissive_strength"]
        self.json["materials"].append(material)
        return len(self.json["materials"]) - 1

    def mesh(self, parts):
        primitives = []
        for points, triangles, material in parts:
            primitives.append({"attributes": {"POSITION": self.put(sum(points, []), 5126, 3)},
                               "indices": self.put(sum(triangles, []), 5125, 1), "material": material})
        self.json["meshes"].append({"primitives": primitives})
        return len(self.json["meshes"]) - 1

    def node(self, **values):
        self.json["nodes"].append(values)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)
        return len(self.json["nodes"]) - 1

    def move(self, node, path, times, values):
        animation = self.json["animations"][0]
        width = len(values[0])
        sampler = {"input": self.put(times, 5126, 1), "output": self.put(sum(values, []), 5126, width)}
        animation["samplers"].append(sampler)
        channel = {"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}}
        animation["channels"].append(channel)

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        size = 12 + 8 + len(text) + 8 + len(data)
        path.write_bytes(struct.pack("<III", 0x46546C67, 2, size) + struct.pack("<II", len(text), 0x4E4F534A) + text
                         + struct.pack("<II", len(data), 0x004E4942) + data)


def box(low, high):
    x, y, z = zip(low, high)
    points = [[x[i & 1], y[i >> 1 & 1], z[i >> 2]] for i in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [[a, b, c] for a, b, c, d in quads] + [[a, c, d] for a, b, c, d in quads]
    corners, faces = [], []
    for triangle in triangles:
        faces.append([len(corners), len(corners) + 1, len(corners) + 2])
        corners += [points[i] for i in triangle]
    return corners, faces


def quad(a, b, c, d):
    return [a, b, c, d], [[0, 1, 2], [0, 2, 3]]


def ball(radius, rows=24):
    """The normals are those of the triangles: many of them."""
    points, faces = [], []
    for i in range(rows + 1):
        for j in range(2 * rows):
            up, around = np.pi * i / rows, np.pi * j / rows
            points.append([float(radius * x) for x in (np.sin(up) * np.cos(around), np.cos(up), np.sin(up) * np.sin(around))])
    for i in range(rows):
        for j in range(2 * rows):
            a, b = i * 2 * rows + j, i * 2 * rows + (j + 1) % (2 * rows)
            faces += [[a, b, a + 2 * rows], [b, b + 2 * rows, a + 2 * rows]]
    return points, faces


def room(scene, lamp=True):
    grey = scene.material([0.7, 0.7, 0.7])
    red = scene.material([0.7, 0.15, 0.1])
    gloss = scene.material([0.5, 0.5, 0.55], 0.25)
    dark = scene.material([0.15, 0.18, 0.3])
    tiles = [[], []]
    for i in range(8):
        for j in range(8):
            x, z = i - 4.0, j - 4.0
            tiles[(i + j) % 2].append(quad([x, 0, z], [x, 0, z + 1], [x + 1, 0, z + 1], [x + 1, 0, z]))
    parts = []
    for quads, material in zip(tiles, (gloss, dark)):
        points, faces = [], []
        for corners, triangles in quads:
            faces += [[i + len(points) for i in t] for t in triangles]
            points += corners
        parts.append((points, faces, material))
    parts.append((*quad([-4, 0, -4], [4, 0, -4], [4, 4, -4], [-4, 4, -4]), grey))
    parts.append((*quad([-4, 0, 4], [-4, 0, -4], [-4, 4, -4], [-4, 4, 4]), red))
    parts.append((*quad([4, 0, -4], [4, 0, 4], [4, 4, 4], [4, 4, -4]), grey))
    parts.append((*quad([-4, 4, 4], [-4, 4, -4], [4, 4, -4], [4, 4, 4]), grey))
    scene.node(mesh=scene.mesh(parts))
    scene.node(mesh=scene.mesh([(*box([-2.2, 0, -2], [-1.2, 1.6, -1]), grey)]))
    scene.node(mesh=scene.mesh([(*box([1.0, 0, -2.5], [2.0, 0.9, -1.2]), red)]))
    if lamp:
        light = scene.material([0.0, 0.0, 0.0], emission=12.0)
        scene.node(mesh=scene.mesh([(*quad([-1, 3.9, -1], [1, 3.9, -1], [1, 3.9, 1], [-1, 3.9, 1]), light)]))


def camera(scene):
    scene.json["cameras"].append({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}})
    return scene.node(camera=0, translation=[0, 1.6, 5.5])


TIMES = [i / FPS for i in range(FRAMES)]


def turned(angle):
    return [0.0, float(np.sin(angle / 2)), 0.0, float(np.cos(angle / 2))]


def films(folder):
    scene = Gltf()
    room(scene)
    scene.move(camera(scene), "translation", TIMES, [[-0.6 + 0.1 * i, 1.6, 5.5 - 0.04 * i] for i in range(FRAMES)])
    scene.write(folder / "camera.glb")
    scene = Gltf()
    room(scene, lamp=False)
    camera(scene)
    light = scene.material([0.0, 0.0, 0.0], emission=60.0)
    lamp = scene.node(mesh=scene.mesh([(*quad([-0.4, 0, -0.4], [0.4, 0, -0.4], [0.4, 0, 0.4], [-0.4, 0, 0.4]), light)]))
    # It stands still for a third of the film.
    scene.move(lamp, "translation", TIMES, [[-1.5 + 0.3 * max(0, i - 3), 3.8, 0.5] for i in range(FRAMES)])
    scene.write(folder / "lamp.glb")
    scene = Gltf()
    room(scene)
    camera(scene)
    parts = []
    for i in range(4):
        material = scene.material([[0.8, 0.5, 0.1], [0.1, 0.5, 0.7]][i % 2])
        parts.append((*box([-0.6, 0.3 * i, -0.6 + 0.1 * i], [0.6, 0.3 * i + 0.3, 0.6 - 0.1 * i]), material))
    thing = scene.node(mesh=scene.mesh(parts), translation=[0, 0.05, 0.5])
    scene.move(thing, "rotation", TIMES, [turned(0.09 * i) for i in range(FRAMES)])
    scene.write(folder / "turn.glb")
    scene = Gltf()
    room(scene)
    mirror = scene.material([0.9, 0.9, 0.9], 0.0, 1.0)
    scene.node(mesh=scene.mesh([(*quad([-3, 0.4, -3.9], [3, 0.4, -3.9], [3, 3.2, -3.9], [-3, 3.2, -3.9]), mirror)]))
    pane = scene.material([1.0, 1.0, 1.0], 0.0)
    scene.json["materials"][pane]["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    scene.json["extensionsUsed"].append("KHR_materials_transmission")
    scene.node(mesh=scene.mesh([(*quad([0.3, 0.2, 0.6], [1.9, 0.2, 0.2], [1.9, 1.8, 0.2], [0.3, 1.8, 0.6]), pane)]))
    scene.move(camera(scene), "translation", TIMES, [[-0.6 + 0.1 * i, 1.6, 5.5 - 0.04 * i] for i in range(FRAMES)])
    scene.write(folder / "mirror.glb")
    scene = Gltf()
    room(scene)
    camera(scene)
    glass = scene.material([1.0, 1.0, 1.0], 0.0)
    scene.json["materials"][glass]["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0},
                                                    "KHR_materials_volume": {"thicknessFactor": 1.0}}
    scene.json["extensionsUsed"] += ["KHR_materials_transmission", "KHR_materials_volume"]
    ball_node = scene.node(mesh=scene.mesh([(*ball(0.7), glass)]))
    scene.move(ball_node, "translation", TIMES, [[-0.9 + 0.12 * i, 0.75, 1.2] for i in range(FRAMES)])
    scene.write(folder / "glass.glb")
    return ["camera", "lamp", "turn", "mirror", "glass"]


def read(path):
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        whole = lambda names: np.stack([channels[n].pixels.astype(np.float32) for n in names], -1)
        if "RGBA" in channels:
            rgb = channels["RGBA"].pixels[..., :3].astype(np.float32)
        else:
            rgb = whole(["R", "G", "B"])
        back = channels.get("background")
        if back is not None:
            rgb = rgb + back.pixels[..., :3].astype(np.float32)
        elif "background.R" in channels:
            rgb = rgb + whole(["background.R", "background.G", "background.B"])
        return rgb


def render(gnurt, folder, scene, name, spp, more, seed=None):
    out = folder / f"{scene}.{name}.##.exr"
    command = [gnurt, "render", str(folder / f"{scene}.glb"), "-r", "%dx%d" % SIZE, "--spp", str(spp), "-q",
               "--integrator", "path", "--fps", str(FPS)] + more
    if seed is None:
        subprocess.run(command + ["--frames", f"0..{FRAMES - 1}", "-o", str(out)], check=True)
    else:
        for i in range(FRAMES):
            target = str(out).replace("##", f"{i:02}")
            if not os.path.exists(target):
                subprocess.run(command + ["--at", str(i / FPS), "--seed", str(seed), "-o", target], check=True)
    return np.minimum(np.stack([read(str(out).replace("##", f"{i:02}")) for i in range(FRAMES)]), 2.0)


def filtered(gnurt, folder, scene, name, source, how):
    out = folder / f"{scene}.{name}.##.exr"
    command = [gnurt, "denoise", "-q", str(folder / f"{scene}.{source}.##.exr"), "--frames", f"0..{FRAMES - 1}", "-o", str(out)]
    subprocess.run(command + how, check=True)
    return frames(folder, scene, name)


def frames(folder, scene, name):
    return np.minimum(np.stack([read(folder / f"{scene}.{name}.{i:02}.exr") for i in range(FRAMES)]), 2.0)


def first_hits(folder, scene):
    """The frames without the layers of what is seen in mirrors and glass."""
    for i in range(FRAMES):
        with OpenEXR.File(str(folder / f"{scene}.noisy.{i:02}.exr"), separate_channels=True) as file:
            kept = {name: channel.pixels for name, channel in file.channels().items() if not name.startswith("seen_")}
        with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, kept) as file:
            file.write(str(folder / f"{scene}.first.{i:02}.exr"))


def write(path, rgb):
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage},
                      {name: np.ascontiguousarray(rgb[..., k]) for k, name in enumerate("RGB")}) as file:
        file.write(str(path))


def flip(gnurt, folder, film, truth):
    """Mean over three frames; the reference's mean is at a fifth of what a screen shows."""
    scale, found = 0.2 / truth.mean(), []
    paths = [folder / f"flip-{i}.exr" for i in range(2)]
    for i in (1, FRAMES // 2, FRAMES - 2):
        for path, rgb in zip(paths, (film[i], truth[i])):
            write(path, rgb * scale)
        told = subprocess.run([gnurt, "diff", "--flip", *map(str, paths)], capture_output=True, text=True).stdout
        found.append(float(next(line for line in told.splitlines() if line.startswith("FLIP")).split()[-1]))
    return np.mean(found)


def errors(film, truths):
    level = (truths[0] + truths[1]) / 2
    relative = lambda film, truths, level: np.mean((film - truths[0]) * (film - truths[1]) / (level**2 + 1e-2))
    steps = lambda film: film[1:] - film[:-1]
    step = steps(film)
    still = np.max([np.abs(steps(truth)).max(-1) for truth in truths], 0) < 0.002 * level.mean()
    return [relative(film, truths, level), relative(step, [steps(truth) for truth in truths], np.maximum(level[1:], level[:-1])),
            np.abs(step).mean(-1)[still].mean() if still.any() else np.nan], still.mean()


def main():
    gnurt, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    spp = int(sys.argv[sys.argv.index("--reference") + 1]) if "--reference" in sys.argv else 1024
    folder.mkdir(parents=True, exist_ok=True)
    alone = ["--denoise-window", "0"]
    ways = {"single": ("noisy", ["--denoise=built-in", *alone]), "film": ("noisy", ["--denoise=built-in"])}
    if "OIDN_LIB" in os.environ:
        ways = {"oidn": ("first", ["--denoise=oidn", *alone]), **ways}
        ways["oidn-seen"] = ("noisy", ["--denoise=oidn", *alone])
        ways["film-oidn"] = ("noisy", ["--denoise=oidn"])
    names = films(folder)
    if "--only" in sys.argv:
        names = sys.argv[sys.argv.index("--only") + 1].split(",")
    everything = {}
    for scene in names:
        truth = [render(gnurt, folder, scene, f"truth{seed}", spp, ["--denoise=none"], seed) for seed in (777, 778)]
        render(gnurt, folder, scene, "noisy", 8, ["--layers", "denoise"])
        first_hits(folder, scene)
        base = None
        for name, (source, how) in ways.items():
            film = filtered(gnurt, folder, scene, name, source, how)
            figures, still = errors(film, truth)
            figures.append(flip(gnurt, folder, film, (truth[0] + truth[1]) / 2))
            base = base or figures
            ratios = [a / b for a, b in zip(figures, base)]
            everything.setdefault(name, []).append(ratios)
            told = " ".join(f"{a:.5f} ({b:.2f})" for a, b in zip(figures, ratios))
            print(f"{scene:7} {name:10} relMSE, change, flicker, FLIP: {told}; still {still:.0%}", flush=True)
    for name, ratios in everything.items():
        means = np.exp(np.nanmean(np.log(np.maximum(ratios, 1e-9)), axis=0))
        print(f"mean    {name:10} relMSE, change, flicker, FLIP:", " ".join(f"{x:.2f}" for x in means))


main()
