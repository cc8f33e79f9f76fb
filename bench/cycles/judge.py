# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles on its own Embree and on ours: small scenes, the same seed, PSNR of float pictures over four channels with a peak of 1,
and the number of pixels that differ by more than a thousandth.

Needs `pip install bpy OpenEXR numpy`. Blender's module finds `libembree4.so.4` by name, so preloading a library of that name
replaces its own.

    python judge.py LIBRARY [--samples N] [--size N] [--seed N] [SCENE ...]

How far Embree is from itself at another level of the CPU: LIBRARY made of device.c, and EMBREE_CONFIG.
"""
import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile

SCENES = {}


def scene(make):
    SCENES[make.__name__] = make
    return make


class Stage:
    """A floor, a lamp, a camera and a grey world; made anew for each picture."""

    def __init__(self, samples, size, seed):
        import bpy

        self.bpy = bpy
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.device = "CPU"
        scene.cycles.samples = samples
        scene.cycles.seed = seed
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.use_denoising = False
        scene.render.threads_mode = "FIXED"
        scene.render.threads = 2
        scene.render.resolution_x = scene.render.resolution_y = size
        scene.render.resolution_percentage = 100
        scene.render.film_transparent = False
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.render.image_settings.color_mode = "RGBA"
        scene.world = bpy.data.worlds.new("world")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.5, 0.6, 0.7, 1)
        self.camera = self.add(bpy.data.cameras.new("camera"), (0, -6, 2.2), (1.25, 0, 0))
        scene.camera = self.camera
        lamp = bpy.data.lights.new("lamp", "AREA")
        lamp.energy, lamp.size = 300, 1.5
        self.add(lamp, (2, -2, 4), (0.5, 0.45, 0))
        self.floor = self.mesh(lambda: bpy.ops.mesh.primitive_plane_add(size=12), self.matte(0.6, 0.55, 0.5))

    def add(self, data, at=(0, 0, 0), turned=(0, 0, 0)):
        made = self.bpy.data.objects.new(data.name, data)
        made.location, made.rotation_euler = at, turned
        self.scene.collection.objects.link(made)
        return made

    def mesh(self, add, material):
        add()
        made = self.bpy.context.object
        made.data.materials.append(material)
        return made

    def material(self, kind, **inputs):
        made = self.bpy.data.materials.new(kind)
        made.use_nodes = True
        nodes, links = made.node_tree.nodes, made.node_tree.links
        nodes.clear()
        out, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new(kind)
        for name, value in inputs.items():
            shader.inputs[name.replace("_", " ")].default_value = value
        links.new(shader.outputs[0], out.inputs[0])
        made["shader"] = shader.name
        return made

    def matte(self, *rgb):
        return self.material("ShaderNodeBsdfDiffuse", Color=(*rgb, 1))

    def glossy(self, *rgb):
        return self.material("ShaderNodeBsdfPrincipled", Base_Color=(*rgb, 1), Roughness=0.3)

    def ball(self, at=(0, 0, 1), radius=1.0, material=None, smooth=True):
        ops = self.bpy.ops.mesh
        made = self.mesh(
            lambda: ops.primitive_uv_sphere_add(segments=48, ring_count=24, radius=radius, location=at),
            material or self.glossy(0.7, 0.3, 0.2),
        )
        if smooth:
            self.bpy.ops.object.shade_smooth()
        return made

    def cube(self, at=(0, 0, 0.8), size=1.6, material=None):
        return self.mesh(
            lambda: self.bpy.ops.mesh.primitive_cube_add(size=size, location=at), material or self.glossy(0.3, 0.5, 0.7)
        )

    def hair(self, shape, radius=0.012, count=900, keys=6):
        """Strands on a ball."""
        self.scene.cycles_curves.shape = shape
        self.scene.cycles_curves.subdivisions = 3
        self.ball()
        pick = random.Random(7)
        data = self.bpy.data.hair_curves.new("hair")
        data.add_curves([keys] * count)
        points = []
        for _ in range(count):
            z, angle = pick.uniform(-0.3, 1), pick.uniform(0, 2 * math.pi)
            flat = math.sqrt(1 - z * z)
            at = (flat * math.cos(angle), flat * math.sin(angle), z)
            bend, length = pick.uniform(-0.5, 0.5), pick.uniform(0.5, 0.9)
            for key in range(keys):
                far = 1 + length * key / (keys - 1)
                turn = bend * (key / (keys - 1)) ** 2
                c, s = math.cos(turn), math.sin(turn)
                points.append((far * (c * at[0] - s * at[1]), far * (s * at[0] + c * at[1]), 1 + far * at[2] - 0.3 * turn * turn))
        data.position_data.foreach_set("vector", [x for point in points for x in point])
        radii = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
        radii.data.foreach_set("value", [radius * (1 - 0.7 * (i % keys) / (keys - 1)) for i in range(len(points))])
        data.materials.append(self.material("ShaderNodeBsdfHairPrincipled") if shape == "THICK" else self.glossy(0.4, 0.25, 0.1))
        return self.add(data)

    def move(self, made, *keys):
        """Keys from one frame before to one after; the shutter is open for a frame around 1."""
        self.scene.render.use_motion_blur = True
        self.scene.render.motion_blur_shutter = 1.0
        for frame, (at, turned) in zip((0, 1, 2), keys):
            made.location, made.rotation_euler = at, turned
            made.keyframe_insert("location", frame=frame)
            made.keyframe_insert("rotation_euler", frame=frame)
        self.scene.frame_set(1)


@scene
def hair_thick(stage):
    stage.hair("THICK")


@scene
def hair_ribbons(stage):
    stage.hair("RIBBONS")


@scene
def hair_thick_moving(stage):
    made = stage.hair("THICK", count=500)
    stage.move(made, ((-0.2, 0, 0), (0, 0, 0)), ((0, 0, 0), (0, 0, 0)), ((0.2, 0, 0), (0, 0, 0.2)))


@scene
def object_blur(stage):
    stage.move(stage.cube(), ((-0.4, 0, 0.9), (0, 0, 0)), ((0, 0, 0.9), (0, 0.3, 0.4)), ((0.3, 0.2, 1.2), (0.2, 0.6, 1.0)))


@scene
def shape_blur(stage):
    made = stage.ball()
    made.shape_key_add(name="rest")
    key = made.shape_key_add(name="wide")
    for i, point in enumerate(key.data):
        point.co.x *= 1.5 + 0.2 * math.sin(i)
        point.co.z *= 0.8
    for frame, value in ((0, 0), (1, 0.4), (2, 1)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    made.cycles.use_deform_motion, made.cycles.motion_steps = True, 3
    stage.scene.render.use_motion_blur = True
    stage.scene.render.motion_blur_shutter = 1.0
    stage.scene.frame_set(1)


@scene
def camera_blur(stage):
    stage.ball()
    stage.cube(at=(-1.6, 1, 0.8))
    turned = (1.25, 0, 0)
    stage.move(stage.camera, ((-0.3, -6, 2.2), turned), ((0, -6, 2.2), turned), ((0.3, -6, 2.3), (1.25, 0.02, 0.05)))


@scene
def points(stage):
    pick = random.Random(5)
    group = stage.bpy.data.node_groups.new("points", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    new, link = group.nodes.new, group.links.new
    enter, leave = new("NodeGroupInput"), new("NodeGroupOutput")
    turn, paint = new("GeometryNodeMeshToPoints"), new("GeometryNodeSetMaterial")
    turn.inputs["Radius"].default_value = 0.06
    paint.inputs["Material"].default_value = stage.glossy(0.5, 0.6, 0.2)
    link(enter.outputs[0], turn.inputs["Mesh"])
    link(turn.outputs[0], paint.inputs["Geometry"])
    link(paint.outputs[0], leave.inputs[0])
    data = stage.bpy.data.meshes.new("cloud")
    data.from_pydata([(pick.gauss(0, 0.6), pick.gauss(0, 0.6), 1 + pick.gauss(0, 0.5)) for _ in range(600)], [], [])
    stage.add(data).modifiers.new("points", "NODES").node_group = group


@scene
def subdivision(stage):
    if hasattr(stage.scene.cycles, "feature_set"):
        stage.scene.cycles.feature_set = "EXPERIMENTAL"
    made = stage.cube(at=(0, 0, 1.1), size=2)
    surface = made.modifiers.new("subdivision", "SUBSURF")
    surface.levels = surface.render_levels = 2
    for where in (surface, getattr(made, "cycles", None)):
        if hasattr(where, "use_adaptive_subdivision"):
            where.use_adaptive_subdivision = True


@scene
def volume(stage):
    made = stage.material("ShaderNodeVolumePrincipled", Density=1.2, Color=(0.6, 0.7, 0.9, 1))
    tree = made.node_tree
    tree.links.new(tree.nodes[made["shader"]].outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    for link in list(tree.nodes["Material Output"].inputs["Surface"].links):
        tree.links.remove(link)
    stage.cube(at=(0, 0, 1.1), size=2, material=made)
    stage.ball(at=(0.2, 0, 1), radius=0.5)


@scene
def bevel(stage):
    made = stage.glossy(0.7, 0.7, 0.3)
    tree = made.node_tree
    node = tree.nodes.new("ShaderNodeBevel")
    node.samples, node.inputs["Radius"].default_value = 6, 0.2
    tree.links.new(node.outputs[0], tree.nodes[made["shader"]].inputs["Normal"])
    stage.cube(material=made).rotation_euler = (0, 0, 0.5)


@scene
def random_walk(stage):
    made = stage.material(
        "ShaderNodeBsdfPrincipled", Base_Color=(0.9, 0.6, 0.5, 1), Subsurface_Weight=1.0, Subsurface_Radius=(0.5, 0.2, 0.1)
    )
    made.node_tree.nodes[made["shader"]].subsurface_method = "RANDOM_WALK"
    stage.ball(material=made)
    stage.cube(at=(-1.7, 0.8, 0.6), size=1.2, material=made)


@scene
def nested_instances(stage):
    bpy = stage.bpy
    inner, outer = bpy.data.collections.new("inner"), bpy.data.collections.new("outer")
    ball = stage.ball(at=(0, 0, 0.25), radius=0.25)
    stage.scene.collection.objects.unlink(ball)
    inner.objects.link(ball)
    for i in range(5):
        made = bpy.data.objects.new("in", None)
        made.instance_type, made.instance_collection = "COLLECTION", inner
        made.location, made.scale = (0.6 * i - 1.2, 0, 0.1 * i), (1, 1, 1 + 0.2 * i)
        outer.objects.link(made)
    for i in range(4):
        made = bpy.data.objects.new("out", None)
        made.instance_type, made.instance_collection = "COLLECTION", outer
        made.location, made.rotation_euler = (0, 0.9 * i - 1, 0.4 * i), (0, 0.1 * i, 0.3 * i)
        stage.scene.collection.objects.link(made)


@scene
def shadow_catcher(stage):
    stage.scene.render.film_transparent = True
    stage.floor.is_shadow_catcher = True
    stage.ball()
    stage.cube(at=(-1.6, 0.5, 0.8))


@scene
def occlusion_inside(stage):
    made = stage.matte(0.8, 0.8, 0.8)
    tree = made.node_tree
    node = tree.nodes.new("ShaderNodeAmbientOcclusion")
    node.samples, node.only_local, node.inputs["Distance"].default_value = 8, True, 0.8
    tree.links.new(node.outputs[0], tree.nodes[made["shader"]].inputs["Color"])
    stage.cube(material=made)
    stage.ball(at=(1.5, 0.5, 0.6), radius=0.6, material=made)


@scene
def glass(stage):
    stage.ball(material=stage.material("ShaderNodeBsdfGlass", IOR=1.45, Roughness=0.05))
    stage.cube(at=(-1.6, 1, 0.8))


@scene
def transparent_shadows(stage):
    made = stage.material("ShaderNodeBsdfTransparent", Color=(0.8, 0.9, 0.6, 1))
    for i in range(6):
        stage.ball(at=(0.4 * i - 1, 0.3 * i - 1, 1.0), radius=0.6, material=made)
    stage.cube(at=(0, 1.8, 0.8))


def read(path):
    import numpy
    import OpenEXR

    channels = OpenEXR.File(path).channels()
    if "RGBA" in channels:
        return channels["RGBA"].pixels
    return numpy.stack([channels[c].pixels for c in "RGBA"], -1)


def render(arguments, name, library, output):
    command = [sys.executable, __file__, library, "--draw", name, output]
    command += ["--samples", str(arguments.samples), "--size", str(arguments.size), "--seed", str(arguments.seed)]
    changed = {"LD_PRELOAD": library} if library else {}
    done = subprocess.run(command, env={**os.environ, **changed}, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{name}: {done.stderr[-2000:]}")
    plain = ("Fra:", "Saved:", "Time:", " Time:", "Embree:", "Blender quit", "Info:")
    lines = (done.stdout + done.stderr).splitlines()
    loaded = [line.split(" ", 1)[1] for line in lines if line.startswith("Embree:")]
    usual = ("| render ", " render  ")
    said = [line for line in lines if line.strip() and not line.startswith(plain) and not any(word in line for word in usual)]
    return loaded, said


def draw(arguments):
    name, output = arguments.draw
    stage = Stage(arguments.samples, arguments.size, arguments.seed)
    SCENES[name](stage)
    stage.scene.render.filepath = output
    stage.bpy.ops.render.render(write_still=True)
    with open("/proc/self/maps", encoding="utf-8") as maps:
        print("Embree:", *sorted({line.split()[-1] for line in maps if "embree" in line}))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("library")
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--draw", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--json")
    arguments = parser.parse_args()
    if arguments.draw:
        return draw(arguments)
    import numpy

    values = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.scenes or SCENES:
            pictures, messages = [], []
            for library in ("", os.path.abspath(arguments.library)):
                output = os.path.join(folder, f"{name}-{bool(library)}.exr")
                loaded, said = render(arguments, name, library, output)
                assert (library in " ".join(loaded)) if library else loaded, f"loaded: {loaded}"
                pictures.append(read(output).astype(float))
                messages.append(said)
            off = numpy.abs(pictures[0] - pictures[1])
            error, pixels = numpy.mean(off**2), int((off.max(axis=-1) > 1e-3).sum())
            new = [line for line in messages[1] if line not in messages[0]]
            values[name] = {"psnr": round(-10 * math.log10(error), 1) if error else math.inf, "pixels": pixels, "messages": new}
            print(f"{name:20} {values[name]['psnr']:6.1f} dB, {pixels} pixels differ  {' | '.join(new)}", flush=True)
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump({"samples": arguments.samples, "size": arguments.size, "seed": arguments.seed, "scenes": values}, file, indent=1)
    return None


if __name__ == "__main__":
    main()
