# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that read the surroundings of a point: coordinates, geometry, objects, attributes, angles to the viewer."""

from .tree import node, number, triple


def in_object(code):
    """The position in the space of the object."""
    return code.var("vector", 'vector(transform("object", P))') if code.kind == "surface" else "vector(I)"


def matrix(rows):
    """A matrix of the shading language from one of Blender, which has points as columns."""
    return "matrix(" + ", ".join(number(rows[r][c]) for c in range(4) for r in range(4)) + ")"


@node("TEX_COORD")
def texture_coordinates(p):
    code = p.code
    if code.kind == "environment":
        d = "vector(normalize(I))"
        made = dict.fromkeys(("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"), ("vector", d))
        made["Normal"] = ("vector", f"-{d}")
        made["UV"] = ("vector", "vector(0)")
        return made
    if p.from_instancer:
        p.warn("coordinates of the instancer are not shown")
    made = {}
    wanted = {link.from_socket.identifier for output in p.node.outputs for link in output.links}
    if "Generated" in wanted:
        made["Generated"] = ("vector", p.generated())
    if "Normal" in wanted:
        made["Normal"] = ("vector", 'vector(normalize(transform("object", N)))')
    if "UV" in wanted:
        made["UV"] = ("vector", uv(code, ""))
    if "Object" in wanted:
        other = p.node.object
        own = in_object(code)
        if other is not None:
            own = f"vector(transform({matrix(code.host.inverse_of(other))}, P))"
        made["Object"] = ("vector", own)
    if "Camera" in wanted:
        made["Camera"] = ("vector", camera_space(code))
    if "Window" in wanted:
        made["Window"] = ("vector", window(code))
    if "Reflection" in wanted:
        made["Reflection"] = ("vector", "vector(reflect(I, N))")
    return made


def uv(code, name):
    """Texture coordinates by name; those that are rendered without one."""
    if code.kind != "surface":
        return "vector(0)"
    if not name:
        return "vector(u, v, 0)"
    return code.attribute("vector", f"uv:{name}")


def camera_space(code):
    rows = code.host.camera_from_world()
    flipped = [[x * sign for x in row] for row, sign in zip(rows, (1, 1, -1, 1))]
    return f"vector(transform({matrix(flipped)}, P))"


def window(code):
    rows = code.host.window_from_world()
    at = code.var("vector", f"vector(transform({matrix(rows)}, P))")
    return f"vector({at}[0], {at}[1], 0)"


@node("UVMAP")
def uv_map(p):
    return {"UV": ("vector", uv(p.code, p.uv_map))}


@node("NEW_GEOMETRY")
def geometry(p):
    code = p.code
    if code.kind == "environment":
        d = "vector(normalize(I))"
        return {
            "Position": ("vector", d),
            "Normal": ("vector", f"-{d}"),
            "Tangent": ("vector", "vector(0)"),
            "True Normal": ("vector", f"-{d}"),
            "Incoming": ("vector", f"-{d}"),
            "Parametric": ("vector", "vector(0)"),
            "Backfacing": ("float", "0.0"),
            "Pointiness": ("float", "0.0"),
            "Random Per Island": ("float", "0.0"),
        }
    wanted = {link.from_socket.identifier for output in p.node.outputs for link in output.links}
    made = {
        "Position": ("vector", "vector(P)"),
        "Normal": ("vector", "vector(N)"),
        "True Normal": ("vector", "vector(Ng)"),
        "Incoming": ("vector", "vector(-I)"),
        "Backfacing": ("float", "float(backfacing())"),
    }
    if code.moves and "Position" in wanted:
        code.uses_object = True
        made["Position"] = ("vector", f"vector(transform({matrix(code.host.world_from_object())}, P))")
    if "Tangent" in wanted:
        made["Tangent"] = ("vector", radial_tangent(code, "Z"))
    if "Parametric" in wanted:
        made["Parametric"] = ("vector", code.attribute("vector", "parametric"))
    if "Pointiness" in wanted:
        made["Pointiness"] = ("float", code.attribute("float", "pointiness"))
    if "Random Per Island" in wanted:
        made["Random Per Island"] = ("float", code.attribute("float", "island"))
    return made


def radial_tangent(code, axis):
    """Around an axis of the object through the middle of its box."""
    own = code.var("vector", f"{code.host.generated(code)} - vector(0.5)")
    turned = {
        "X": f"vector(0, -{own}[2], {own}[1])",
        "Y": f"vector(-{own}[2], 0, {own}[0])",
        "Z": f"vector(-{own}[1], {own}[0], 0)",
    }[axis]
    around = code.var("vector", f'vector(transform("object", "world", {turned}))')
    return code.var("vector", f"normalize(cross(N, normalize(cross({around}, N))))")


def uv_tangent(code, name):
    """The direction in which u grows."""
    if not name or code.host.is_active_uv(name):
        return code.var("vector", "normalize(dPdu - dot(dPdu, N) * N)")
    return code.attribute("vector", f"tangent:{name}")


@node("TANGENT")
def tangent(p):
    if p.code.kind == "environment":
        return {"Tangent": ("vector", "vector(0)")}
    made = uv_tangent(p.code, p.uv_map) if p.direction_type == "UV_MAP" else radial_tangent(p.code, p.axis)
    return {"Tangent": ("vector", made)}


