# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that scatter and emit light, as closures of the shading language.

Shading models: docs/reference/materials.md. The Principled BSDF is layered: sheen, coat, emission, then metal, glass and plastic.
"""

import bpy

from .inputs import radial_tangent, uv_tangent
from .tree import node, socket_value

# The width of facets below which they are mirrors.
SMOOTH = 0.002
FACETS = {"GGX": "ggx", "MULTI_GGX": "ggx", "BECKMANN": "beckmann", "ASHIKHMIN_SHIRLEY": "ggx"}


def closure(p, expression):
    return p.var("closure color", expression)


def share(p, name):
    return p.var("float", f"clamp({p.f(name)}, 0.0, 1.0)")


def color_of(p, name="Color"):
    return p.var("color", f"max({p.c(name)}, color(0))")


def fibres(p, name):
    """The roughness of fibres; the language's closure has the root of its number."""
    roughness = share(p, name)
    return p.var("float", f"{roughness} * {roughness}")


def tangent_of(p):
    """The direction of anisotropy: what is linked, or that of the texture coordinates, or around the object's axis."""
    if p.is_linked("Tangent"):
        return p.var("vector", p.v("Tangent"))
    if p.code.host.active_uv():
        return uv_tangent(p.code, "")
    return radial_tangent(p.code, "Z")


def widths(p, roughness, anisotropy, rotation, principled=False):
    """The widths of facets and their direction, as arguments of closures."""
    alpha = p.var("float", f"{roughness} * {roughness}")
    if p.is_constant(anisotropy, 0.0):
        return "dPdu" if False else "vector(0)", alpha, alpha
    p.need("surfaces")
    strength = p.var("float", f"clamp({p.f(anisotropy)}, {'0.0' if principled else '-0.99'}, {'1.0' if principled else '0.99'})")
    tangent = p.var("vector", tangent_of(p))
    tangent = p.var("vector", f"b_turned_tangent({tangent}, {p.normal()}, {p.f(rotation)})")
    if principled:
        aspect = p.var("float", f"sqrt(1.0 - 0.9 * {strength})")
        return tangent, p.var("float", f"{alpha} / {aspect}"), p.var("float", f"{alpha} * {aspect}")
    along = p.var("float", f"({strength} < 0.0) ? {alpha} / (1.0 + {strength}) : {alpha} * (1.0 - {strength})")
    across = p.var("float", f"({strength} < 0.0) ? {alpha} * (1.0 + {strength}) : {alpha} / (1.0 - {strength})")
    return tangent, along, across


def is_mirror(p):
    """Whether facets are known to be so smooth that a mirror takes their place, which sees lights of any size."""
    return not p.is_linked("Roughness") and p.socket("Roughness").default_value ** 2 < SMOOTH


def mirror(p, n, f0, f90):
    """A mirror by Schlick's reflectance."""
    p.need("surfaces")
    return f"b_schlick({f0}, {f90}, {n}, I) * reflection({n})"


def between_facets(p):
    """The named argument of closures for light between facets: in Cycles it leaves as light of one bounce, or is lost."""
    return f', "multiscatter", {1 if p.distribution == "MULTI_GGX" else 2}'


def film_of(p):
    """The named arguments of a thin film."""
    if p.is_constant("Thin Film Thickness", 0.0) or p.socket("Thin Film Thickness") is None:
        return ""
    return f', "thinfilm_thickness", {p.f("Thin Film Thickness")}, "thinfilm_ior", {p.f("Thin Film IOR")}'


def rough_diffuse(p, n, color, roughness):
    p.need("surfaces")
    n = p.var("vector", n)
    if bpy.app.version < (4, 3):
        # Pictures of Blender 4.2 are between surfaces with and without light between their facets.
        whole = f'oren_nayar_diffuse_bsdf({n}, min({color}, color(1)), {roughness}, "energy_compensation", 1)'
        return f"0.4 * {color} * oren_nayar({n}, {roughness}) + (0.6 * b_rough({color}, {roughness}, {n}, I)) * {whole}"
    return f'b_rough({color}, {roughness}, {n}, I) * oren_nayar_diffuse_bsdf({n}, min({color}, color(1)), {roughness}, "energy_compensation", 1)'


@node("BSDF_DIFFUSE")
def diffuse(p):
    n, color = p.normal(), color_of(p)
    if p.is_constant("Roughness", 0.0):
        return {"BSDF": ("closure color", f"{color} * diffuse({n})")}
    return {"BSDF": ("closure color", rough_diffuse(p, n, color, share(p, "Roughness")))}


