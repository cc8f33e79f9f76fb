# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of vectors: arithmetic, mapping, rotation, spaces, and those that turn normals."""

from .inputs import matrix, uv_tangent
from .tree import node, triple

VECTOR_MATH = {
    "ADD": "{a} + {b}",
    "SUBTRACT": "{a} - {b}",
    "MULTIPLY": "{a} * {b}",
    "DIVIDE": "{a} / {b}",
    "MULTIPLY_ADD": "{a} * {b} + {c}",
    "CROSS_PRODUCT": "cross({a}, {b})",
    "PROJECT": "b_project({a}, {b})",
    "REFLECT": "reflect({a}, b_unit({b}))",
    "REFRACT": "refract({a}, b_unit({b}), {scale})",
    "FACEFORWARD": "(dot({b}, {c}) < 0.0 ? {a} : -{a})",
    "SCALE": "{a} * {scale}",
    "NORMALIZE": "b_unit({a})",
    "ABSOLUTE": "fabs({a})",
    "POWER": "vector(b_pow({a}[0], {b}[0]), b_pow({a}[1], {b}[1]), b_pow({a}[2], {b}[2]))",
    "SIGN": "sign({a})",
    "MINIMUM": "min({a}, {b})",
    "MAXIMUM": "max({a}, {b})",
    "FLOOR": "floor({a})",
    "CEIL": "ceil({a})",
    "FRACTION": "{a} - floor({a})",
    "MODULO": "vector(b_fmod({a}[0], {b}[0]), b_fmod({a}[1], {b}[1]), b_fmod({a}[2], {b}[2]))",
    "WRAP": "vector(b_wrap({a}[0], {b}[0], {c}[0]), b_wrap({a}[1], {b}[1], {c}[1]), b_wrap({a}[2], {b}[2], {c}[2]))",
    "SNAP": "floor({a} / {b}) * {b}",
    "SINE": "sin({a})",
    "COSINE": "cos({a})",
    "TANGENT": "tan({a})",
}
VALUES = {"DOT_PRODUCT": "dot({a}, {b})", "DISTANCE": "length({a} - {b})", "LENGTH": "length({a})"}


@node("VECT_MATH")
def vector_math(p):
    p.need("math", "vectors")
    a, b, c = (p.var("vector", p.v(name)) for name in ("Vector", "Vector_001", "Vector_002"))
    given = {"a": a, "b": b, "c": c, "scale": p.f("Scale")}
    if p.operation in VALUES:
        return {"Value": ("float", VALUES[p.operation].format(**given))}
    return {"Vector": ("vector", VECTOR_MATH[p.operation].format(**given))}


@node("MAPPING")
def mapping(p):
    p.need("vectors")
    v, where, turn, scale = (p.var("vector", p.v(name)) for name in ("Vector", "Location", "Rotation", "Scale"))
    made = {
        "POINT": f"b_turned({v} * {scale}, {turn}) + {where}",
        "TEXTURE": f"b_over(b_turned_back({v} - {where}, {turn}), {scale})",
        "VECTOR": f"b_turned({v} * {scale}, {turn})",
        "NORMAL": f"b_unit(b_turned(b_over({v}, {scale}), {turn}))",
    }
    return {"Vector": ("vector", made[p.vector_type])}


@node("VECTOR_ROTATE")
def vector_rotate(p):
    p.need("vectors")
    v, center = p.var("vector", p.v("Vector")), p.var("vector", p.v("Center"))
    how = p.rotation_type
    if how == "EULER_XYZ":
        turn = p.var("vector", p.v("Rotation"))
        name = "b_turned_back" if p.invert else "b_turned"
        return {"Vector": ("vector", f"{name}({v} - {center}, {turn}) + {center}")}
    axis = {"X_AXIS": "vector(1, 0, 0)", "Y_AXIS": "vector(0, 1, 0)", "Z_AXIS": "vector(0, 0, 1)"}.get(how) or p.v("Axis")
    angle = f"{'-' if p.invert else ''}({p.f('Angle')})"
    return {"Vector": ("vector", f"b_around({v} - {center}, {axis}, {angle}) + {center}")}


@node("VECT_TRANSFORM")
def vector_transform(p):
    code = p.code
    kind = {"POINT": "point", "VECTOR": "vector", "NORMAL": "normal"}[p.vector_type]
    value = p.v("Vector")
    if code.kind == "environment" or p.convert_from == p.convert_to:
        return {"Vector": ("vector", value)}
    camera = [[x * sign for x in row] for row, sign in zip(code.host.camera_from_world(), (1, 1, -1, 1))]
    inverse = [[x * sign for x, sign in zip(row, (1, 1, -1, 1))] for row in code.host.world_from_camera()]
    made = f"{kind}({value})"
    if p.convert_from == "OBJECT":
        made = f'transform("object", "world", {made})'
    elif p.convert_from == "CAMERA":
        made = f"transform({matrix(inverse)}, {made})"
    if p.convert_to == "OBJECT":
        made = f'transform("world", "object", {made})'
    elif p.convert_to == "CAMERA":
        made = f"transform({matrix(camera)}, {made})"
    made = f"vector({made})"
    if p.vector_type == "NORMAL":
        p.need("vectors")
        made = f"b_unit({made})"
    return {"Vector": ("vector", made)}


