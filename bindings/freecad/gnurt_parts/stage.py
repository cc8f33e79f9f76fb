# SPDX-License-Identifier: GPL-3.0-or-later
"""Text of a stage in USD: objects, cameras, shaders. Lengths are metres, z is up, angles are degrees."""

import math
import os
import re

#: A top-level prim with a shader's text. The first word is the place of the shader: look, light or environment.
SHADER = re.compile(r"string info:osl:sourceCode = '''// (\w+) (\w+)\n(.*?)'''", re.DOTALL)
PRIM = re.compile(r'(?m)^(?=def \w+ ")')


def identifier(name):
    """A name that USD, files and the shading language accept."""
    word = re.sub(r"\W", lambda sign: "_" if sign[0] in "#.- " else f"_{ord(sign[0]):x}", str(name), flags=re.ASCII)
    return word if word[:1].isalpha() else "o" + word


def tuples(rows):
    """Rows of numbers as USD has them."""
    return ", ".join("(" + ", ".join(f"{x:.9g}" for x in row) + ")" for row in rows)


def columns(placement):
    """The columns of a placement's matrix, which USD writes as rows."""
    flat = placement.toMatrix().A
    return [[flat[4 * row + column] for row in range(4)] for column in range(4)]


def transform(matrix):
    """The two lines that place a prim."""
    return (
        f"    matrix4d xformOp:transform = ({tuples(matrix)})\n"
        '    uniform token[] xformOpOrder = ["xformOp:transform"]\n'
    )


def write_whole(path, text):
    """Writes a file that is never seen half."""
    partial = path + ".partial"
    with open(partial, "w", encoding="utf-8", newline="\n") as file:
        file.write(text)
    os.replace(partial, path)


def write_triangles(path, mesh):
    """Writes the triangles of a mesh of the workbench, in its own space."""
    facets = [tuple(int(i) for i in facet) for facet in mesh.facets]
    lines = [
        '#usda 1.0\n(\n    defaultPrim = "Mesh"\n    metersPerUnit = 1\n    upAxis = "Z"\n)\n',
        'def Mesh "Mesh"\n{',
        '    uniform token subdivisionScheme = "none"',
        "    uniform bool doubleSided = true",
        f"    int[] faceVertexCounts = [{', '.join(['3'] * len(facets))}]",
        f"    int[] faceVertexIndices = [{', '.join(f'{a}, {b}, {c}' for a, b, c in facets)}]",
        f"    point3f[] points = [{tuples(mesh.points)}]",
    ]
    if mesh.has_vnormals():
        lines.append(f'    normal3f[] normals = [{tuples(mesh.vnormals)}] (\n        interpolation = "vertex"\n    )')
    if mesh.has_uvmap():
        places = tuples((place.real, place.imag) for place in mesh.uvmap)
        lines.append(f'    texCoord2f[] primvars:st = [{places}] (\n        interpolation = "vertex"\n    )')
    write_whole(path, "\n".join(lines) + "\n}\n")


def shader(place, name, text):
    """A shader in the stage, for `complete` to take out."""
    return f"string info:osl:sourceCode = '''// {place} {name}\n{text}'''"


def object_(name, path, matrix, look):
    """An object: a reference to its triangles, a place, and a material.

    Other programs see the material's colour; our program shows the shader in its place.
    """
    name = identifier(name)
    text, color = look
    return f"""def Xform "{name}"
{{
{transform(matrix)}    def Mesh "Mesh" (
        prepend references = @@@./{path}@@@
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        rel material:binding = </{name}/{name}_look>
    }}
    def Material "{name}_look"
    {{
        token outputs:surface.connect = </{name}/{name}_look/Preview.outputs:surface>
        custom {shader("look", name + "_look", text)}
        def Shader "Preview"
        {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = {tuples([color])}
            token outputs:surface
        }}
    }}
}}
"""


def camera(name, matrix, fov, resolution):
    """A camera whose angle of view is that of the picture's height."""
    height = 24.0
    length = height / 2 / math.tan(math.radians(min(max(float(fov), 0.01), 179.0)) / 2)
    width = height * resolution[0] / max(resolution[1], 1)
    return f"""def Camera "{identifier(name)}"
{{
{transform(matrix)}    float focalLength = {length:.9g}
    float horizontalAperture = {width:.9g}
    float verticalAperture = {height:.9g}
}}
"""


def cameras(text):
    """Names of the cameras, in their order."""
    return re.findall(r'(?m)^def Camera "(\w+)"', text)


def has_surroundings(text):
    """Whether there is a dome or a sky."""
    return "\ndef DomeLight " in text or "'''// environment " in text


def complete(text):
    """Makes a stage of an instantiated template. Returns it and its shaders: (place, name, text).

    Names that occur twice get a number. The last environment is the one: domes before it are left out.
    """
    head, *prims = PRIM.split(text)
    seen, kept = {}, []
    for prim in prims:
        name = re.match(r'def \w+ "(\w+)"', prim)[1]
        seen[name] = seen.get(name, 0) + 1
        if seen[name] > 1:
            # Not the file of the triangles: both have the same.
            prim = re.sub(rf'(?<=[</"\s]){name}(?=_look\b|["/>])', f"{name}_{seen[name]}", prim)
        kept.append(prim)
    around = [i for i, prim in enumerate(kept) if prim.startswith("def DomeLight") or "'''// environment" in prim]
    kept = [prim for i, prim in enumerate(kept) if i not in around[:-1]]
    text = head + "".join(kept)
    return text, [found.groups() for found in SHADER.finditer(text)]


def shader_options(folder, below, shaders):
    """Writes shaders into files, equal ones once, and returns the options that name them."""
    os.makedirs(os.path.join(folder, below), exist_ok=True)
    files, options = {}, []
    for place, name, text in shaders:
        if text not in files:
            files[text] = f"{below}/{name}.osl"
            write_whole(os.path.join(folder, files[text]), text)
        path = files[text]
        options += {
            "look": ["--shader", f"{name}={path}"],
            "light": ["--shader", path],
            "environment": ["--environment", path],
        }[place]
    return options
