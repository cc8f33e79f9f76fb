# SPDX-License-Identifier: GPL-3.0-or-later
"""Times kernels of the shading language by OSL with LLVM, as Cycles runs it: nanoseconds a point, one thread.

The kernels are those of `cargo run --release -p gnurt-jit --example speed`, which prints ours. Each is a script node whose colour a
plane before the camera emits. The time of a point is the difference of two renders with different numbers of samples, over
their points, less that of a script that does nothing. Medians of several rounds.

Usage: pip install bpy; python llvm.py [--rounds N] [--speed FILE]

`--speed` is the output of the example; then a table beside it is printed.
"""

import argparse
import json
import pathlib
import re
import statistics
import sys
import tempfile
import time

import bpy

SIZE, FEW, MANY = 256, 4, 20
ONES = "sin cos tan asin acos atan exp exp2 log log10 sqrt inversesqrt cbrt erf floor abs cosh".split()
OTHERS = {
    "pow": "f += pow(u + i, v);",
    "atan2": "f += atan2(u + i, v + f);",
    "fmod": "f += fmod(u * i, v + 0.1);",
    "div": "f += u / (v + i);",
    "smoothstep": "f += smoothstep(0.1, 0.9, u * f + i * 0.01);",
    "mix": "o = mix(o, P, u);",
    "clamp": "o = clamp(o + P, -1, 1);",
    "dot": "f += dot(P, I + i);",
    "cross": "o = cross(o, P);",
    "normalize": "o += normalize(P + i);",
    "length": "f += length(P + f);",
    "transform": "o = transform(matrix(u, 0, v, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1), o);",
    "noise 1D": "f += noise(u * 8 + i);",
    "noise 3D": "f += noise(P * 4 + i);",
    "noise 4D": "f += noise(P * 4, u + i);",
    "color noise 3D": "o += noise(P * 4 + i);",
    "simplex 3D": 'f += noise("simplex", P * 4 + i);',
    "cellnoise 3D": "f += cellnoise(P * 4 + i);",
    "pnoise 2D": "f += pnoise(u * 8 + i, v * 8, 3, 4);",
    "if, varying": "if (noise(u * 9 + i) > 0.5) f += u * v + i; else o += P;",
    "int": "k = (k * 5 + i) ^ (k >> 3) & (int) (u * 100);",
    "compare": "k += (u + f < v) + (P == I) + (f >= i);",
}


def divergent(channels):
    names = "abc"[:channels]
    start = "".join(f"float {n} = max(0, dot(N, I)) * v;" for n in names)
    turn = "".join(f"{n} = {n} * 1.01 + P[0] * {n} * 0.125 + 0.0625;" for n in names)
    end = "".join(f"(u > 0.5 ? {n} : -{n}) + " for n in names)
    return f"{start} int n = (int) (u * 8.9); int i = 0; while (i < n) {{ {turn} i += 1; if (a > 2.5) break; }} f = {end}0;"


def kernels():
    turned = {name: f"f += {name}(v + f * 0.25 + i);" for name in ONES} | OTHERS
    made = {name: f"for (int i = 0; i < 32; ++i) {{ {body} }}" for name, body in turned.items()}
    return made | {
        "masked loop, long": "int n = (int) (u * 300); for (int i = 0; i < n; ++i) { f = f * 0.99 + v; if (f > 90) break; }",
        "loop with a continue": "for (int i = 0; i < 30; ++i) { if (fmod(u * i, 0.3) < 0.1) continue; f += v; }",
        "unknown index": "float a[4] = {u, v, 1, 2}; for (int i = 0; i < 32; ++i) f += a[i & 3];",
        "design, 1 channel": divergent(1),
        "design, 3 channels": divergent(3),
    }


def prepare():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    # The wheel lacks `oslquery`, with which Cycles makes a script's sockets.
    import cycles.osl

    cycles.osl.update_script_node = lambda node, report: None
    scene.cycles.max_bounces = 0
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0.5, 0.5, 2)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.98
    # One triangle fills the view: P goes from 0 to 1, and stands for u and v, which would go to a half.
    mesh = bpy.data.meshes.new("triangle")
    mesh.from_pydata([(0, 0, 0), (2, 0, 0), (0, 2, 0)], [], [(0, 1, 2)])
    plane = bpy.data.objects.new("plane", mesh)
    material = bpy.data.materials.new("kernel")
    material.use_nodes = True
    material.cycles.emission_sampling = "NONE"
    tree = material.node_tree
    tree.nodes.clear()
    output, emission = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    for thing in (camera, plane):
        scene.collection.objects.link(thing)
    scene.camera = camera
    return scene, tree, emission


def script(tree, emission, number, body):
    """Puts a kernel before the emission; ends the program where OSL cannot compile it."""
    import _cycles

    text = f"shader kernel{number}(output color Out = 0) {{ float f = 0; point o = 0; int k = 0; {{ float u = P[0], v = P[1]; {body} }} Out = color(f, o[0] + o[1] + o[2], k); }}"
    node = tree.nodes.new("ShaderNodeScript")
    node.mode, node.script = "INTERNAL", bpy.data.texts.new(f"kernel{number}")
    with tempfile.TemporaryDirectory() as folder:
        source, code = pathlib.Path(folder, "kernel.osl"), pathlib.Path(folder, "kernel.oso")
        source.write_text(text)
        if not _cycles.osl_compile(str(source), str(code)):
            sys.exit(f"OSL cannot compile: {body}")
        node.bytecode, node.bytecode_hash = code.read_text(), f"kernel{number}"
    tree.links.new(node.outputs.new("NodeSocketColor", "Out"), emission.inputs["Color"])
    return node


def seconds(scene, samples):
    scene.cycles.samples = samples
    begin = time.perf_counter()
    bpy.ops.render.render()
    return time.perf_counter() - begin


def measured(scene, tree, emission, number, body, rounds):
    node = script(tree, emission, number, body)
    seconds(scene, FEW)
    points = SIZE * SIZE * (MANY - FEW)
    found = [(seconds(scene, MANY) - seconds(scene, FEW)) / points * 1e9 for _ in range(rounds)]
    tree.nodes.remove(node)
    return statistics.median(found)


def ours(path):
    """Rows of the example's table: a name, then numbers."""
    found = {}
    for line in open(path):
        row = re.match(r"(\S.*?)\s{2,}([\d.\s]+)", line)
        if row:
            found[row[1].strip()] = [float(x) for x in row[2].split()]
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--speed")
    parser.add_argument("only", nargs="*")
    arguments = parser.parse_args()
    stage = prepare()
    nothing = measured(*stage, 0, "", arguments.rounds)
    known, all_kernels = ours(arguments.speed) if arguments.speed else {}, kernels()
    table = {}
    for number, name in enumerate(arguments.only or all_kernels, 1):
        table[name] = measured(*stage, number, all_kernels[name], arguments.rounds) - nothing
        print(f"{name:24} {table[name]:9.1f}", *(f"{x:9.1f}" for x in known.get(name, [])), flush=True)
    for column, what in ((1, "one point at a time"), (2, "AVX2, 16"), (7, "AVX-512, 16"), (8, "AVX-512, 32")):
        ratios = [table[name] / known[name][column] for name in table if len(known.get(name, [])) > column]
        if ratios:
            print(f"OSL over ours, {what}: geometric mean {statistics.geometric_mean(ratios):.2f}, least {min(ratios):.2f}, median {statistics.median(ratios):.2f}")
    print(json.dumps({"nothing": nothing, "ns": table}))


if __name__ == "__main__":
    main()
