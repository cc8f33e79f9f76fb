# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of numbers: mathematics, ranges, curves, ramps, mixes, and conversions between numbers, vectors and colours."""

from .tree import node, number, triple

MATH = {
    "ADD": "({a} + {b})",
    "SUBTRACT": "({a} - {b})",
    "MULTIPLY": "({a} * {b})",
    "DIVIDE": "({a} / {b})",
    "MULTIPLY_ADD": "({a} * {b} + {c})",
    "POWER": "b_pow({a}, {b})",
    "LOGARITHM": "b_log({a}, {b})",
    "SQRT": "sqrt(max({a}, 0.0))",
    "INVERSE_SQRT": "inversesqrt(max({a}, 0.0))",
    "ABSOLUTE": "fabs({a})",
    "EXPONENT": "exp({a})",
    "MINIMUM": "min({a}, {b})",
    "MAXIMUM": "max({a}, {b})",
    "LESS_THAN": "float({a} < {b})",
    "GREATER_THAN": "float({a} > {b})",
    "SIGN": "sign({a})",
    "COMPARE": "float({a} == {b} || fabs({a} - {b}) <= max({c}, 1e-5))",
    "SMOOTH_MIN": "b_smooth_min({a}, {b}, {c})",
    "SMOOTH_MAX": "(-b_smooth_min(-({a}), -({b}), {c}))",
    "ROUND": "floor({a} + 0.5)",
    "FLOOR": "floor({a})",
    "CEIL": "ceil({a})",
    "TRUNC": "trunc({a})",
    "FRACT": "({a} - floor({a}))",
    "MODULO": "b_fmod({a}, {b})",
    "FLOORED_MODULO": "b_floored({a}, {b})",
    "WRAP": "b_wrap({a}, {b}, {c})",
    "SNAP": "(floor({a} / {b}) * {b})",
    "PINGPONG": "b_pingpong({a}, {b})",
    "SINE": "sin({a})",
    "COSINE": "cos({a})",
    "TANGENT": "tan({a})",
    "ARCSINE": "asin({a})",
    "ARCCOSINE": "acos({a})",
    "ARCTANGENT": "atan({a})",
    "ARCTAN2": "atan2({a}, {b})",
    "SINH": "sinh({a})",
    "COSH": "cosh({a})",
    "TANH": "tanh({a})",
    "RADIANS": "radians({a})",
    "DEGREES": "degrees({a})",
}


@node("MATH")
def math(p):
    p.need("math")
    a, b, c = (p.var("float", p.f(name)) for name in ("Value", "Value_001", "Value_002"))
    made = MATH[p.operation].format(a=a, b=b, c=c)
    return {"Value": ("float", f"clamp({made}, 0.0, 1.0)" if p.use_clamp else made)}


@node("CLAMP")
def clamp(p):
    value, low, high = (p.var("float", p.f(name)) for name in ("Value", "Min", "Max"))
    if p.clamp_type == "RANGE":
        return {"Result": ("float", f"(({low} > {high}) ? clamp({value}, {high}, {low}) : clamp({value}, {low}, {high}))")}
    return {"Result": ("float", f"min(max({value}, {low}), {high})")}


@node("MAP_RANGE")
def map_range(p):
    p.need("range")
    kind, how = p.data_type, p.interpolation_type
    clamped = int(p.clamp and how in {"LINEAR", "STEPPED"})
    names = ("Value", "From Min", "From Max", "To Min", "To Max", "Steps")
    if kind == "FLOAT_VECTOR":
        names = ("Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Steps_FLOAT3")
        given = [p.var("vector", p.v(name)) for name in names]
        each = [f"b_range({', '.join(f'{x}[{i}]' for x in given)}, \"{how}\", {clamped})" for i in range(3)]
        return {"Vector": ("vector", f"vector({', '.join(each)})")}
    given = ", ".join(p.f(name) for name in names)
    return {"Result": ("float", f'b_range({given}, "{how}", {clamped})')}


def mixed(p, factor, a, b, blend):
    """Two colours by a way of blending; the variable of the result."""
    p.need("blend")
    if blend == "MIX":
        return p.var("color", f"mix({a}, {b}, {factor})")
    return p.var("color", f"b_{blend.lower()}({factor}, {a}, {b})")


