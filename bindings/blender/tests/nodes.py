# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases of the judge of nodes: each node with up to sixteen settings, one for each tile of a picture.

A setting is a dict: names of inputs (identifiers) or properties and their values. `out` is the output that is shown; a value that is
a text with `@` links an input: `@Object` to texture coordinates, `@u`, `@v` to their parts, `@color` to a colour of them.
"""

import math

CASES = {}


def case(name, kind, *settings, setup=None, **common):
    CASES[name] = (kind, [{**common, **setting} for setting in settings], setup)


def each(name, values, **more):
    return [{name: value, **more} for value in values]


OBJECT = "@Object"
NOISES = ["FBM", "MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "HETERO_TERRAIN"]
for size in ("1D", "2D", "3D", "4D"):
    w = {} if size in {"2D", "3D"} else {"W": "@u"}
    v = {} if size == "1D" else {"Vector": OBJECT}
    case(
        f"noise {size}", "ShaderNodeTexNoise",
        {}, {"out": "Color"}, {"Detail": 0.0}, {"Detail": 4.6, "Roughness": 0.7}, {"Lacunarity": 2.7}, {"Distortion": 1.5},
        {"normalize": False}, {"Scale": 11.0, "out": "Color"}, *each("noise_type", NOISES[1:], Offset=0.3, Gain=1.4), {"noise_type": "HYBRID_MULTIFRACTAL", "Detail": 5.5, "Offset": 0.8},
        noise_dimensions=size, **w, **v,
    )
    case(
        f"voronoi {size}", "ShaderNodeTexVoronoi",
        {}, {"out": "Color"}, {"out": "Position"} if size != "1D" else {"out": "W"}, {"feature": "F2"}, {"feature": "F2", "out": "Color"},
        {"feature": "SMOOTH_F1", "Smoothness": 0.6}, {"feature": "SMOOTH_F1", "out": "Color"}, {"feature": "DISTANCE_TO_EDGE"},
        {"feature": "N_SPHERE_RADIUS", "out": "Radius"}, {"Randomness": 0.4}, {"Detail": 2.5, "normalize": True}, {"Detail": 1.5, "out": "Color", "Roughness": 0.7},
        {"feature": "F2", "normalize": True}, {"feature": "DISTANCE_TO_EDGE", "Detail": 2.0, "normalize": True},
        voronoi_dimensions=size, **w, **v,
    )
    case(f"white noise {size}", "ShaderNodeTexWhiteNoise", {"out": "Value"}, {"out": "Color"}, noise_dimensions=size, snap=True, **w, **v)
case(
    "voronoi metrics", "ShaderNodeTexVoronoi",
    *each("distance", ["MANHATTAN", "CHEBYCHEV", "MINKOWSKI"], Exponent=0.5), *each("distance", ["MANHATTAN", "CHEBYCHEV", "MINKOWSKI"], Exponent=3.0, feature="F2"),
    *each("distance", ["MANHATTAN", "CHEBYCHEV", "MINKOWSKI"], feature="SMOOTH_F1", Exponent=1.5, normalize=True), Vector=OBJECT,
)
case(
    "wave", "ShaderNodeTexWave",
    {}, *each("bands_direction", ["Y", "Z", "DIAGONAL"]), *each("wave_profile", ["SAW", "TRI"]), *each("rings_direction", ["X", "Y", "Z", "SPHERICAL"], wave_type="RINGS"),
    {"Distortion": 4.0}, {"Distortion": 3.0, "Detail": 4.0, "Detail Scale": 2.5, "Detail Roughness": 0.8}, {"Phase Offset": 1.3}, Vector=OBJECT, Scale=1.5,
)
case("checker", "ShaderNodeTexChecker", {}, {"Scale": 3.3, "Color1": (1, 0.2, 0.1, 1), "Color2": (0.1, 0.2, 0.6, 1)}, {"out": "Fac"}, Vector=OBJECT)
case(
    "brick", "ShaderNodeTexBrick",
    {}, {"out": "Fac"}, {"offset": 0.3, "offset_frequency": 3}, {"squash": 0.6, "squash_frequency": 3}, {"Mortar Size": 0.06, "Mortar Smooth": 0.8},
    {"Bias": -0.4}, {"Brick Width": 0.9, "Row Height": 0.4}, {"Mortar Smooth": 0.0, "Mortar Size": 0.04}, Vector=OBJECT, Scale=4.0, Mortar=(0.9, 0.2, 0.1, 1),
)
case("gradient", "ShaderNodeTexGradient", *each("gradient_type", ["LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"]), Vector=OBJECT)
case("magic", "ShaderNodeTexMagic", *each("turbulence_depth", list(range(11))), {"Distortion": 2.3, "out": "Fac"}, {"Distortion": 0.4, "turbulence_depth": 4}, Vector=OBJECT, Scale=2.0)
case(
    "mapping", "ShaderNodeMapping", *each("vector_type", ["POINT", "TEXTURE", "VECTOR", "NORMAL"]),
    Vector=OBJECT, Location=(0.2, 0.3, 0.1), Rotation=(0.4, 0.7, 1.1), Scale=(1.5, 0.8, 2.0),
)
MATH = "ADD SUBTRACT MULTIPLY DIVIDE MULTIPLY_ADD POWER LOGARITHM SQRT INVERSE_SQRT ABSOLUTE EXPONENT MINIMUM MAXIMUM LESS_THAN GREATER_THAN SIGN"
MATH2 = "COMPARE SMOOTH_MIN SMOOTH_MAX ROUND FLOOR CEIL TRUNC FRACT MODULO FLOORED_MODULO WRAP SNAP PINGPONG SINE COSINE TANGENT"
MATH3 = "ARCSINE ARCCOSINE ARCTANGENT ARCTAN2 SINH COSH TANH RADIANS DEGREES"
case("math", "ShaderNodeMath", *each("operation", MATH.split()), Value="@u", Value_001="@v", Value_002=0.3)
case("math 2", "ShaderNodeMath", *each("operation", MATH2.split()), Value="@u2", Value_001=0.6, Value_002=0.3)
case("math 3", "ShaderNodeMath", *each("operation", MATH3.split()), {"use_clamp": True, "operation": "MULTIPLY", "Value_001": 3.0}, Value="@u", Value_001="@v")
VECTORS = "ADD SUBTRACT MULTIPLY DIVIDE MULTIPLY_ADD CROSS_PRODUCT PROJECT REFLECT REFRACT FACEFORWARD SCALE NORMALIZE ABSOLUTE POWER SIGN MINIMUM"
VECTORS2 = "MAXIMUM FLOOR CEIL FRACTION MODULO WRAP SNAP SINE COSINE TANGENT"
case("vector math", "ShaderNodeVectorMath", *each("operation", VECTORS.split()), Vector=OBJECT, Vector_001=(0.6, 0.4, 0.9), Vector_002=(0.2, -0.3, 0.7), Scale=0.7)
case("vector math 2", "ShaderNodeVectorMath", *each("operation", VECTORS2.split()), *each("operation", ["DOT_PRODUCT", "DISTANCE", "LENGTH"], out="Value"), Vector=OBJECT, Vector_001=(0.6, 0.4, 0.9), Vector_002=(0.2, -0.3, 0.7))
case(
    "map range", "ShaderNodeMapRange", *each("interpolation_type", ["LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"]), {"clamp": False}, {"To Min": 0.9, "To Max": 0.1},
    *each("interpolation_type", ["LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"], data_type="FLOAT_VECTOR", out="Vector", Vector=OBJECT), Value="@u", **{"From Min": 0.2, "From Max": 0.7},
)
case("clamp", "ShaderNodeClamp", *each("clamp_type", ["MINMAX", "RANGE"], Min=0.7, Max=0.3), {"Min": 0.3, "Max": 0.6}, Value="@u")
BLENDS = "MIX DARKEN MULTIPLY BURN LIGHTEN SCREEN DODGE ADD OVERLAY SOFT_LIGHT LINEAR_LIGHT DIFFERENCE EXCLUSION SUBTRACT DIVIDE HUE"
case("mix colours", "ShaderNodeMix", *each("blend_type", BLENDS.split()), data_type="RGBA", Factor_Float=0.7, A_Color="@color", B_Color=(0.3, 0.7, 0.5, 1), out="Result_Color")
case(
    "mix more", "ShaderNodeMix", *each("blend_type", ["SATURATION", "COLOR", "VALUE"], data_type="RGBA", out="Result_Color"), {"out": "Result_Float", "A_Float": 0.2, "B_Float": 0.9, "Factor_Float": "@u2"},
    {"data_type": "VECTOR", "out": "Result_Vector", "A_Vector": OBJECT}, {"data_type": "VECTOR", "factor_mode": "NON_UNIFORM", "out": "Result_Vector", "A_Vector": OBJECT, "Factor_Vector": (0.2, 1.4, 0.5)},
    {"data_type": "RGBA", "out": "Result_Color", "blend_type": "ADD", "clamp_result": True, "B_Color": (1, 1, 1, 1)}, {"data_type": "RGBA", "out": "Result_Color", "clamp_factor": False, "Factor_Float": 1.5},
    Factor_Float=0.7, A_Color="@color", B_Color=(0.3, 0.7, 0.5, 1), B_Vector=(0.3, 0.7, 0.5),
)
case("mix legacy", "ShaderNodeMixRGB", *each("blend_type", ["MIX", "MULTIPLY", "SCREEN", "HUE"]), {"use_clamp": True, "blend_type": "ADD"}, Fac="@u", Color1="@color", Color2=(0.9, 0.7, 0.2, 1))


def stops(node):
    ramp = node.color_ramp
    ramp.elements[0].color, ramp.elements[1].color = (0.9, 0.1, 0.1, 1), (0.1, 0.2, 0.9, 0.4)
    for at, color in ((0.3, (0.2, 0.8, 0.1, 0.7)), (0.65, (0.9, 0.9, 0.2, 1))):
        ramp.elements.new(at).color = color
    ramp.elements[0].position, ramp.elements[-1].position = 0.1, 0.85


def ramp(mode, hue="NEAR"):
    def setup(node):
        stops(node)
        if mode in {"RGB", "HSV", "HSL"}:
            node.color_ramp.color_mode, node.color_ramp.hue_interpolation = mode, hue
        else:
            node.color_ramp.interpolation = mode

    return setup


case(
    "ramp", "ShaderNodeValToRGB", *[{"setup": ramp(mode)} for mode in ("LINEAR", "EASE", "CONSTANT", "CARDINAL", "B_SPLINE", "HSV", "HSL")],
    *[{"setup": ramp("HSV", hue)} for hue in ("FAR", "CW", "CCW")], {"setup": ramp("LINEAR"), "out": "Alpha"}, Fac="@u",
)


def bend(index):
    def setup(node):
        curve = node.mapping.curves[index]
        curve.points.new(0.35, 0.7)
        curve.points.new(0.7, 0.2)
        node.mapping.update()

    return setup


case("rgb curves", "ShaderNodeRGBCurve", {"setup": bend(3)}, {"setup": bend(0)}, {"setup": bend(2), "Fac": 0.5}, Color="@color")
case("vector curves", "ShaderNodeVectorCurve", {"setup": bend(0)}, {"setup": bend(1), "Fac": 0.6}, Vector=OBJECT)
case("float curve", "ShaderNodeFloatCurve", {"setup": bend(0)}, {"setup": bend(0), "Factor": 0.5}, Value="@u")
case("hue saturation", "ShaderNodeHueSaturation", {"Hue": 0.7}, {"Saturation": 0.3}, {"Saturation": 1.8}, {"Value": 1.4}, {"Hue": 0.2, "Fac": 0.6}, Color="@color")
case("bright contrast", "ShaderNodeBrightContrast", {"Bright": 0.3}, {"Contrast": 0.6}, {"Bright": -0.2, "Contrast": 1.2}, Color="@color")
case("gamma", "ShaderNodeGamma", {"Gamma": 0.45}, {"Gamma": 2.2}, Color="@color")
case("invert", "ShaderNodeInvert", {}, {"Fac": 0.4}, Color="@color")
case("combine colour", "ShaderNodeCombineColor", *each("mode", ["RGB", "HSV", "HSL"]), Red="@u", Green="@v", Blue=0.7)
case("separate colour", "ShaderNodeSeparateColor", *[{"mode": mode, "out": out} for mode in ("RGB", "HSV", "HSL") for out in ("Red", "Green", "Blue")], Color="@color")
case("combine xyz", "ShaderNodeCombineXYZ", {}, X="@u", Y="@v", Z=0.4)
case("separate xyz", "ShaderNodeSeparateXYZ", *each("out", ["X", "Y", "Z"]), Vector=OBJECT)
case("rgb to bw", "ShaderNodeRGBToBW", {}, Color="@color")
case("blackbody", "ShaderNodeBlackbody", {"Temperature": "@1000"}, {"Temperature": "@6000"}, {"Temperature": "@20000"}, {"Temperature": 500.0})
case("wavelength", "ShaderNodeWavelength", {"Wavelength": "@380"}, {"Wavelength": 600.0})
case(
    "vector rotate", "ShaderNodeVectorRotate", *each("rotation_type", ["AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"]), *each("rotation_type", ["AXIS_ANGLE", "EULER_XYZ"], invert=True),
    Vector=OBJECT, Center=(0.1, 0.2, 0.3), Axis=(0.3, 0.5, 0.8), Angle=0.8, Rotation=(0.3, 0.6, 0.9),
)
case(
    "vector transform", "ShaderNodeVectorTransform",
    *[{"vector_type": kind, "convert_from": a, "convert_to": b} for kind in ("POINT", "VECTOR", "NORMAL") for a, b in (("WORLD", "OBJECT"), ("OBJECT", "WORLD"), ("WORLD", "CAMERA"), ("CAMERA", "OBJECT"))],
    Vector=OBJECT,
)
case("normal", "ShaderNodeNormal", {"out": "Dot"}, {"out": "Normal"}, Normal=OBJECT)
case("texture coordinates", "ShaderNodeTexCoord", *each("out", ["Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"]))
case("geometry", "ShaderNodeNewGeometry", *each("out", ["Position", "Normal", "True Normal", "Incoming", "Backfacing", "Tangent", "Parametric", "Pointiness"]))
case("object info", "ShaderNodeObjectInfo", *each("out", ["Location", "Color", "Alpha", "Object Index", "Material Index", "Random"]))
case("light path", "ShaderNodeLightPath", *each("out", ["Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Is Transmission Ray", "Ray Length"]))
case("fresnel", "ShaderNodeFresnel", {}, {"IOR": 1.2}, {"IOR": 2.5})
case("layer weight", "ShaderNodeLayerWeight", *[{"out": out, "Blend": b} for out in ("Fresnel", "Facing") for b in (0.2, 0.5, 0.8)])
case("camera data", "ShaderNodeCameraData", *each("out", ["View Vector", "View Z Depth", "View Distance"]))
case("attribute", "ShaderNodeAttribute", *[{"attribute_name": n, "out": out} for n in ("tint", "height", "UVMap", "faces") for out in ("Color", "Fac", "Vector")])
case("colour attribute", "ShaderNodeVertexColor", {"layer_name": "tint"}, {}, {"layer_name": "tint", "out": "Alpha"})
case("uv map", "ShaderNodeUVMap", {"uv_map": "UVMap"}, {"uv_map": "second"}, {})
case("tangent", "ShaderNodeTangent", *each("axis", ["X", "Y", "Z"]), {"direction_type": "UV_MAP", "uv_map": "UVMap"})
case("bump", "ShaderNodeBump", {}, {"Strength": 0.4}, {"invert": True}, {"Distance": 0.2}, Height="@wave", Distance=0.05)
case("normal map", "ShaderNodeNormalMap", *each("space", ["TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"]), {"Strength": 0.4}, {"Strength": 2.0}, {"uv_map": "second"}, Color=(0.7, 0.4, 0.85, 1))
case("wireframe", "ShaderNodeWireframe", {"Size": 0.02}, {"Size": 0.05})


def picture(**settings):
    return {"image": True, **settings}


case(
    "image", "ShaderNodeTexImage", *each("interpolation", ["Linear", "Closest", "Cubic", "Smart"], image=True), *each("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"], image=True, Vector="@uv3"),
    picture(projection="BOX", projection_blend=0.3, Vector="@Generated"), picture(projection="SPHERE", Vector="@Generated"), picture(projection="TUBE", Vector="@Generated"), picture(out="Alpha"), picture(projection="BOX", Vector="@Generated"),
    {"image": "float"}, {"image": "data"},
)
case("environment texture", "ShaderNodeTexEnvironment", *each("projection", ["EQUIRECTANGULAR", "MIRROR_BALL"], image=True), Vector=OBJECT)
case("preetham", "ShaderNodeTexSky", *each("sun_direction", [(0.3, -0.5, 0.8), (0.7, 0.2, 0.3)], sky_type="PREETHAM", turbidity=3.0), Vector=OBJECT)
for name, kind in (("sky of single scattering", "SINGLE_SCATTERING"), ("sky of multiple scattering", "MULTIPLE_SCATTERING")):
    case(
        name, "ShaderNodeTexSky", {}, *each("sun_elevation", [math.radians(x) for x in (2, 45, 80)]), {"altitude": 3000.0}, *each("air_density", [0.0, 3.0]),
        *each("aerosol_density", [0.0, 3.0]), *each("ozone_density", [0.0, 3.0]), {"sun_elevation": 0.1, "sun_rotation": 2.0},
        sky_type=kind, sun_disc=False, Vector=OBJECT,
    )
case(
    "ambient occlusion", "ShaderNodeAmbientOcclusion", {"Distance": 0.3}, {"Distance": 1.0}, {"Distance": 0.6, "only_local": True}, {"Distance": 0.4, "inside": True, "only_local": True},
    {"Distance": 0.5, "out": "AO"}, samples=64, Color=(0.9, 0.7, 0.5, 1),
)
case("bevel", "ShaderNodeBevel", {"Radius": 0.1}, {"Radius": 0.3}, samples=16)
