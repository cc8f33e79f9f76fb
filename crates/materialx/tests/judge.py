# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares our shaders of MaterialX with the OSL that MaterialX's own generator writes, both run by `gnurt`.

    pip install materialx numpy
    cargo build -p gnurt-cli && cargo build -p gnurt-materialx --example mtlx2osl
    python3 crates/materialx/tests/judge.py values [PATTERN...]
    python3 crates/materialx/tests/judge.py pictures [SETS [SEED]]

`values` runs each definition of numbers by `testshade` at 25 points with four sets of inputs; `pictures` renders two spheres with
materials of five shading models. Exit status 0 if all values agree to 1e-4, and the means of all pictures to 2 %; 77 if the wheel
`materialx` is absent.
"""
import os
import random
import re
import subprocess
import sys
import tempfile

try:
    import MaterialX as mx
    import MaterialX.PyMaterialXGenOsl as mx_osl
    import MaterialX.PyMaterialXGenShader as mx_shader
    import numpy as np
except ImportError as error:
    print(f"SKIPPED: {error}; pip install materialx numpy", file=sys.stderr)
    sys.exit(77)

ROOT = os.path.dirname(mx.__file__)
INCLUDE = ROOT + "/libraries/stdlib/genosl/include"
GNURT = os.path.abspath(os.environ.get("GNURT", "target/debug/gnurt"))
OURS = os.path.abspath(os.environ.get("MTLX2OSL", "target/debug/examples/mtlx2osl"))
WORK = tempfile.mkdtemp(prefix="materialx-judge-")
LIBRARY = mx.createDocument()
PATHS = mx.FileSearchPath(ROOT)
mx.loadLibraries(["libraries"], PATHS, LIBRARY)
LEN = {"float": 1, "integer": 1, "boolean": 1, "color3": 3, "color4": 4, "vector2": 2, "vector3": 3, "vector4": 4,
       "matrix33": 9, "matrix44": 16}
# Their OSL returns a constant.
PLACEHOLDERS = {"ND_deon_hair_absorption_from_melanin", "ND_chiang_hair_absorption_from_color"}


def theirs(text, name):
    """The OSL of MaterialX's generator."""
    document = mx.createDocument()
    mx.readFromXmlString(document, text)
    document.importLibrary(LIBRARY)
    generator = mx_osl.OslShaderGenerator.create()
    context = mx_shader.GenContext(generator)
    context.registerSourceCodeSearchPath(PATHS)
    context.registerSourceCodeSearchPath(mx.FileSearchPath(ROOT + "/libraries"))
    colors = mx_shader.DefaultColorManagementSystem.create(generator.getTarget())
    colors.loadLibrary(LIBRARY)
    generator.setColorManagementSystem(colors)
    shader = generator.generate(name, document.getDescendant(name), context)
    return shader.getSourceCode("pixel")


def document(elements):
    return f'<?xml version="1.0"?>\n<materialx version="1.39">{elements}</materialx>'


def numbers_of(kind, v):
    """The numbers of a value of their OSL."""
    triple = [f"{v}[{i}]" for i in range(3)]
    matrix = [f"{v}[{i}][{j}]" for i in range(4) for j in range(4)]
    return {
        "float": [v], "integer": [f"(float) {v}"], "boolean": [f"(float) {v}"], "color3": triple, "vector3": triple,
        "vector2": [v + ".x", v + ".y"], "vector4": [f"{v}.{c}" for c in "xyzw"],
        "color4": [f"{v}.rgb[{i}]" for i in range(3)] + [v + ".a"],
        "matrix33": [matrix[i * 4 + j] for i in range(3) for j in range(3)], "matrix44": matrix,
    }[kind]


def numbers_of_ours(kind):
    v = "result"
    if kind in ("vector2", "vector4"):
        return [v] + [f"{v}_{i}" for i in range(1, LEN[kind])]
    return [f"{v}[{i}]" for i in range(3)] + [v + "_1"] if kind == "color4" else numbers_of(kind, v)


def run(text, name, numbers):
    """The numbers at the points of a grid."""
    end = text.rstrip().rindex("}")
    line = '    printf("@' + " %.8g" * len(numbers) + '\\n", ' + ", ".join(numbers) + ");\n}\n"
    file = f"{WORK}/{name}.osl"
    with open(file, "w") as out:
        out.write(text[:end] + line)
    subprocess.run([GNURT, "oslc", "-q", "-I" + INCLUDE, "-o", f"{WORK}/{name}.oso", file], cwd=WORK, check=True)
    shaded = subprocess.run([GNURT, "testshade", "-g", "5", "5", f"{WORK}/{name}.oso"], cwd=WORK, check=True,
                            capture_output=True, text=True)
    return [[float(x) for x in line[1:].split()] for line in shaded.stdout.splitlines() if line.startswith("@")]


def input_value(rng, kind, is_positive):
    if kind == "integer":
        return str(rng.randint(0, 3))
    if kind == "boolean":
        return rng.choice(["true", "false"])
    if kind.startswith("matrix"):
        stride = 4 if kind == "matrix33" else 5
        return ", ".join(f"{rng.uniform(-1, 1) + (3 if i % stride == 0 else 0):.3f}" for i in range(LEN[kind]))
    low, high = (0.05, 0.95) if is_positive else (-1.2, 1.5)
    return ", ".join(f"{rng.uniform(low, high):.3f}" for _ in range(LEN[kind]))


