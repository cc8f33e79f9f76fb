# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that read pictures: images by every projection, and surroundings."""

from .. import skies
from .tree import node, number

WRAPS = {"REPEAT": "periodic", "EXTEND": "clamp", "CLIP": "clamp", "MIRROR": "mirror"}
MISSING = "color(1, 0, 1)"


def read(p, name, uv, color, alpha, extension):
    """A statement that reads a picture at a point without filtering, as Cycles does; of tiles the one of the point's unit square."""
    if not isinstance(name, dict):
        read_one(p, name, uv, color, alpha, extension)
        return
    square = p.var("vector", f"vector(floor({uv}[0]), floor({uv}[1]), 0)")
    number, inner = p.code.fresh(), p.var("vector", f"{uv} - {square}")
    # Ten in a row; beyond them there is none.
    p.code.line(f"int {number} = ({square}[0] < 0.0 || {square}[0] > 9.0) ? 0 : 1001 + int({square}[0]) + 10 * int({square}[1]);")
    p.code.line(f"color {color} = {MISSING}; {alpha} = 1.0;")
    for tile, picture in name.items():
        own, own_alpha = p.code.fresh(), p.code.fresh()
        p.code.line(f"if ({number} == {tile}) {{ float {own_alpha} = 1.0;")
        read_one(p, picture, inner, own, own_alpha, extension)
        p.code.line(f"{color} = {own}; {alpha} = {own_alpha}; }}")


def read_one(p, name, uv, color, alpha, extension):
    name, is_coded, (width, height) = name
    wrap = WRAPS[extension]

    def tap(at, color, alpha):
        p.code.line(
            f'{color} = texture("{name}", {at}[0], 1.0 - {at}[1], 0.0, 0.0, 0.0, 0.0, "wrap", "{wrap}", "interp", "{interp}", "alpha", {alpha});'
        )

    interp = "closest" if p.interpolation == "Closest" else "bilinear"
    p.code.line(f"color {color}; {alpha} = 1.0;")
    if p.interpolation in {"Cubic", "Smart"}:
        # A cubic B-spline by four linear taps.
        p.need("projections")
        places, shares, sum_of_alpha = p.code.fresh(), p.code.fresh(), p.code.fresh()
        p.code.line(f"vector {places}[4]; float {shares}[4]; float {sum_of_alpha} = 0.0; color {color}_sum = color(0);")
        p.code.line(f"b_spline_taps({uv}, {width}, {height}, {places}, {shares});")
        p.code.line(f"for (int i = 0; i < 4; i += 1) {{ vector at = {places}[i];")
        tap("at", color, alpha)
        p.code.line(f"{color}_sum += {shares}[i] * {color}; {sum_of_alpha} += {shares}[i] * {alpha}; }}")
        p.code.line(f"{color} = {color}_sum; {alpha} = {sum_of_alpha};")
    else:
        tap(uv, color, alpha)
    if extension == "CLIP" and interp == "bilinear":
        # There is nothing beyond the border, and half of it at the border.
        edge = p.var(
            "float",
            f"clamp({uv}[0] * {width} + 0.5, 0.0, 1.0) * clamp((1.0 - {uv}[0]) * {width} + 0.5, 0.0, 1.0)"
            f" * clamp({uv}[1] * {height} + 0.5, 0.0, 1.0) * clamp((1.0 - {uv}[1]) * {height} + 0.5, 0.0, 1.0)",
        )
        p.code.line(f"{color} *= {edge}; {alpha} *= {edge};")
    if is_coded:
        p.need("srgb")
        p.code.line(f"{color} = b_decoded({color});")
    if extension == "CLIP":
        p.code.line(f"if ({uv}[0] < 0.0 || {uv}[0] > 1.0 || {uv}[1] < 0.0 || {uv}[1] > 1.0) {{ {color} = color(0); {alpha} = 0.0; }}")