@node("BSDF_GLOSSY", "BSDF_ANISOTROPIC")
def glossy(p):
    n, color, roughness = p.var("vector", p.normal()), color_of(p), share(p, "Roughness")
    tangent, along, across = widths(p, roughness, "Anisotropy", "Rotation")
    if p.distribution == "ASHIKHMIN_SHIRLEY":
        p.warn("Ashikhmin and Shirley's facets are shown as GGX")
    if is_mirror(p):
        made = mirror(p, n, color, color)
    elif FACETS[p.distribution] == "beckmann":
        made = f'{color} * microfacet("beckmann", {n}, {tangent}, {along}, {across}, 0.0, 0)'
    else:
        made = f'generalized_schlick_bsdf({n}, {tangent}, color(1), color(0), {along}, {across}, {color}, {color}, 5.0, "ggx"{between_facets(p)})'
    return {"BSDF": ("closure color", made)}


@node("BSDF_METALLIC")
def metallic(p):
    n, roughness = p.var("vector", p.normal()), share(p, "Roughness")
    tangent, along, across = widths(p, roughness, "Anisotropy", "Rotation")
    if p.fresnel_type == "F82":
        p.need("surfaces")
        base, edge = p.var("color", f"clamp({p.c('Base Color')}, color(0), color(1))"), p.var("color", f"clamp({p.c('Edge Tint')}, color(0), color(1))")
        seen = p.var("color", f"b_f82({base}, {edge}, {n}, I)")
        made = f'generalized_schlick_bsdf({n}, {tangent}, color(1), color(0), {along}, {across}, {seen}, {seen}, 5.0, "ggx"{film_of(p)}{between_facets(p)})'
        if is_mirror(p) and not film_of(p):
            made = mirror(p, n, seen, seen)
    else:
        eta, k = p.var("color", f"color({p.v('IOR')})"), p.var("color", f"color({p.v('Extinction')})")
        made = f'conductor_bsdf({n}, {tangent}, {along}, {across}, {eta}, {k}, "ggx"{film_of(p)}{between_facets(p)})'
    return {"BSDF": ("closure color", made)}


@node("BSDF_GLASS")
def glass(p):
    n, color, roughness = p.var("vector", p.normal()), color_of(p), share(p, "Roughness")
    alpha = p.var("float", f"{roughness} * {roughness}")
    ior = p.var("float", f"max({p.f('IOR')}, 1e-5)")
    p.need("surfaces")
    through = color if p.distribution != "MULTI_GGX" else p.var("color", f"b_between_facets({color}, {alpha}, {n}, I)")
    return {"BSDF": ("closure color", f'dielectric_bsdf({n}, vector(0), {color}, {through}, {alpha}, {alpha}, {ior}, "ggx"{film_of(p)})')}


@node("BSDF_REFRACTION")
def refraction_node(p):
    n, color, roughness = p.var("vector", p.normal()), color_of(p), share(p, "Roughness")
    p.need("surfaces")
    alpha = p.var("float", f"{roughness} * {roughness}")
    ior = p.var("float", f"max({p.f('IOR')}, 1e-5)")
    eta = p.var("float", f"backfacing() ? 1.0 / {ior} : {ior}")
    # The node bends all light that is not reflected totally: what the facets would mirror is made good.
    made = f'{color} * b_whole_refraction({n}, I, {eta}) * microfacet("{FACETS[p.distribution]}", {n}, vector(0), {alpha}, {alpha}, {eta}, 1)'
    return {"BSDF": ("closure color", made)}


@node("BSDF_TRANSPARENT")
def transparent(p):
    return {"BSDF": ("closure color", f"{color_of(p)} * transparent()")}


@node("BSDF_TRANSLUCENT")
def translucent(p):
    return {"BSDF": ("closure color", f"{color_of(p)} * translucent({p.normal()})")}


@node("BSDF_SHEEN")
def sheen(p):
    if p.distribution == "ASHIKHMIN":
        p.warn("Ashikhmin's velvet is shown as microfibres")
    return {"BSDF": ("closure color", f"sheen_bsdf({p.normal()}, {color_of(p)}, {fibres(p, 'Roughness')}, \"mode\", 1)")}


def below(p, n, color, prefix, method, gloss):
    """Light below the surface, by its colour and the settings of a node whose names begin with a prefix; `gloss`: whether a gloss is above."""
    p.need("subsurface")
    albedo = p.var("color", f"clamp({color}, color(0), color(1))")
    radius = p.var("color", f"max(color({p.v(prefix + 'Radius')}) * {p.f(prefix + 'Scale')}, color(0))")
    anisotropy = p.var("float", f"clamp({p.f(prefix + 'Anisotropy')}, -0.99, 0.99)")
    if method == "RANDOM_WALK_SKIN":
        return f'subsurface_bssrdf({n}, b_skin_color({albedo}, {gloss}), b_skin_path({albedo}, {radius}), {anisotropy}, "ior", max({p.f(prefix + "IOR")}, 1.0))'
    return f"subsurface_bssrdf({n}, b_walk_color({albedo}, {gloss}), b_walk_path({albedo}, {radius}), {anisotropy})"


