# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that change colours."""

from .rays import queried
from .tree import node


@node("HUE_SAT")
def hue_saturation(p):
    p.need("hsv", "colors")
    color, factor = p.var("color", p.c("Color")), p.f("Fac")
    return {"Color": ("color", f"b_hue_saturation({color}, {p.f('Hue')}, {p.f('Saturation')}, {p.f('Value')}, {factor})")}


@node("BRIGHTCONTRAST")
def bright_contrast(p):
    p.need("colors")
    return {"Color": ("color", f"b_bright_contrast({p.c('Color')}, {p.f('Bright')}, {p.f('Contrast')})")}


@node("GAMMA")
def gamma(p):
    p.need("colors")
    return {"Color": ("color", f"b_gamma({p.c('Color')}, {p.f('Gamma')})")}


@node("INVERT")
def invert(p):
    color = p.var("color", p.c("Color"))
    return {"Color": ("color", f"mix({color}, color(1) - {color}, {p.f('Fac')})")}


@node("LIGHT_FALLOFF")
def light_falloff(p):
    strength = p.var("float", p.f("Strength"))
    if p.code.kind != "surface":
        return {name: ("float", strength) for name in ("Quadratic", "Linear", "Constant")}
    # Lamps are surfaces here: the light falls with the square of the length of the ray by itself.
    length = queried(p.code, "float", "path:ray_length")
    if not p.is_constant("Smooth", 0.0):
        strength = p.var("float", f"{strength} * {length} * {length} / (max({p.f('Smooth')}, 0.0) + {length} * {length})")
    return {
        "Quadratic": ("float", strength),
        "Linear": ("float", f"{strength} * {length}"),
        "Constant": ("float", f"{strength} * {length} * {length}"),
    }