@node("TEX_IMAGE")
def image_texture(p):
    p.need("projections")
    if p.image is None:
        return {"Color": ("color", "color(0)"), "Alpha": ("float", "1.0")}
    if p.projection != "FLAT" and not p.is_linked("Vector"):
        at = p.mapped(p.generated())
    elif p.is_linked("Vector"):
        at = p.mapped(p.v("Vector"))
    else:
        from .inputs import uv

        at = p.mapped(uv(p.code, "") if p.code.kind == "surface" else p.generated())
    name = p.code.tiles(p.image) if p.image.source == "TILED" else p.code.texture(p.image, p.image_user)
    if not name:
        return {"Color": ("color", MISSING), "Alpha": ("float", "1.0")}
    at = p.var("vector", at)
    color, alpha = p.code.fresh(), p.code.fresh()
    p.code.line(f"float {alpha} = 1.0;")
    if p.projection == "BOX":
        return box(p, name, at, color, alpha)
    if p.projection in {"SPHERE", "TUBE"}:
        at = p.var("vector", f"b_{p.projection.lower()}({at})")
    read(p, name, at, color, alpha, p.extension)
    return {"Color": ("color", color), "Alpha": ("float", alpha)}


def box(p, name, at, color, alpha):
    """Three views along the axes of the object, mixed at the edges."""
    n = p.var("vector", 'vector(normalize(transform("object", N)))')
    n = p.var("vector", f"backfacing() ? -{n} : {n}")
    weights = p.var("vector", f"b_box_weights({n}, {number(p.projection_blend)})")
    views = (
        f"vector(({n}[0] < 0.0) ? 1.0 - {at}[1] : {at}[1], {at}[2], 0)",
        f"vector(({n}[1] > 0.0) ? 1.0 - {at}[0] : {at}[0], {at}[2], 0)",
        f"vector(({n}[2] > 0.0) ? 1.0 - {at}[1] : {at}[1], {at}[0], 0)",
    )
    p.code.line(f"color {color} = color(0); {alpha} = 0.0;")
    for axis, view in enumerate(views):
        uv, own, own_alpha = p.var("vector", view), p.code.fresh(), p.code.fresh()
        p.code.line(f"float {own_alpha} = 1.0;")
        read(p, name, uv, own, own_alpha, p.extension)
        p.code.line(f"{color} += {weights}[{axis}] * {own}; {alpha} += {weights}[{axis}] * {own_alpha};")
    return {"Color": ("color", color), "Alpha": ("float", alpha)}


@node("TEX_ENVIRONMENT")
def environment_texture(p):
    p.need("projections")
    if p.image is None:
        return {"Color": ("color", "color(0)")}
    name = p.code.texture(p.image, p.image_user)
    if name is None:
        return {"Color": ("color", MISSING)}
    if p.is_linked("Vector"):
        at = p.mapped(p.v("Vector"))
    else:
        at = p.mapped("vector(normalize(I))" if p.code.kind == "environment" else "vector(P)")
    made = "b_equirectangular" if p.projection == "EQUIRECTANGULAR" else "b_mirror_ball"
    uv = p.var("vector", f"{made}({at})")
    color, alpha = p.code.fresh(), p.code.fresh()
    p.code.line(f"float {alpha} = 1.0;")
    read(p, name, uv, color, alpha, "REPEAT" if p.projection == "EQUIRECTANGULAR" else "EXTEND")
    return {"Color": ("color", color)}


@node("TEX_SKY")
def sky_texture(p):
    at = p.mapped(p.v("Vector") if p.is_linked("Vector") else "vector(normalize(I))")
    sky = skies.of_node(p.node)
    if sky is not None:
        p.need("projections")
        name = p.code.made_texture(sky.key(), sky.picture_with_disc)
        uv, color = p.var("vector", f"b_of_sky({at})"), p.code.fresh()
        p.code.line(
            f'color {color} = texture("{name}", {uv}[0], 1.0 - {uv}[1], 0.0, 0.0, 0.0, 0.0, "swrap", "periodic", "twrap", "clamp", "interp", "bilinear");'
        )
        return {"Color": ("color", color)}
    p.need("sky")
    if p.sky_type != "PREETHAM":
        p.warn(f"the sky of type {p.sky_type} is shown as Preetham's sky, without a sun disc")
    direction = f"vector({', '.join(number(x) for x in p.sun_direction)})"
    return {"Color": ("color", f"b_preetham({at}, {direction}, {number(p.turbidity)})")}


@node("TEX_POINTDENSITY")
def point_density(p):
    p.warn("point densities are not shown")
    return {}
