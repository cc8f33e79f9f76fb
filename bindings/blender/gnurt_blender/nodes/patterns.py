# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that make patterns: noises, Voronoi's cells, waves, bricks, checkers, gradients, magic."""

from .tree import node, number
from .voronoi import functions

DIMENSIONS = {"1D": 1, "2D": 2, "3D": 3, "4D": 4}


def place_in(p, dimensions):
    """The arguments of a function of this many dimensions: x, y, z in a vector, and w."""
    at = p.coordinates() if dimensions > 1 else "vector(0)"
    w = p.f("W") if dimensions in {1, 4} else "0.0"
    return p.var("vector", at), p.var("float", w)


def given(dimensions, at, w):
    return {1: w, 2: f"{at}[0], {at}[1]", 3: at, 4: f"{at}, {w}"}[dimensions]


@node("TEX_NOISE")
def noise(p):
    dimensions = DIMENSIONS[p.noise_dimensions]
    p.need(f"noise{dimensions}")
    at, w = place_in(p, dimensions)
    scale = p.var("float", p.f("Scale"))
    if dimensions > 1:
        at = p.var("vector", f"{at} * {scale}")
    if dimensions in {1, 4}:
        w = p.var("float", f"{w} * {scale}")
    detail = f"clamp({p.f('Detail')}, 0.0, 15.0)"
    numbers = [detail, f"max({p.f('Roughness')}, 0.0)", p.f("Lacunarity"), p.f("Offset"), p.f("Gain"), p.f("Distortion")]
    wanted = {link.from_socket.identifier for output in p.node.outputs for link in output.links}
    value, color = p.code.fresh(), p.code.fresh()
    p.code.line(f"float {value}; color {color};")
    p.code.line(
        f"b_noise{dimensions}({given(dimensions, at, w)}, {', '.join(numbers)}, "
        f'"{p.noise_type}", {int(p.normalize)}, {int("Color" in wanted)}, {value}, {color});'
    )
    return {"Fac": ("float", value), "Color": ("color", color)}


@node("TEX_WHITE_NOISE")
def white_noise(p):
    dimensions = DIMENSIONS[p.noise_dimensions]
    p.need("hash")
    at, w = place_in(p, dimensions)
    args = given(dimensions, at, w)
    return {"Value": ("float", f"b_hash{dimensions}({args})"), "Color": ("color", f"b_hash{dimensions}c({args})")}


@node("TEX_VORONOI")
def voronoi(p):
    dimensions = DIMENSIONS[p.voronoi_dimensions]
    p.need("hash", "cells")
    feature = p.feature
    smoothness = p.var("float", f"clamp(0.5 * {p.f('Smoothness')}, 0.0, 0.5)")
    name = functions(p.code, dimensions, feature)
    at, w = place_in(p, dimensions)
    scale = p.var("float", p.f("Scale"))
    point = {1: f"vector({w}, 0, 0)", 2: f"vector({at}[0], {at}[1], 0)", 3: at, 4: at}[dimensions]
    distance, color, where, other = (p.code.fresh() for _ in range(4))
    p.code.line(f"float {distance}; color {color}; vector {where}; float {other};")
    numbers = [
        f"clamp({p.f('Detail')}, 0.0, 15.0)",
        f"clamp({p.f('Roughness')}, 0.0, 1.0)",
        p.f("Lacunarity"),
        smoothness,
        p.f("Exponent"),
        f"clamp({p.f('Randomness')}, 0.0, 1.0)",
    ]
    p.code.line(
        f"{name}({point} * {scale}, {w if dimensions == 4 else '0.0'} * {scale}, {', '.join(numbers)}, "
        f'"{p.distance}", {int(p.normalize)}, {distance}, {color}, {where}, {other});'
    )
    back = f"(({scale} != 0.0) ? 1.0 / {scale} : 0.0)"
    if dimensions == 1:
        made = {"Position": ("vector", "vector(0)"), "W": ("float", f"{where}[0] * {back}")}
    else:
        made = {"Position": ("vector", f"{where} * {back}"), "W": ("float", f"{other} * {back}")}
    made |= {"Distance": ("float", distance), "Color": ("color", color), "Radius": ("float", distance)}
    return made


@node("TEX_WAVE")
def wave(p):
    p.need("wave")
    at = p.var("vector", f"{p.coordinates()} * {p.f('Scale')}")
    direction = p.bands_direction if p.wave_type == "BANDS" else p.rings_direction
    numbers = ", ".join(p.f(name) for name in ("Distortion", "Detail", "Detail Scale", "Detail Roughness", "Phase Offset"))
    value = p.var("float", f'b_wave({at}, "{p.wave_type}", "{direction}", "{p.wave_profile}", {numbers})')
    return {"Color": ("color", f"color({value})"), "Fac": ("float", value)}


@node("TEX_CHECKER")
def checker(p):
    p.need("simple_patterns")
    value = p.var("float", f"b_checker({p.coordinates()} * {p.f('Scale')})")
    return {"Color": ("color", f"({value} == 1.0) ? {p.c('Color1')} : {p.c('Color2')}"), "Fac": ("float", value)}


@node("TEX_GRADIENT")
def gradient(p):
    p.need("simple_patterns")
    value = p.var("float", f'b_gradient({p.coordinates()}, "{p.gradient_type}")')
    return {"Color": ("color", f"color({value})"), "Fac": ("float", value)}


@node("TEX_MAGIC")
def magic(p):
    p.need("simple_patterns")
    color = p.var("color", f"b_magic({p.coordinates()} * {p.f('Scale')}, {p.turbulence_depth}, {p.f('Distortion')})")
    return {"Color": ("color", color), "Fac": ("float", f"({color}[0] + {color}[1] + {color}[2]) / 3.0")}


@node("TEX_BRICK")
def brick(p):
    p.need("brick")
    tint, mortar = p.code.fresh(), p.code.fresh()
    p.code.line(f"float {tint}, {mortar};")
    p.code.line(
        f"b_brick({p.coordinates()} * {p.f('Scale')}, {p.f('Mortar Size')}, {p.f('Mortar Smooth')}, {p.f('Bias')}, "
        f"{p.f('Brick Width')}, {p.f('Row Height')}, {number(p.offset)}, {p.offset_frequency}, {number(p.squash)}, "
        f"{p.squash_frequency}, {tint}, {mortar});"
    )
    body = f"mix({p.c('Color1')}, {p.c('Color2')}, {tint})"
    return {"Color": ("color", f"mix({body}, {p.c('Mortar')}, {mortar})"), "Fac": ("float", mortar)}


