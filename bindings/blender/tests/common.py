# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of Blender made by script, rendered by two engines and compared."""

import os
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent.parent / "python/python")]
try:
    import bpy
    import numpy as np
except ImportError as missing:
    print(f"SKIPPED: the judge of Blender; {missing}. Install bpy for this Python: pip install bpy", file=sys.stderr)
    sys.exit(0)

import gnurt_blender

SIZE = 128


def start():
    """An empty scene with equal settings for both engines."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(bpy.types.Scene, "gnurt"):
        gnurt_blender.register()
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGBA"
    cycles = scene.cycles
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_indirect = cycles.sample_clamp_direct = cycles.blur_glossy = cycles.light_sampling_threshold = 0
    for name in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{name}_bounces", 12)
    # Cycles counts scattering in volumes apart; the package counts all bounces alike.
    cycles.volume_bounces = 12
    cycles.transparent_max_bounces = 32
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    world = bpy.data.worlds.new("World")
    scene.world = world
    world.use_nodes = True
    background(0.05)
    return scene


def background(*color):
    color = (*color, *color, *color)[:3] if len(color) == 1 else color
    node = next(n for n in bpy.context.scene.world.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs["Color"].default_value = (*color, 1)
    return node


def camera(where=(0, -6, 3), target=(0, 0, 0.5), lens=50, **settings):
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    for name, value in settings.items():
        setattr(data, name, value)
    made = add("Camera", data, where)
    from mathutils import Vector

    made.rotation_euler = (Vector(target) - Vector(where)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = made
    return made


def add(name, data, where=(0, 0, 0)):
    made = bpy.data.objects.new(name, data)
    made.location = where
    bpy.context.scene.collection.objects.link(made)
    made.pass_index = len(bpy.data.objects)
    return made


def light(kind, where, energy, target=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    for name, value in settings.items():
        setattr(data, name, value)
    made = add(kind, data, where)
    from mathutils import Vector

    made.rotation_euler = (Vector(target) - Vector(where)).to_track_quat("-Z", "Y").to_euler()
    return made


def material(name="Material", kind="ShaderNodeBsdfPrincipled", **inputs):
    """A material of one shader node; names of inputs have _ for blanks."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(kind)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    for key, value in inputs.items():
        if hasattr(shader, key) and not key[0].isupper():
            setattr(shader, key, value)
            continue
        socket = shader.inputs[key.replace("_", " ")]
        if socket.type == "RGBA":
            value = (*value, 1) if hasattr(value, "__len__") else (value, value, value, 1)
        socket.default_value = value
    return made


def filled(made, kind, **inputs):
    """A material with a volume node, and no surface where `made` is a name."""
    is_alone = isinstance(made, str)
    made = material(made, kind, **inputs) if is_alone else made
    tree = made.node_tree
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    if is_alone:
        node = output.inputs["Surface"].links[0].from_node
        tree.links.remove(output.inputs["Surface"].links[0])
    else:
        node = tree.nodes.new(kind)
        for key, value in inputs.items():
            socket = node.inputs[key.replace("_", " ")]
            socket.default_value = ((*value, 1) if hasattr(value, "__len__") else (value,) * 3 + (1,)) if socket.type == "RGBA" else value
    tree.links.new(node.outputs[0], output.inputs["Volume"])
    return made


def emission_of(lamp):
    """The tree of a light, made here, and its emission."""
    lamp.data.use_nodes = True
    tree = lamp.data.node_tree
    return tree, next(n for n in tree.nodes if n.type == "EMISSION")


def nodes_of(made):
    """The tree of a material, its output and its shader."""
    tree = made.node_tree
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    return tree, output, output.inputs["Surface"].links[0].from_node


def shape(kind, where=(0, 0, 0), made=None, smooth=False, **options):
    """A mesh by Blender's operator."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=where, **options)
    found = bpy.context.object
    found.pass_index = len(bpy.data.objects)
    if made:
        found.data.materials.append(made)
    if smooth:
        found.data.shade_smooth()
    return found


def floor(made=None, size=12, where=(0, 0, 0)):
    return shape("plane", where, made or material("Floor", "ShaderNodeBsdfDiffuse", Color=0.6), size=size)


def render(engine, samples=64, passes=False):
    """The picture of an engine: (height, width, 4), the upper row first; with `passes` the object index, too."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.cycles.samples = scene.gnurt.samples = samples
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "picture.exr")
        bpy.ops.render.render(write_still=True)
        return load(scene.render.filepath)


def load(path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, -1)[::-1]


def mask():
    """The index of the object in each pixel, by rays from the camera; borders are 0."""
    scene = bpy.context.scene
    depsgraph = bpy.context.evaluated_depsgraph_get()
    seen = scene.camera
    frame = [seen.matrix_world @ corner for corner in seen.data.view_frame(scene=scene)]
    made = np.zeros((SIZE, SIZE), int)
    if seen.data.type == "PANO":
        return made
    right, down = frame[0] - frame[3], frame[2] - frame[3]
    origin = seen.matrix_world.translation
    for y in range(SIZE):
        for x in range(SIZE):
            at = frame[3] + right * ((x + 0.5) / SIZE) + down * ((y + 0.5) / SIZE)
            way = at - origin if seen.data.type == "PERSP" else seen.matrix_world.to_3x3() @ seen_forward()
            begin = origin if seen.data.type == "PERSP" else at
            hit, _, _, _, found, _ = scene.ray_cast(depsgraph, begin, way.normalized())
            made[y, x] = found.pass_index if hit else 0
    inner = made.copy()
    for axis in (0, 1):
        for step in (1, -1, 2, -2):
            inner[np.roll(made, step, axis) != made] = 0
    return inner


def seen_forward():
    from mathutils import Vector

    return Vector((0, 0, -1))


def ssim(a, b, top):
    """Structural similarity of two grey pictures whose values span `top`, by windows of 7 x 7 [Wang et al. 2004]."""
    a, b = a.astype(np.float64), b.astype(np.float64)

    def mean(x):
        s = np.cumsum(np.cumsum(np.pad(x, ((1, 0), (1, 0))), 0), 1)
        return (s[7:, 7:] - s[:-7, 7:] - s[7:, :-7] + s[:-7, :-7]) / 49

    c1, c2 = (0.01 * top) ** 2, (0.03 * top) ** 2
    ma, mb = mean(a), mean(b)
    va, vb, cov = mean(a * a) - ma * ma, mean(b * b) - mb * mb, mean(a * b) - ma * mb
    return float((((2 * ma * mb + c1) * (2 * cov + c2)) / ((ma * ma + mb * mb + c1) * (va + vb + c2))).mean())


def png(path, *pictures):
    """Pictures side by side as a file for the eye."""
    joined = np.concatenate([p[..., :3] for p in pictures], axis=1)
    light = np.clip(joined, 0, 1)
    shown = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    height, width = shown.shape[:2]
    image = bpy.data.images.new("side", width, height)
    image.pixels.foreach_set(np.dstack([shown, np.ones((height, width))])[::-1].astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)