@node("SUBSURFACE_SCATTERING")
def subsurface(p):
    if p.falloff == "BURLEY":
        p.warn("the profile of Christensen and Burley is shown as a random walk")
    return {"BSSRDF": ("closure color", below(p, p.var("vector", p.normal()), color_of(p), "", p.falloff, 0))}


@node("BSDF_TOON")
def toon(p):
    name = "glossy_toon" if p.component == "GLOSSY" else "diffuse_toon"
    return {"BSDF": ("closure color", f"{color_of(p)} * {name}({p.normal()}, {share(p, 'Size')}, {share(p, 'Smooth')})")}


@node("BSDF_HAIR_PRINCIPLED")
def principled_hair(p):
    p.need("hair")
    is_rough = p.node.model != "CHIANG"
    if not is_rough and not p.is_constant("Coat", 0.0):
        p.warn("the coat narrows the first reflection only")
    random = p.f("Random") if p.is_linked("Random") else p.code.attribute("float", "hair:Random")

    def varied(value, share):
        return value if p.is_constant(share, 0.0) else f"b_hair_varied({value}, {p.f(share)}, {random})"

    along = p.var("float", varied(p.f("Roughness"), "Random Roughness"))
    # Colours of rough cylinders are those of this roughness around them.
    around = along if is_rough else p.var("float", varied(p.f("Radial Roughness"), "Random Roughness"))
    if p.parametrization == "ABSORPTION":
        absorption = f"max(color({p.v('Absorption Coefficient')}), color(0))"
    elif p.parametrization == "MELANIN":
        melanin = varied(p.f("Melanin"), "Random Color")
        absorption = f"b_hair_of_melanin({melanin}, {p.f('Melanin Redness')}) + b_hair_of_color({p.c('Tint')}, {around})"
    else:
        absorption = f"b_hair_of_color({p.c('Color')}, {around})"
    if is_rough:
        # Normals of curves; hair of particles has none. Cycles' pictures show that it does not turn them with the object.
        across = p.code.attribute("vector", "hair:Normal")
        factors = ", ".join(f"clamp({p.f(name)}, 0.0, 1.0)" for name in ("R lobe", "TT lobe", "TRT lobe"))
        numbers = f"{along}, {p.f('Aspect Ratio')}, {p.f('IOR')}, {p.f('Offset')}"
        return {"BSDF": ("closure color", f"b_rough_hair(N, -I, normalize(dPdu), {across}, {absorption}, {numbers}, {factors})")}
    body = f"b_hair(N, normalize(dPdu), {absorption}, {along}, {around}, {p.f('Coat')}, {p.f('IOR')}, {p.f('Offset')})"
    return {"BSDF": ("closure color", body)}


@node("BSDF_HAIR")
def hair(p):
    tangent = p.v("Tangent") if p.is_linked("Tangent") else "dPdu"
    tangent = p.var("vector", f"normalize({tangent})")
    widths = ", ".join(f"clamp({p.f(name)}, 0.001, 1.0)" for name in ("RoughnessU", "RoughnessV"))
    name = "hair_reflection" if p.component == "Reflection" else "hair_transmission"
    return {"BSDF": ("closure color", f"{color_of(p)} * {name}(N, {widths}, {tangent}, {p.f('Offset')})")}


@node("BSDF_RAY_PORTAL")
def portal(p):
    p.warn("portals are shown as transparent")
    return {"BSDF": ("closure color", f"{color_of(p)} * transparent()")}


@node("EMISSION")
def emission(p):
    if p.code.host.masks:
        return {}
    return {"Emission": ("closure color", f"({color_of(p)} * {p.f('Strength')}) * emission()")}


@node("BACKGROUND")
def background(p):
    return {"Background": ("closure color", f"({color_of(p)} * {p.f('Strength')}) * background()")}


@node("HOLDOUT")
def holdout(p):
    p.code.host.holdout = True
    return {"Holdout": ("closure color", "emission()" if p.code.host.masks else "0 * emission()")}


