# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that read the path of a ray, and nodes that send rays of their own."""

from .inputs import camera_distance
from .tree import node

# Outputs of Light Path by attributes of the shading language.
DEPTHS = {
    "Ray Depth": "path:ray_depth",
    "Diffuse Depth": "path:diffuse_depth",
    "Glossy Depth": "path:glossy_depth",
    "Transmission Depth": "path:transmission_depth",
    "Transparent Depth": "path:transparent_depth",
}


def queried(code, kind, name):
    """A variable with the value of an attribute of the renderer."""
    found = code.fresh()
    code.line(f'{kind} {found} = 0; getattribute("{name}", {found});')
    return found


@node("LIGHT_PATH")
def light_path(p):
    code = p.code
    wanted = {link.from_socket.identifier for output in p.node.outputs for link in output.links}
    reflection = 'raytype("reflection")'
    made = {
        "Is Camera Ray": 'float(raytype("camera"))',
        "Is Shadow Ray": 'float(raytype("shadow"))',
        "Is Diffuse Ray": 'float(raytype("diffuse"))',
        "Is Glossy Ray": f'float(raytype("glossy") || {reflection})',
        "Is Singular Ray": f"float({reflection})",
        "Is Reflection Ray": f'float(raytype("diffuse") || raytype("glossy") || {reflection})',
        "Is Transmission Ray": 'float(raytype("refraction"))',
        "Is Volume Scatter Ray": "0.0",
        "Portal Depth": "0.0",
    }
    if code.kind == "surface":
        for name in wanted & set(DEPTHS):
            made[name] = f"float({queried(code, 'int', DEPTHS[name])})"
        if "Ray Length" in wanted:
            # Rays of the camera begin at its near plane, and go on behind transparent surfaces.
            made["Ray Length"] = f'raytype("camera") ? {camera_distance(code)} : {queried(code, "float", "path:ray_length")}'
        return {name: ("float", expression) for name, expression in made.items()}
    made |= {
        "Ray Depth": 'float(!raytype("camera") && !raytype("shadow"))',
        "Diffuse Depth": 'float(raytype("diffuse"))',
        "Glossy Depth": f'float(raytype("glossy") || {reflection})',
        "Transmission Depth": 'float(raytype("refraction"))',
        "Transparent Depth": "0.0",
        "Ray Length": "0.0",
    }
    for name in wanted & set(DEPTHS):
        p.warn(f"output '{name}' knows the last ray only where it is not at a surface")
    return {name: ("float", expression) for name, expression in made.items()}


@node("AMBIENT_OCCLUSION")
def ambient_occlusion(p):
    if p.code.kind != "surface":
        return {"Color": ("color", p.c("Color")), "AO": ("float", "1.0")}
    p.need("occlusion")
    only = f'"{p.code.host.own_set(p.code)}"' if p.only_local else '""'
    ao = p.var("float", f"b_occlusion(P, {p.normal()}, {p.f('Distance')}, {p.samples}, {int(p.inside)}, {only})")
    return {"Color": ("color", f"{p.c('Color')} * {ao}"), "AO": ("float", ao)}


@node("BEVEL")
def bevel(p):
    if p.code.kind != "surface":
        return {"Normal": ("vector", p.normal())}
    p.need("bevel")
    only = p.code.host.own_set(p.code)
    made = p.var("vector", f'b_bevel(P, N, Ng, backfacing(), {p.f("Radius")}, {p.samples}, "{only}")')
    if p.is_linked("Normal"):
        # Bumps are added to the rounded edge.
        made = f"normalize({made} + {p.normal()} - N)"
    return {"Normal": ("vector", made)}