@node("OBJECT_INFO")
def object_info(p):
    code = p.code
    if code.kind == "environment":
        return {}
    wanted = {link.from_socket.identifier for output in p.node.outputs for link in output.links}
    made = {
        "Location": ("vector", 'vector(transform("object", "world", point(0)))'),
        "Material Index": ("float", number(code.host.material_index())),
    }
    if wanted & {"Color", "Alpha", "Object Index", "Random"}:
        code.uses_object = True
        color, alpha, index, random = code.host.object_values()
        made["Color"] = ("color", triple("color", color))
        made["Alpha"] = ("float", number(alpha))
        made["Object Index"] = ("float", number(index))
        made["Random"] = ("float", number(random))
    return made


def camera_distance(code):
    # Rays begin at the near plane.
    at = code.var("vector", camera_space(code))
    near = number(code.host.near())
    return f"({at}[2] - {near})" if code.host.is_orthographic() else f"(length({at}) * (1.0 - {near} / max({at}[2], 1e-6)))"


@node("CAMERA")
def camera_data(p):
    if p.code.kind == "environment":
        return {"View Vector": ("vector", "vector(normalize(I))"), "View Z Depth": ("float", "0.0"), "View Distance": ("float", "0.0")}
    at = p.var("vector", camera_space(p.code))
    return {
        "View Vector": ("vector", f"normalize({at})"),
        "View Z Depth": ("float", f"fabs({at}[2])"),
        "View Distance": ("float", f"length({at})"),
    }


@node("ATTRIBUTE")
def attribute(p):
    code, name = p.code, p.attribute_name
    if p.attribute_type == "GEOMETRY" and code.kind == "surface":
        color = code.attribute("color", f"named:{name}")
        return {
            "Color": ("color", color),
            "Vector": ("vector", f"vector({color}[0], {color}[1], {color}[2])"),
            "Fac": ("float", code.attribute("float", f"mean:{name}")),
            "Alpha": ("float", code.attribute("float", f"alpha:{name}")),
        }
    if p.attribute_type != "GEOMETRY":
        code.uses_object = p.attribute_type in {"OBJECT", "INSTANCER"} or code.uses_object
        value, alpha = code.host.property_of(p.attribute_type, name)
        color = triple("color", value)
        return {
            "Color": ("color", color),
            "Vector": ("vector", triple("vector", value)),
            "Fac": ("float", number(sum(value) / 3)),
            "Alpha": ("float", number(alpha)),
        }
    return {}


@node("VERTEX_COLOR")
def color_attribute(p):
    code = p.code
    if code.kind != "surface":
        return {}
    name = p.layer_name
    return {"Color": ("color", code.attribute("color", f"color:{name}")), "Alpha": ("float", code.attribute("float", f"coloralpha:{name}"))}


@node("FRESNEL")
def fresnel(p):
    p.need("fresnel")
    if p.code.kind == "environment":
        return {"Fac": ("float", "0.0")}
    n = p.var("vector", p.normal())
    return {"Fac": ("float", f"b_fresnel_node({p.f('IOR')}, {n}, I, backfacing())")}


@node("LAYER_WEIGHT")
def layer_weight(p):
    p.need("fresnel")
    if p.code.kind == "environment":
        return {}
    n, blend = p.var("vector", p.normal()), p.var("float", p.f("Blend"))
    return {
        "Fresnel": ("float", f"b_layer_fresnel({blend}, {n}, I, backfacing())"),
        "Facing": ("float", f"b_layer_facing({blend}, {n}, I)"),
    }


@node("VALUE")
def value(p):
    return {"Value": ("float", number(p.node.outputs[0].default_value))}


@node("RGB")
def rgb(p):
    return {"Color": ("color", triple("color", p.node.outputs[0].default_value))}


@node("WIREFRAME")
def wireframe(p):
    if p.code.kind == "environment":
        return {}
    p.need("wire")
    if p.use_pixel_size:
        p.warn("sizes in pixels are not shown; the size is in world units")
    bars = p.code.attribute("vector", "bars")
    return {"Fac": ("float", f"b_wire({bars}, {p.f('Size')})")}


@node("HAIR_INFO")
def hair_info(p):
    code = p.code
    if code.kind == "environment":
        return {}
    made = {name: ("float", code.attribute("float", f"hair:{name}")) for name in ("Is Strand", "Intercept", "Length", "Thickness", "Random")}
    made["Tangent Normal"] = ("vector", code.attribute("vector", "hair:Tangent Normal"))
    return made


@node("POINT_INFO")
def point_info(p):
    code = p.code
    if code.kind == "environment":
        return {}
    # Positions are those of the world.
    center = f'vector(transform("object", "world", point({code.attribute("vector", "point:Position")})))'
    return {"Position": ("vector", center)} | {name: ("float", code.attribute("float", f"point:{name}")) for name in ("Radius", "Random")}


@node("PARTICLE_INFO")
def particle_info(p):
    code = p.code
    code.uses_object = True
    values = code.host.particle()
    if values is None:
        return {}
    return {name: ("vector", triple("vector", x)) if hasattr(x, "__len__") else ("float", number(x)) for name, x in values.items()}