@node("MIX_SHADER")
def mix_shader(p):
    a, b = p.shader("Shader"), p.shader("Shader_001")
    factor = p.var("float", f"clamp({p.f('Fac')}, 0.0, 1.0)")
    parts = [f"(1.0 - {factor}) * {a}"] if a and not p.is_constant("Fac", 1.0) else []
    parts += [f"{factor} * {b}"] if b and not p.is_constant("Fac", 0.0) else []
    return {"Shader": ("closure color", " + ".join(parts))} if parts else {}


@node("ADD_SHADER")
def add_shader(p):
    parts = [part for part in (p.shader("Shader"), p.shader("Shader_001")) if part]
    return {"Shader": ("closure color", " + ".join(parts))} if parts else {}


@node("EEVEE_SPECULAR")
def eevee_specular(p):
    n, base, specular = p.normal(), color_of(p, "Base Color"), color_of(p, "Specular")
    roughness = share(p, "Roughness")
    alpha = p.var("float", f"{roughness} * {roughness}")
    top = f'generalized_schlick_bsdf({n}, vector(0), color(1), color(0), {alpha}, {alpha}, {specular}, color(1), 5.0, "ggx")'
    light = "" if p.code.host.masks else f" + {color_of(p, 'Emissive Color')} * emission()"
    return {"BSDF": ("closure color", f"layer({top}, {base} * diffuse({n})){light}")}


@node("VOLUME_ABSORPTION", "VOLUME_SCATTER", "PRINCIPLED_VOLUME", "VOLUME_COEFFICIENTS")
def volume(p):
    p.warn("a volume node at a surface is not shown")
    return {}


@node("VOLUME_INFO")
def volume_info(p):
    p.warn("values of volumes are not shown")
    return {}


@node("BSDF_PRINCIPLED")
def principled(p):
    p.need("surfaces", "fresnel")
    n = p.var("vector", p.normal())
    base = p.var("color", f"max({p.c('Base Color')}, color(0))")
    roughness = share(p, "Roughness")
    metal, glass_share = share(p, "Metallic"), share(p, "Transmission Weight")
    tangent, along, across = widths(p, roughness, "Anisotropic", "Anisotropic Rotation", True)
    ior = p.var("float", f"max({p.f('IOR')}, 1.0)")
    level = p.var("float", f"max({p.f('Specular IOR Level')}, 0.0)")
    # The reflectance at normal incidence, and the index that has it.
    f0 = p.var("float", f"min(b_f0({ior}) * 2.0 * {level}, 1.0)")
    tint = p.var("color", f"max({p.c('Specular Tint')}, color(0))")
    film = film_of(p)
    parts = []
    is_metal, is_glass = p.is_constant("Metallic", 1.0), p.is_constant("Transmission Weight", 1.0)
    if not is_metal and not is_glass:
        has_gloss = not (p.is_constant("Specular IOR Level", 0.0) or p.is_constant("IOR", 1.0))
        if p.is_constant("Diffuse Roughness", 0.0):
            body = f"{base} * diffuse({n})"
        else:
            body = rough_diffuse(p, n, base, share(p, "Diffuse Roughness"))
        if not p.is_constant("Subsurface Weight", 0.0):
            weight = share(p, "Subsurface Weight")
            body = f"(1.0 - {weight}) * {closure(p, body)} + {weight} * {below(p, n, base, 'Subsurface ', p.subsurface_method, int(has_gloss))}"
        if has_gloss:
            if film or not p.is_constant("Specular Tint", 1.0):
                top = (
                    f"generalized_schlick_bsdf({n}, {tangent}, color(1), color(0), {along}, {across}, clamp({f0} * {tint}, color(0), color(1)), "
                    f'color(1), b_power({f0}), "ggx"{film})'
                )
            else:
                top = f'b_gloss({roughness} * {roughness}) * microfacet("ggx", {n}, {tangent}, {along}, {across}, b_index({f0}), 0)'
            body = f"layer({top}, {body})"
        parts.append(f"((1.0 - {metal}) * (1.0 - {glass_share})) * {closure(p, body)}")
    if not p.is_constant("Metallic", 0.0):
        brushed = "" if p.is_constant("Anisotropic", 0.0) else f" * (1.0 - 0.045 * pow(clamp({p.f('Anisotropic')}, 0.0, 1.0), 4.0))"
        metal_base, edge = p.var("color", f"min({base}, color(1)){brushed}"), p.var("color", f"min({tint}, color(1))")
        f90 = "color(1)"
        if not p.is_constant("Specular Tint", 1.0):
            metal_base = f90 = p.var("color", f"b_f82({metal_base}, {edge}, {n}, I)")
        made = f'generalized_schlick_bsdf({n}, {tangent}, color(1), color(0), {along}, {across}, {metal_base}, {f90}, 5.0, "ggx"{film}{between_facets(p)})'
        if is_mirror(p) and not film:
            made = mirror(p, n, metal_base, f90)
        parts.append(f"{metal} * {closure(p, made)}")
    if not is_metal and not p.is_constant("Transmission Weight", 0.0):
        through = p.var("color", f"sqrt(min({base}, color(1)))")
        through = p.var("color", f"b_between_facets({through}, {roughness} * {roughness}, {n}, I)")
        made = f'dielectric_bsdf({n}, {tangent}, min({tint}, color(1)), {through}, {along}, {across}, {ior}, "ggx"{film})'
        parts.append(f"((1.0 - {metal}) * {glass_share}) * {closure(p, made)}")
    whole = closure(p, " + ".join(parts))
    if not (p.code.host.masks or p.is_constant("Emission Strength", 0.0) or p.is_constant("Emission Color", 0.0)):
        light = p.var("color", f"max({p.c('Emission Color')}, color(0)) * {p.f('Emission Strength')}")
        whole = closure(p, f"{whole} + {light} * emission()")
    if not p.is_constant("Coat Weight", 0.0):
        whole = coat(p, whole)
    if not p.is_constant("Sheen Weight", 0.0):
        color = p.var("color", f"clamp({share(p, 'Sheen Weight')} * {p.c('Sheen Tint')}, color(0), color(1))")
        whole = closure(p, f"layer(sheen_bsdf({n}, {color}, {fibres(p, 'Sheen Roughness')}, \"mode\", 1), {whole})")
    if not p.is_constant("Alpha", 1.0):
        alpha = share(p, "Alpha")
        whole = closure(p, f"{alpha} * {whole} + (1.0 - {alpha}) * transparent()")
    return {"BSDF": ("closure color", whole)}


