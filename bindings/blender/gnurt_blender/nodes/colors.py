# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that change colours."""

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
    p.warn("only falloffs of points and spots are shown, directly below their Emission nodes")
    strength = p.var("float", p.f("Strength"))
    return {name: ("float", strength) for name in ("Quadratic", "Linear", "Constant")}