@node("MIX_RGB")
def mix_rgb(p):
    factor = p.var("float", f"clamp({p.f('Fac')}, 0.0, 1.0)")
    made = mixed(p, factor, p.var("color", p.c("Color1")), p.var("color", p.c("Color2")), p.blend_type)
    return {"Color": ("color", f"clamp({made}, color(0), color(1))" if p.use_clamp else made)}


@node("MIX")
def mix(p):
    def limited(kind, expression):
        return p.var(kind, f"clamp({expression}, {'0.0, 1.0' if kind == 'float' else f'{kind}(0), {kind}(1)'})" if p.clamp_factor else expression)

    kind = p.data_type
    if kind == "FLOAT":
        factor = limited("float", p.f("Factor_Float"))
        return {"Result_Float": ("float", f"mix({p.f('A_Float')}, {p.f('B_Float')}, {factor})")}
    if kind == "VECTOR":
        factor = limited("vector", p.v("Factor_Vector")) if p.factor_mode == "NON_UNIFORM" else limited("float", p.f("Factor_Float"))
        return {"Result_Vector": ("vector", f"mix({p.v('A_Vector')}, {p.v('B_Vector')}, {factor})")}
    if kind == "RGBA":
        factor = limited("float", p.f("Factor_Float"))
        made = mixed(p, factor, p.var("color", p.c("A_Color")), p.var("color", p.c("B_Color")), p.blend_type)
        return {"Result_Color": ("color", f"clamp({made}, color(0), color(1))" if p.clamp_result else made)}
    p.warn("rotations are not mixed")
    return {}


def stops_at(p, position, elements, how):
    """Statements that find the colour and opacity of a ramp."""
    color, alpha = p.code.fresh(), p.code.fresh()
    p.need("ramp")
    count = len(elements)
    places = ", ".join(number(e.position) for e in elements)
    values = ", ".join(triple("color", e.color) for e in elements)
    alphas = ", ".join(number(e.color[3]) for e in elements)
    p.code.line(f"float {color}_at[{count}] = {{{places}}};")
    p.code.line(f"color {color}_c[{count}] = {{{values}}};")
    p.code.line(f"float {color}_a[{count}] = {{{alphas}}};")
    p.code.line(f"color {color}; float {alpha};")
    p.code.line(f'b_ramp({position}, {color}_at, {color}_c, {color}_a, {count}, "{how}", {color}, {alpha});')
    return color, alpha


@node("VALTORGB")
def color_ramp(p):
    ramp = p.color_ramp
    position = p.var("float", p.f("Fac"))
    elements = sorted(ramp.elements, key=lambda e: e.position)
    if ramp.color_mode == "RGB" and ramp.interpolation in {"LINEAR", "EASE", "CONSTANT", "CARDINAL", "B_SPLINE"}:
        color, alpha = stops_at(p, position, elements, ramp.interpolation)
        return {"Color": ("color", color), "Alpha": ("float", alpha)}
    # Ways around the circle of hues: as a table, which Blender evaluates.
    return table(p, position, [ramp.evaluate(i / 255) for i in range(256)])


def table(p, position, values):
    """A colour and an opacity by linear interpolation in a table."""
    color = p.code.fresh()
    p.need("table")
    count = len(values)
    p.code.line(f"color {color}_c[{count}] = {{{', '.join(triple('color', x) for x in values)}}};")
    p.code.line(f"float {color}_a[{count}] = {{{', '.join(number(x[3]) for x in values)}}};")
    p.code.line(f"color {color} = b_table({position}, {color}_c, {count}); float {color}_alpha = b_table({position}, {color}_a, {count});")
    return {"Color": ("color", color), "Alpha": ("float", f"{color}_alpha")}


def samples_of(mapping, curve, low, high, count):
    return [mapping.evaluate(curve, low + (high - low) * i / (count - 1)) for i in range(count)]