@node("NORMAL")
def normal(p):
    p.need("vectors")
    own = triple("vector", p.node.outputs[0].default_value)
    own = p.var("vector", f"b_unit({own})")
    return {"Normal": ("vector", own), "Dot": ("float", f"dot({own}, b_unit({p.v('Normal')}))")}


@node("BUMP")
def bump(p):
    p.need("bump")
    n = p.var("vector", p.normal())
    if p.code.kind == "environment" or not p.is_linked("Height"):
        return {"Normal": ("vector", n)}
    height = p.var("float", p.f("Height"))
    sign = "-1.0" if p.invert else "1.0"
    return {"Normal": ("vector", f"b_bump({n}, {height}, Dx({height}), Dy({height}), {sign} * ({p.f('Distance')}), {p.f('Strength')})")}


@node("NORMAL_MAP")
def normal_map(p):
    code = p.code
    p.need("bump", "vectors")
    if code.kind == "environment":
        return {"Normal": ("vector", "N")}
    color, strength = p.var("color", p.c("Color")), p.var("float", f"max({p.f('Strength')}, 0.0)")
    own = p.var("vector", f"2.0 * vector({color}) - vector(1)")
    if p.space == "TANGENT":
        name = p.uv_map or code.host.active_uv()
        if not name:
            p.warn("a normal map in tangent space needs texture coordinates")
            return {"Normal": ("vector", "N")}
        tangent = code.attribute("vector", f"tangent:{name}")
        side = code.attribute("float", f"side:{name}")
        smooth = p.var("vector", f"backfacing() ? -N : N")
        made = p.var("vector", f"b_normal_map({own}, {strength}, {tangent}, {side}, {smooth})")
        return {"Normal": ("vector", f"backfacing() ? -{made} : {made}")}
    if p.space.startswith("BLENDER"):
        own = p.var("vector", f"vector({own}[0], -{own}[1], -{own}[2])")
    if p.space.endswith("OBJECT"):
        own = p.var("vector", f'vector(transform("object", "world", normal({own})))')
    own = p.var("vector", f"b_unit({own})")
    turned = p.var("vector", f"backfacing() ? -{own} : {own}")
    return {"Normal": ("vector", f"({strength} == 1.0) ? {turned} : b_unit(N + ({turned} - N) * {strength})")}


@node("DISPLACEMENT")
def displacement(p):
    height = f"({p.f('Height')} - {p.f('Midlevel')}) * {p.f('Scale')}"
    code = p.code
    if code.relief:
        along = f'normalize(vector(transform("object", normal({p.normal()}))))' if p.is_linked("Normal") else code.relief
    elif code.moves:
        along = f"normalize(vector({p.normal()}))"
    else:
        # `surfaces` turns heights into bumps.
        return {"Displacement": ("vector", f"vector({height})")}
    return {"Displacement": ("vector", moved(p, f"{height} * {along}"))}


@node("VECTOR_DISPLACEMENT")
def vector_displacement(p):
    code = p.code
    offset = p.var("vector", f"(vector({p.c('Vector')}) - vector({p.f('Midlevel')})) * {p.f('Scale')}")
    if p.space != "TANGENT":
        return {"Displacement": ("vector", moved(p, offset))}
    along, other, n = ("dPdu", "dPdv", "vector(N)")
    if code.relief:
        along, other = (p.var("vector", f'vector(transform("object", {each}))') for each in (along, other))
        n = code.relief
    side = f"((dot(cross({n}, {along}), {other}) < 0) ? -1.0 : 1.0)"
    along = p.var("vector", f"normalize({along} - dot({along}, {n}) * {n})")
    across = p.var("vector", f"{side} * cross({n}, {along})")
    return {"Displacement": ("vector", f"({offset}[0] * {along} + {offset}[1] * {n} + {offset}[2] * {across})")}


def moved(p, offset):
    """An offset in the object's space. In that of the world its length is divided by the object's scale."""
    if p.space != "WORLD":
        return offset
    scale = p.code.host.scale()
    if abs(scale - 1.0) < 1e-6:
        return offset
    p.code.uses_object = True
    return f"({offset}) / {scale!r}"