def coat(p, whole):
    """A clear layer above; its tint is absorbed on the way in and out."""
    n = p.var("vector", p.value("Coat Normal", "vector", "N"))
    weight, roughness = share(p, "Coat Weight"), share(p, "Coat Roughness")
    alpha = p.var("float", f"{roughness} * {roughness}")
    ior = p.var("float", f"max({p.f('Coat IOR')}, 1.0)")
    if not p.is_constant("Coat Tint", 1.0):
        tint = p.var("color", f"max({p.c('Coat Tint')}, color(0))")
        whole = closure(p, f"b_coat_tint({tint}, {weight}, {ior}, {n}, I) * {whole}")
    top = f'b_gloss({alpha}) * microfacet("ggx", {n}, vector(0), {alpha}, {alpha}, {ior}, 0)'
    return closure(p, f"layer({weight} * {top}, {whole})")


def has_vectors(tree):
    """Whether a tree or one of its groups has a node of displacement by vectors."""
    return any(each.type == "VECTOR_DISPLACEMENT" or (each.type == "GROUP" and each.node_tree and has_vectors(each.node_tree)) for each in tree.nodes)


def bump_of_displacement(code, tree, output):
    """Displacement as a change of the normal, which all nodes after it read. Where vertices are moved, too, it is the change of the normal
    that the surface had before by all of the displacement, so that relief between vertices shows."""
    code.need("bump")
    if not code.host.moves and not has_vectors(tree):
        moved = socket_value(code, tree, output.inputs["Displacement"], None, "vector", "vector(0)")
        height = code.var("float", f"{moved}[0]")
        code.line(f"N = b_bump(N, {height}, Dx({height}), Dy({height}), 1.0, 1.0);")
        return
    if code.host.moves:
        code.relief = code.var("vector", f"normalize({code.attribute('vector', 'rest_normal')})")
        code.line(f'N = normalize(transform("object", "world", normal({code.relief})));')
        code.line("point moved = P;")
        code.line(f'P = transform("object", "world", point({code.attribute("vector", "rest")}));')
    else:
        code.line("N = backfacing() ? -N : N;")
        code.relief = code.var("vector", 'vector(normalize(transform("object", N)))')
    offset = socket_value(code, tree, output.inputs["Displacement"], None, "vector", "vector(0)")
    offset = code.var("vector", f'transform("object", "world", vector({offset}))')
    code.line(f"N = b_relief(N, Dx({offset}), Dy({offset}));")
    code.line("N = backfacing() ? -N : N;")
    if code.host.moves:
        # Other nodes of the surface are those of the moved point.
        code.line("P = moved;")
        code.made = {}
    code.relief = None


def displacement(code, tree, output):
    """The text of a shader that moves vertices."""
    code.moves = True
    offset = socket_value(code, tree, output.inputs["Displacement"], None, "vector", "vector(0)")
    return code.text("blender_displacement", [f"P += {offset};"])