def curve_function(p, mapping, curves, low, high, name):
    """A table of curves as a local array; returns the expression maker for one channel."""
    count = 257
    mapping.initialize()
    made = []
    for curve in curves:
        values = samples_of(mapping, curve, low, high, count)
        own = p.code.fresh()
        p.code.line(f"float {own}[{count}] = {{{', '.join(number(x) for x in values)}}};")
        made.append(own)
    p.need("table")

    def at(k, x):
        return f"b_curve({x}, {made[k]}, {count}, {number(low)}, {number(high)}, {int(mapping.extend == 'EXTRAPOLATED')})"

    return at


def range_of(curves):
    """The part of the axis that has control points, and at least 0 to 1."""
    places = [point.location[0] for curve in curves for point in curve.points]
    return min(0.0, *places), max(1.0, *places)


@node("CURVE_RGB")
def rgb_curves(p):
    mapping = p.mapping
    curves = list(mapping.curves)
    low, high = range_of(curves)
    color, factor = p.var("color", p.c("Color")), p.var("float", p.f("Fac"))
    # The combined curve comes first, then those of the channels.
    combined = curve_function(p, mapping, [curves[3]], low, high, "rgb")
    through = p.var("color", f"color({', '.join(combined(0, f'{color}[{i}]') for i in range(3))})")
    at = curve_function(p, mapping, curves[:3], low, high, "rgb")
    made = f"color({', '.join(at(i, f'{through}[{i}]') for i in range(3))})"
    return {"Color": ("color", f"mix({color}, {made}, {factor})")}


@node("CURVE_VEC")
def vector_curves(p):
    mapping = p.mapping
    curves = list(mapping.curves)
    places = [point.location[0] for curve in curves for point in curve.points]
    low, high = min(-1.0, *places), max(1.0, *places)
    vector, factor = p.var("vector", p.v("Vector")), p.var("float", p.f("Fac"))
    at = curve_function(p, mapping, curves[:3], low, high, "vector")
    made = f"vector({', '.join(at(i, f'{vector}[{i}]') for i in range(3))})"
    return {"Vector": ("vector", f"mix({vector}, {made}, {factor})")}


@node("CURVE_FLOAT")
def float_curve(p):
    mapping = p.mapping
    curves = list(mapping.curves)[:1]
    low, high = range_of(curves)
    value, factor = p.var("float", p.f("Value")), p.var("float", p.f("Factor"))
    at = curve_function(p, mapping, curves, low, high, "value")
    return {"Value": ("float", f"mix({value}, {at(0, value)}, {factor})")}


@node("COMBXYZ")
def combine_xyz(p):
    return {"Vector": ("vector", f"vector({p.f('X')}, {p.f('Y')}, {p.f('Z')})")}


@node("SEPXYZ")
def separate_xyz(p):
    v = p.var("vector", p.v("Vector"))
    return {name: ("float", f"{v}[{i}]") for i, name in enumerate("XYZ")}


@node("COMBINE_COLOR")
def combine_color(p):
    p.need("hsv")
    given = f"color({p.f('Red')}, {p.f('Green')}, {p.f('Blue')})"
    made = {"RGB": given, "HSV": f"b_rgb_of_hsv({given})", "HSL": f"b_rgb_of_hsl({given})"}
    return {"Color": ("color", made[p.mode])}


@node("SEPARATE_COLOR")
def separate_color(p):
    p.need("hsv")
    given = p.c("Color")
    made = {"RGB": given, "HSV": f"b_hsv_of_rgb({given})", "HSL": f"b_hsl_of_rgb({given})"}
    color = p.var("color", made[p.mode])
    return {name: ("float", f"{color}[{i}]") for i, name in enumerate(("Red", "Green", "Blue"))}


@node("RGBTOBW")
def rgb_to_bw(p):
    return {"Val": ("float", f"dot(vector({p.var('color', p.c('Color'))}), vector(0.2126, 0.7152, 0.0722))")}


@node("BLACKBODY")
def blackbody(p):
    p.need("spectra")
    return {"Color": ("color", f"b_blackbody({p.f('Temperature')})")}


@node("WAVELENGTH")
def wavelength(p):
    p.need("spectra")
    return {"Color": ("color", f"b_wavelength({p.f('Wavelength')})")}
