# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the Render workbench as surface shaders, one for each object."""

import math
import os

from . import stage

#: The parameters of each material, in the order of its function in `materials.h`, with their type.
KINDS = {
    "Diffuse": [("color", "color")],
    "Glass": [("color", "color"), ("float", "ior")],
    "Mixed": [("color", "diffuse.color"), ("color", "glass.color"), ("float", "glass.ior"), ("float", "transparency")],
    "Carpaint": [("color", "basecolor")],
    "Substance_PBR": [("color", "basecolor"), ("float", "roughness"), ("float", "metallic"), ("float", "specular")],
    "Emission": [("color", "color"), ("float", "power")],
    "Disney": [("color", "basecolor")]
    + [
        ("float", name)
        for name in (
            "subsurface metallic specular speculartint roughness anisotropic sheen sheentint clearcoat clearcoatgloss"
        ).split()
    ],
}


def _is_texture(value):
    return hasattr(value, "is_texture")


def _find(values, path):
    for part in path.split("."):
        values = getattr(values, part, None)
    return values


def _color(value):
    return tuple(value.to_linear(precise=True)[:3])


def _number(value):
    value = float(value)
    return f"{value:.9g}" if math.isfinite(value) else "0"


class _Writer:
    """Statements of one shader."""

    def __init__(self, name, warn):
        self.name, self.warn, self.lines, self.count = name, warn, [], 0

    def sample(self, kind, texture, is_data):
        """A variable with a texture's value, or `None` without a file."""
        path = os.path.abspath(str(texture.file or "")).replace(os.sep, "/")
        if not os.path.isfile(path) or any(sign in path for sign in "\"'\\"):
            self.warn(f"'{self.name}': texture '{texture.file}' is missing or has an invalid name")
            return None
        self.count += 1
        numbers = (texture.scale, math.radians(texture.rotation), texture.translation_u, texture.translation_v)
        self.lines.append(
            f"point q{self.count} = fc_place (u, v, {', '.join(_number(x) for x in numbers)});"
        )
        space = ', "colorspace", "linear"' if is_data else ""
        at = f"q{self.count}[0], 1 - q{self.count}[1]"
        self.lines.append(f'{kind} t{self.count} = texture ("{path}", {at}, "wrap", "periodic"{space});')
        return f"t{self.count}"

    def value(self, kind, value):
        """An expression for a parameter: a literal or a variable."""
        if _is_texture(value):
            if variable := self.sample(kind, value, is_data=kind == "float"):
                return variable
            value = value.fallback
            if value is None:
                return "color (0.8)" if kind == "color" else "0.5"
        if kind == "color":
            return f"color ({', '.join(_number(x) for x in _color(value))})"
        return _number(value or 0.0)

    def normal(self, shader):
        """Statements for the normal: a normal map, then bumps."""
        self.lines.append("vector n = N;")
        normal, bump = _find(shader, "normal"), _find(shader, "bump")
        if _is_texture(normal) and (map_ := self.sample("color", normal, is_data=True)):
            strength = _number(1.0 if normal.scalar is None else normal.scalar)
            turn = _number(math.radians(normal.rotation))
            self.lines.append(f"n = fc_normal (n, {map_}, {strength}, {turn}, dPdu, dPdv);")
        if _is_texture(bump) and (height := self.sample("float", bump, is_data=True)):
            factor = _number(1.0 if bump.scalar is None else bump.scalar)
            self.lines.append(f"n = normalize (n + normalize (calculatenormal (P + {factor} * {height} * N)) - Ng);")
        if _is_texture(_find(shader, "displacement")):
            self.warn(f"'{self.name}': displacement is unsupported")


def shader(name, material, warn):
    """The text of a material's shader, and the colour that stands for it elsewhere."""
    kind, values = material.shadertype, material.shader
    plain = material.default_color
    if _is_texture(plain):
        plain = plain.fallback
    plain = _color(plain) if hasattr(plain, "to_linear") else (0.8, 0.8, 0.8)
    if kind == "Passthrough":
        return values.string.format(n=name, c=plain, tex=material.passthrough_texture), plain
    if kind not in KINDS:
        warn(f"'{name}': unknown material type '{kind}'; shown as Diffuse")
        arguments, function = [f"color ({', '.join(map(_number, plain))})"], "diffuse"
    writer = _Writer(name, warn)
    writer.normal(values)
    if kind in KINDS:
        function = kind.lower()
        arguments = [writer.value(type_, _find(values, path)) for type_, path in KINDS[kind]]
    with open(os.path.join(os.path.dirname(__file__), "materials.h"), encoding="utf-8") as file:
        header = file.read()
    body = "".join(f"    {line}\n" for line in writer.lines)
    call = ", ".join(["n", "normalize (dPdu)", *arguments])
    return f"{header}surface {name}_look ()\n{{\n{body}    Ci = fc_{function} ({call});\n}}\n", plain