def inputs_of(rng, definition, is_positive):
    node, text = definition.getNodeString(), ""
    for port in definition.getActiveInputs():
        name, kind = port.getName(), port.getType()
        if kind not in LEN or port.hasDefaultGeomPropString() or node in ("texcoord", "tangent", "bitangent", "geomcolor"):
            continue
        value = input_value(rng, kind, is_positive)
        if node == "extract" and name == "index":
            value = str(rng.randint(0, 1))
        if name == "temperature":
            value = str(rng.randint(1000, 12000))
        text += f'<input name="{name}" type="{kind}" value="{value}"/>'
    return text


def worst_of(definition, rng):
    name, node, kind = definition.getName(), definition.getNodeString(), definition.getActiveOutputs()[0].getType()
    worst = 0.0
    for trial in range(4):
        is_positive = trial % 2 == 0 or node in ("sqrt", "ln", "acos", "asin")
        inputs = inputs_of(rng, definition, is_positive)
        text = document(f'<{node} name="n" type="{kind}" nodedef="{name}">{inputs}</{node}>')
        with open(WORK + "/d.mtlx", "w") as out:
            out.write(text)
        expected = theirs(text, "n")
        variable = re.search(r"output (\S+) (\w+) =", expected).group(2)
        ours = subprocess.run([OURS, WORK + "/d.mtlx", "n"], check=True, capture_output=True, text=True).stdout
        pairs = zip(run(expected, "theirs", numbers_of(kind, variable)), run(ours, "ours", numbers_of_ours(kind)))
        for a, b in ((a, b) for row in pairs for a, b in zip(*row)):
            if a == a:
                worst = max(worst, abs(a - b) / max(1, abs(a)) if b == b else 9)
    return worst


def values(patterns):
    rng, nodes, good, bad = random.Random(5), set(), 0, []
    for definition in LIBRARY.getNodeDefs():
        name, outputs = definition.getName(), definition.getActiveOutputs()
        if patterns and not any(re.fullmatch(pattern, name) for pattern in patterns):
            continue
        has_file = any(port.getType() == "filename" for port in definition.getActiveInputs())
        if len(outputs) != 1 or outputs[0].getType() not in LEN or has_file or name in PLACEHOLDERS:
            continue
        worst = worst_of(definition, rng)
        if worst > 1e-4:
            bad.append(name)
            print(f"{name}: differs by {worst:.3g}")
        else:
            good += 1
            nodes.add(definition.getNodeString())
    print(f"{good} definitions of {len(nodes)} nodes agree to 1e-4, {len(bad)} do not")
    return not bad


def materials(model, count, rng):
    """Inputs of a shading model: none, then random ones."""
    yield []
    ports = LIBRARY.getMatchingNodeDefs(model)[0].getActiveInputs()
    for _ in range(count):
        inputs = []
        for port in ports:
            name, kind = port.getName(), port.getType()
            # Their OSL has no thin walls.
            words = ("displacement", "occlusion", "normal", "tangent", "thin_walled")
            left_out = any(word in name for word in words)
            if port.hasDefaultGeomPropString() or rng.random() < 0.55 or left_out:
                continue
            if kind == "float":
                low = float(port.getAttribute("uimin") or 0)
                high = float(port.getAttribute("uimax") or port.getAttribute("uisoftmax") or 1)
                if "ior" in name.lower():
                    low, high = 1.2, 2.2
                low = 0.1 if "roughness" in name.lower() else low
                value = f"{rng.uniform(low, min(high, 4)):.3f}"
            elif kind == "color3":
                value = ", ".join(f"{rng.random():.3f}" for _ in range(3))
            elif kind in ("integer", "boolean"):
                value = str(rng.randint(0, 1)) if kind == "integer" else rng.choice(["true", "false"])
            else:
                continue
            inputs.append(f'<input name="{name}" type="{kind}" value="{value}"/>')
        yield inputs


def rendered(shader):
    out = WORK + "/p.pfm"
    subprocess.run([GNURT, "render", "builtin:spheres", "-q", "--include", INCLUDE, "--shader", "gold=" + shader,
                    "--shader", "mirror=" + shader, "-r", "64x48", "--spp", "36", "-o", out],
                   check=True, capture_output=True)
    with open(out, "rb") as file:
        _, size, _, data = file.read().split(b"\n", 3)
    width, height = map(int, size.split())
    return np.frombuffer(data, "<f4").reshape(height, width, 3)


def pictures(count, seed):
    rng, worst, equal, total = random.Random(seed), 0.0, 0, 0
    for model in ("standard_surface", "open_pbr_surface", "gltf_pbr", "UsdPreviewSurface", "disney_principled"):
        for number, inputs in enumerate(materials(model, count, rng)):
            text = document(f'<{model} name="S" type="surfaceshader">{"".join(inputs)}</{model}>'
                            '<surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" '
                            'nodename="S"/></surfacematerial>')
            files = [f"{WORK}/m.mtlx", f"{WORK}/m.osl"]
            for file, content in zip(files, (text, theirs(text, "M"))):
                with open(file, "w") as out:
                    out.write(content)
            ours, expected = map(rendered, files)
            mean = float(abs(ours.mean((0, 1)) / expected.mean((0, 1)) - 1).max())
            pixels = float(abs(ours - expected).mean() / expected.mean())
            worst, equal, total = max(worst, mean), equal + (pixels == 0), total + 1
            print(f"{model} {number}: means {mean:.2%}, pixels {pixels:.2%}", flush=True)
    print(f"{total} materials: means agree to {worst:.2%}, {equal} are equal in every pixel")
    return worst <= 0.02


if __name__ == "__main__":
    what, rest = (sys.argv + [""])[1], sys.argv[2:]
    if what == "values":
        passed = values(rest)
    elif what == "pictures":
        passed = pictures(int(rest[0]) if rest else 9, int(rest[1]) if len(rest) > 1 else 11)
    else:
        sys.exit(__doc__)
    sys.exit(0 if passed else 1)
