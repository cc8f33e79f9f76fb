# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders Cycles' nodes as pictures by both engines: within 2 % of the mean, structural similarity of at least 0.98.

Usage: python judge_nodes.py [--out FOLDER] [NODE ...]
"""

import argparse
import pathlib
import sys

from common import add, bpy, np, png, render, ssim, start
from nodes import CASES

MEAN, STRUCTURE = 0.02, 0.98
GRID = 4
# Pictures of 32 samples; of nodes that are random themselves, whose noise is not structure, of more.
SAMPLES = {"ambient occlusion": 192}
# Nodes that show triangles.
COARSE = {"ShaderNodeNewGeometry", "ShaderNodeWireframe"}
# Nodes whose numbers may be negative.
WIDE = {"ShaderNodeMath", "ShaderNodeVectorMath", "ShaderNodeSeparateXYZ", "ShaderNodeNormal", "ShaderNodeTexNoise", "ShaderNodeMapRange"}


def sheet(x, y, n=24):
    """A bent sheet of n x n quadrilaterals with texture coordinates and attributes."""
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="xy")
    u, v = i.ravel() / n, j.ravel() / n
    points = np.stack([u - 0.5, v - 0.5, 0.15 * np.sin(5 * u + 0.5) * np.cos(4 * v)], axis=1)
    quads = [(b * (n + 1) + a, b * (n + 1) + a + 1, (b + 1) * (n + 1) + a + 1, (b + 1) * (n + 1) + a) for b in range(n) for a in range(n)]
    mesh = bpy.data.meshes.new("sheet")
    mesh.from_pydata(points.tolist(), [], quads)
    mesh.shade_smooth()
    corners = np.array(quads).ravel()
    for name, at in (("UVMap", np.stack([u, v], 1)), ("second", np.stack([v * 2, 0.3 + u + 0.2 * v], 1))):
        layer = mesh.uv_layers.new(name=name)
        layer.uv.foreach_set("vector", at[corners].astype(np.float32).ravel())
    tint = mesh.color_attributes.new("tint", "FLOAT_COLOR", "CORNER")
    values = np.stack([u, v, 0.5 + 0 * u, 0.3 + 0.5 * u], 1)[corners]
    tint.data.foreach_set("color", values.astype(np.float32).ravel())
    mesh.attributes.new("height", "FLOAT", "POINT").data.foreach_set("value", (0.5 + 3 * points[:, 2]).astype(np.float32))
    mesh.attributes.new("faces", "FLOAT_VECTOR", "FACE").data.foreach_set("vector", np.random.default_rng(3).random(len(quads) * 3).astype(np.float32))
    found = add(f"sheet {x} {y}", mesh, (x + 0.5 - GRID / 2, y + 0.5 - GRID / 2, 0.1 * x))
    found.rotation_euler = (0.1, 0.05, 0)
    found.color = (0.3, 0.6, 0.9, 0.7)
    found.pass_index = 1
    return found


def images():
    rng = np.random.default_rng(7)
    made = {}
    for name, is_float, space in (("byte", False, "sRGB"), ("float", True, "Linear Rec.709"), ("data", False, "Non-Color")):
        image = bpy.data.images.new(name, 16, 8, alpha=True, float_buffer=is_float)
        image.colorspace_settings.name = space
        values = rng.random((8, 16, 4)).astype(np.float32)
        values[..., 3] = 1 if name != "byte" else 0.25 + 0.75 * values[..., 3]
        image.alpha_mode = "CHANNEL_PACKED"
        image.pixels.foreach_set(values.ravel())
        image.update()
        image.pack()
        made[name] = image
    return made


def source(tree, text):
    """An output that feeds an input, by the words of `nodes`."""
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    if text in {"@Object", "@Generated"}:
        return coordinates.outputs[text[1:]]
    if text == "@uv3":
        made = tree.nodes.new("ShaderNodeVectorMath")
        made.operation = "MULTIPLY_ADD"
        tree.links.new(coordinates.outputs["UV"], made.inputs[0])
        made.inputs[1].default_value, made.inputs[2].default_value = (3, 3, 1), (-1, -1, 0)
        return made.outputs[0]
    if text == "@color":
        return coordinates.outputs["UV"] if False else color(tree, coordinates)
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(coordinates.outputs["UV"], parts.inputs[0])
    if text in {"@u", "@v"}:
        return parts.outputs["XY"["uv".index(text[1])]]
    scaled = tree.nodes.new("ShaderNodeMath")
    if text == "@wave":
        scaled.operation = "SINE"
        inner = tree.nodes.new("ShaderNodeMath")
        inner.operation = "MULTIPLY"
        inner.inputs[1].default_value = 25
        tree.links.new(parts.outputs[0], inner.inputs[0])
        tree.links.new(inner.outputs[0], scaled.inputs[0])
        return scaled.outputs[0]
    scaled.operation = "MULTIPLY_ADD"
    scale, shift = {"@u2": (4, -2), "@1000": (2000, 700), "@6000": (6000, 2500), "@20000": (12000, 8000), "@380": (400, 370)}[text]
    tree.links.new(parts.outputs[0], scaled.inputs[0])
    scaled.inputs[1].default_value, scaled.inputs[2].default_value = scale, shift
    return scaled.outputs[0]


def color(tree, coordinates):
    made = tree.nodes.new("ShaderNodeVectorMath")
    made.operation = "MULTIPLY_ADD"
    tree.links.new(coordinates.outputs["UV"], made.inputs[0])
    made.inputs[1].default_value, made.inputs[2].default_value = (1, 0.9, 0), (0, 0.05, 0.35)
    return made.outputs[0]


def shader(kind, setting, pictures):
    """A material that shows one output of a node as emission."""
    made = bpy.data.materials.new("tile")
    made.use_nodes = True
    made.pass_index = 1
    tree = made.node_tree
    tree.nodes.clear()
    output, light, node = (tree.nodes.new(name) for name in ("ShaderNodeOutputMaterial", "ShaderNodeEmission", kind))
    tree.links.new(light.outputs[0], output.inputs["Surface"])
    setting = dict(setting)
    shown, setup, snap = setting.pop("out", None), setting.pop("setup", None), setting.pop("snap", False)
    for name, value in setting.items():
        if name == "image":
            node.image = pictures["byte" if value is True else value]
        elif hasattr(node, name) and not any(s.identifier == name for s in node.inputs):
            setattr(node, name, value)
    if setup:
        setup(node)
    for name, value in setting.items():
        socket = next((s for s in node.inputs if s.identifier == name), None)
        if socket is None:
            continue
        if isinstance(value, str):
            feed = source(tree, value)
            if snap:
                cut = tree.nodes.new("ShaderNodeVectorMath")
                cut.operation = "SNAP"
                cut.inputs[1].default_value = (0.125,) * 3
                tree.links.new(feed, cut.inputs[0])
                feed = cut.outputs[0]
            tree.links.new(feed, socket)
        else:
            socket.default_value = value
    found = next(s for s in node.outputs if s.identifier == shown) if shown else next(s for s in node.outputs if s.enabled)
    # Values from -1 to 2 are shown.
    if found.type == "VECTOR":
        moved = tree.nodes.new("ShaderNodeVectorMath")
        moved.operation = "MULTIPLY_ADD"
        tree.links.new(found, moved.inputs[0])
        moved.inputs[1].default_value, moved.inputs[2].default_value = (0.3,) * 3, (0.5,) * 3
        found = moved.outputs[0]
    elif found.type == "VALUE" and kind in WIDE:
        moved = tree.nodes.new("ShaderNodeMath")
        moved.operation = "MULTIPLY_ADD"
        tree.links.new(found, moved.inputs[0])
        moved.inputs[1].default_value, moved.inputs[2].default_value = 0.3, 0.5
        found = moved.outputs[0]
    # Cycles emits negative light.
    limit = tree.nodes.new("ShaderNodeVectorMath")
    limit.operation = "MAXIMUM"
    limit.inputs[1].default_value = (0, 0, 0)
    tree.links.new(found, limit.inputs[0])
    top = tree.nodes.new("ShaderNodeVectorMath")
    top.operation = "MINIMUM"
    top.inputs[1].default_value = (10, 10, 10)
    tree.links.new(limit.outputs[0], top.inputs[0])
    tree.links.new(top.outputs[0], light.inputs["Color"])
    return made


def judge(name, out):
    kind, settings, _ = CASES[name]
    scene = start()
    scene.render.resolution_x = scene.render.resolution_y = 256
    pictures = images()
    for number, setting in enumerate(settings[: GRID * GRID]):
        sheet(number % GRID, GRID - 1 - number // GRID, 8 if kind in COARSE else 24).data.materials.append(shader(kind, setting, pictures))
    data = bpy.data.cameras.new("Camera")
    data.type, data.ortho_scale = "ORTHO", GRID
    seen = add("Camera", data, (0, 0, 5))
    scene.camera = seen
    ours, theirs = (render(engine, SAMPLES.get(name, 32)) for engine in ("GNURT", "CYCLES"))
    if out:
        png(out / f"{name.replace(' ', '_')}.png", ours, theirs)
    worst, failed = [], []
    step = 256 // GRID
    for number, setting in enumerate(settings):
        x, y = number % GRID * step, number // GRID * step
        a, b = (p[y + 3 : y + step - 3, x + 3 : x + step - 3, :3] for p in (ours, theirs))
        error = abs(a.mean() - b.mean()) / max(abs(b.mean()), 0.01)
        similar = min(ssim(a[..., c], b[..., c], max(float(np.ptp(b)), 0.1)) for c in range(3))
        worst.append((error, similar))
        if error > MEAN or similar < STRUCTURE:
            words = {k: v for k, v in setting.items() if k not in {"Vector", "setup", "image"}}
            failed.append(f"#{number} {100 * error:.1f} % {similar:.3f} {words}")
    return max(e for e, _ in worst), min(s for _, s in worst), failed, scene.gnurt.warnings


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("nodes", nargs="*")
    given = parser.parse_args()
    if given.out:
        given.out.mkdir(parents=True, exist_ok=True)
    count = 0
    for name in given.nodes or CASES:
        error, similar, failed, warnings = judge(name, given.out)
        count += bool(failed)
        print(f"{'FAIL' if failed else 'ok  '} {name:20} {100 * error:6.2f} %  {similar:.4f}", flush=True)
        for line in failed:
            print("      ", line)
        for line in warnings.splitlines():
            print("       warned:", line)
    print(f"{count} of {len(given.nodes or CASES)} nodes beyond 2 % or 0.98")
    return count > 0


if __name__ == "__main__":
    sys.exit(main())
