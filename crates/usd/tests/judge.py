# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares `gnurt info --json` with OpenUSD on files that this script makes: forty stages, each as text, binary and package.

    pip install usd-core numpy
    python3 crates/usd/tests/judge.py target/debug/gnurt [FOLDER]

Each mesh where it is shown is checked for its triangles, area, bounds, centroid and material; exit status 0 if 97 % of the checks pass.
"""
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, UsdUtils, Vt

STAGES = {}


def stage(function):
    STAGES[function.__name__] = function
    return function


def xform(s, path, translate=None, rotate=None, scale=None):
    prim = UsdGeom.Xform.Define(s, path)
    if translate:
        prim.AddTranslateOp().Set(Gf.Vec3d(*translate))
    if rotate:
        prim.AddRotateXYZOp().Set(Gf.Vec3f(*rotate))
    if scale:
        prim.AddScaleOp().Set(Gf.Vec3f(*scale))
    return prim


CUBE_POINTS = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
CUBE_FACES = [0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 2, 3, 7, 6, 0, 4, 7, 3, 1, 2, 6, 5]


def mesh(s, path, points=CUBE_POINTS, counts=(4,) * 6, indices=CUBE_FACES, scheme="none"):
    m = UsdGeom.Mesh.Define(s, path)
    m.CreatePointsAttr([Gf.Vec3f(*p) for p in points])
    m.CreateFaceVertexCountsAttr(list(counts))
    m.CreateFaceVertexIndicesAttr(list(indices))
    if scheme:
        m.CreateSubdivisionSchemeAttr(scheme)
    return m


def material(s, path, color=(0.8, 0.1, 0.1)):
    m = UsdShade.Material.Define(s, path)
    shader = UsdShade.Shader.Define(s, path + "/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    m.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    return m


def bind(prim, m, strength=UsdShade.Tokens.fallbackStrength, purpose=UsdShade.Tokens.allPurpose):
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(m, strength, purpose)


@stage
def cube(s):
    mesh(s, "/World/Cube")


@stage
def centimetres_z_up(s):
    UsdGeom.SetStageMetersPerUnit(s, 0.01)
    UsdGeom.SetStageUpAxis(s, UsdGeom.Tokens.z)
    xform(s, "/World", (10, 20, 30), (10, 20, 30), (1, 2, 3))
    mesh(s, "/World/Cube")


@stage
def unit_fallback(s):
    s.ClearMetadata("metersPerUnit")
    s.ClearMetadata("upAxis")
    mesh(s, "/Cube")


@stage
def all_operations(s):
    p = UsdGeom.Xform.Define(s, "/World")
    p.AddTranslateOp(opSuffix="pivot").Set(Gf.Vec3d(1, 2, 3))
    p.AddRotateYOp().Set(30.0)
    p.AddOrientOp().Set(Gf.Quatf(0.9, 0.1, 0.3, 0.2).GetNormalized())
    p.AddRotateZXYOp().Set(Gf.Vec3f(15, 25, 35))
    p.AddScaleOp().Set(Gf.Vec3f(1, 1.5, 0.5))
    p.AddTransformOp().Set(Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(0, 0, 4)))
    p.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    mesh(s, "/World/Cube")


@stage
def reset_stack(s):
    xform(s, "/World", (5, 5, 5))
    p = xform(s, "/World/Free", (0, 1, 0))
    p.SetResetXformStack(True)
    mesh(s, "/World/Free/Cube")
    mesh(s, "/World/Cube")


@stage
def matrix_shear(s):
    p = UsdGeom.Xform.Define(s, "/World")
    p.AddTransformOp().Set(Gf.Matrix4d(1, 0.3, 0, 0, 0.2, 1, 0, 0, 0, 0.5, 1, 0, 3, 4, 5, 1))
    mesh(s, "/World/Cube")


@stage
def mirrored(s):
    xform(s, "/World", scale=(-1, 1, 2))
    mesh(s, "/World/Cube")


@stage
def polygons(s):
    n = 7
    ring = [(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n), 0) for i in range(n)]
    mesh(s, "/Ring", ring, [n], range(n))
    mesh(s, "/Arrow", [(0, 0, 0), (2, 1, 0), (4, 0, 0), (2, 4, 0)], [4], [0, 1, 2, 3])
    l = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    mesh(s, "/L", [(0, y, z) for y, z in l], [6], [2, 3, 4, 5, 0, 1])


@stage
def left_handed(s):
    m = mesh(s, "/Cube")
    m.CreateOrientationAttr("leftHanded")


@stage
def holes(s):
    m = mesh(s, "/Cube")
    m.CreateHoleIndicesAttr([1, 4])


@stage
def non_planar(s):
    mesh(s, "/Saddle", [(0, 0, 0), (1, 0, 0.4), (1, 1, 0), (0, 1, 0.4)], [4], [0, 1, 2, 3])


@stage
def interpolations(s):
    for i, (name, count) in enumerate(
        [("constant", 1), ("uniform", 6), ("varying", 8), ("vertex", 8), ("faceVarying", 24)]
    ):
        m = mesh(s, "/World/" + name)
        UsdGeom.XformCommonAPI(m).SetTranslate(Gf.Vec3d(3 * i, 0, 0))
        color = UsdGeom.PrimvarsAPI(m).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, name)
        color.Set([Gf.Vec3f(k / count, 0.5, 1) for k in range(count)])
        st = UsdGeom.PrimvarsAPI(m).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, name)
        st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(1, 1)])
        st.SetIndices(Vt.IntArray([k % 2 for k in range(count)]))
        m.CreateNormalsAttr([Gf.Vec3f(0, 0, 1)] * count)
        m.SetNormalsInterpolation(name)


@stage
def subsets(s):
    m = mesh(s, "/World/Cube")
    red, blue, base = (material(s, "/Looks/" + n) for n in ["Red", "Blue", "Base"])
    bind(m, base)
    for name, faces, look in [("A", [0, 1], red), ("B", [2], blue)]:
        subset = UsdGeom.Subset.CreateGeomSubset(m, name, "face", Vt.IntArray(faces), "materialBind")
        bind(subset, look)


@stage
def bindings(s):
    a, b, c = (material(s, "/Looks/" + n) for n in "ABC")
    top = xform(s, "/World")
    bind(top, a)
    mesh(s, "/World/Inherits")
    bind(mesh(s, "/World/Own"), b)
    strong = xform(s, "/World/Strong")
    bind(strong, c, UsdShade.Tokens.strongerThanDescendants)
    bind(mesh(s, "/World/Strong/Overruled"), b)
    full = mesh(s, "/World/Full")
    bind(full, b)
    bind(full, c, purpose=UsdShade.Tokens.full)
    preview = mesh(s, "/World/Preview")
    bind(preview, b, purpose=UsdShade.Tokens.preview)


@stage
def collections(s):
    a, b = (material(s, "/Looks/" + n) for n in "AB")
    top = xform(s, "/World").GetPrim()
    for n in "XYZ":
        mesh(s, "/World/" + n)
    bind(UsdGeom.Xform(top), a)
    collection = Usd.CollectionAPI.Apply(top, "some")
    collection.IncludePath("/World/X")
    collection.IncludePath("/World/Z")
    collection.ExcludePath("/World/Z")
    UsdShade.MaterialBindingAPI(top).Bind(collection, b, "some")


@stage
def visibility_and_purpose(s):
    hidden = xform(s, "/World/Hidden")
    hidden.MakeInvisible()
    mesh(s, "/World/Hidden/Cube")
    for purpose in ["default", "render", "proxy", "guide"]:
        m = mesh(s, "/World/" + purpose)
        m.CreatePurposeAttr(purpose)
    proxy = xform(s, "/World/Proxy")
    proxy.CreatePurposeAttr("proxy")
    mesh(s, "/World/Proxy/Cube")
    render = mesh(s, "/World/Proxy/Shown")
    render.CreatePurposeAttr("render")
    mesh(s, "/World/Inactive").GetPrim().SetActive(False)
    s.OverridePrim("/World/Over")
    s.CreateClassPrim("/Class")
    mesh(s, "/Class/Cube")


def layer_with(folder, name, build):
    path = os.path.join(folder, name)
    other = Usd.Stage.CreateNew(path)
    UsdGeom.SetStageMetersPerUnit(other, 1)
    UsdGeom.SetStageUpAxis(other, UsdGeom.Tokens.y)
    build(other)
    other.GetRootLayer().Save()
    return name


@stage
def references(s, folder=None):
    def build(o):
        xform(o, "/Asset", scale=(1, 2, 1))
        mesh(o, "/Asset/Cube")
        o.SetDefaultPrim(o.GetPrimAtPath("/Asset"))

    name = layer_with(folder, "asset.usda", build)
    for i in range(3):
        p = xform(s, f"/World/R{i}", (3 * i, 0, 0))
        p.GetPrim().GetReferences().AddReference("./" + name)
    p = xform(s, "/World/Payload", (0, 5, 0))
    p.GetPrim().GetPayloads().AddPayload("./" + name, "/Asset/Cube")


@stage
def sublayers(s, folder=None):
    def build(o):
        x = xform(o, "/World")
        op = x.AddTranslateOp()
        op.Set(Gf.Vec3d(0, 0, 0), 0)
        op.Set(Gf.Vec3d(10, 0, 0), 10)
        mesh(o, "/World/Cube")

    name = layer_with(folder, "below.usdc", build)
    s.GetRootLayer().subLayerPaths.append("./" + name)
    s.GetRootLayer().subLayerOffsets[0] = Sdf.LayerOffset(5, 2)
    s.SetStartTimeCode(0)
    s.SetEndTimeCode(48)


@stage
def variants(s):
    p = xform(s, "/World").GetPrim()
    sets = p.GetVariantSets().AddVariantSet("size")
    for name, height in [("small", 1), ("large", 3)]:
        sets.AddVariant(name)
        sets.SetVariantSelection(name)
        with sets.GetVariantEditContext():
            mesh(s, "/World/Cube", [(x, y * height, z) for x, y, z in CUBE_POINTS])
    sets.SetVariantSelection("large")


@stage
def inherits_and_specializes(s):
    c = s.CreateClassPrim("/_class")
    mesh(s, "/_class/Cube")
    a = xform(s, "/World/A", (1, 0, 0)).GetPrim()
    a.GetInherits().AddInherit("/_class")
    b = xform(s, "/World/B", (5, 0, 0)).GetPrim()
    b.GetSpecializes().AddSpecialize("/_class")


@stage
def native_instances(s):
    xform(s, "/Prototype")
    mesh(s, "/Prototype/Cube")
    m = material(s, "/Prototype/Look")
    bind(UsdGeom.Mesh.Get(s, "/Prototype/Cube"), m)
    s.GetPrimAtPath("/Prototype").SetSpecifier(Sdf.SpecifierClass)
    for i in range(4):
        p = xform(s, f"/World/I{i}", (3 * i, 0, 0), (0, 10 * i, 0)).GetPrim()
        p.GetReferences().AddInternalReference("/Prototype")
        p.SetInstanceable(True)


@stage
def nested_instances(s):
    for name in ["/Leaf", "/Branch"]:
        s.CreateClassPrim(name)
    mesh(s, "/Leaf/Cube")
    for i in range(2):
        p = xform(s, f"/Branch/L{i}", (0, 3 * i, 0)).GetPrim()
        p.GetReferences().AddInternalReference("/Leaf")
        p.SetInstanceable(True)
    for i in range(3):
        p = xform(s, f"/World/B{i}", (4 * i, 0, 0), scale=(1, 1, 1 + i)).GetPrim()
        p.GetReferences().AddInternalReference("/Branch")
        p.SetInstanceable(True)


def instancer(s, path, prototypes, indices, positions):
    p = UsdGeom.PointInstancer.Define(s, path)
    p.CreatePrototypesRel().SetTargets(prototypes)
    p.CreateProtoIndicesAttr(indices)
    p.CreatePositionsAttr([Gf.Vec3f(*x) for x in positions])
    return p


@stage
def point_instancer(s):
    xform(s, "/World", (0, 1, 0))
    p = instancer(
        s,
        "/World/Many",
        ["/World/Many/A", "/World/Many/B"],
        [0, 1, 0, 1, 0],
        [(3 * i, 0, i) for i in range(5)],
    )
    p.CreateIdsAttr([10, 11, 12, 13, 14])
    p.CreateInvisibleIdsAttr([12])
    p.CreateScalesAttr([Gf.Vec3f(1, 1 + i / 4, 1) for i in range(5)])
    q = Gf.Quath(0.9, 0.2, 0.1, 0.3)
    q.Normalize()
    p.CreateOrientationsAttr([q] * 5)
    mesh(s, "/World/Many/A")
    xform(s, "/World/Many/B", (0, 0.5, 0), scale=(0.5, 0.5, 0.5))
    mesh(s, "/World/Many/B/Cube")


@stage
def nested_instancers(s):
    instancer(s, "/Outer", ["/Outer/Inner"], [0, 0], [(0, 0, 0), (0, 10, 0)])
    instancer(s, "/Outer/Inner", ["/Outer/Inner/Cube"], [0, 0, 0], [(0, 0, 0), (3, 0, 0), (6, 0, 0)])
    mesh(s, "/Outer/Inner/Cube")


@stage
def time_samples(s):
    s.SetStartTimeCode(0)
    s.SetEndTimeCode(48)
    x = xform(s, "/World")
    op = x.AddRotateYOp()
    op.Set(0.0, 0)
    op.Set(90.0, 48)
    m = mesh(s, "/World/Cube")
    m.GetPointsAttr().Set([Gf.Vec3f(*p) for p in CUBE_POINTS], 0)
    m.GetPointsAttr().Set([Gf.Vec3f(2 * p[0], p[1], p[2]) for p in CUBE_POINTS], 24)
    v = UsdGeom.Imageable(mesh(s, "/World/Blink")).CreateVisibilityAttr()
    v.Set("invisible", 0)
    v.Set("inherited", 12)


@stage
def held(s):
    s.SetStartTimeCode(0)
    s.SetEndTimeCode(10)
    s.SetTimeCodesPerSecond(10)
    x = xform(s, "/World")
    op = x.AddOrientOp()
    op.Set(Gf.Quatf(1, 0, 0, 0), 0)
    op.Set(Gf.Quatf(math.sqrt(0.5), 0, math.sqrt(0.5), 0), 10)
    mesh(s, "/World/Cube")


@stage
def clips(s, folder=None):
    def build(o):
        x = UsdGeom.Xform.Define(o, "/Clip")
        op = x.AddTranslateOp()
        op.Set(Gf.Vec3d(0, 0, 0), 0)
        op.Set(Gf.Vec3d(0, 24, 0), 24)

    def manifest(o):
        UsdGeom.Xform.Define(o, "/Clip").AddTranslateOp()

    name = layer_with(folder, "clip.usda", build)
    layer_with(folder, "manifest.usda", manifest)
    x = UsdGeom.Xform.Define(s, "/World")
    x.GetPrim().CreateAttribute("xformOp:translate", Sdf.ValueTypeNames.Double3)
    x.GetPrim().CreateAttribute("xformOpOrder", Sdf.ValueTypeNames.TokenArray, False, Sdf.VariabilityUniform).Set(
        ["xformOp:translate"]
    )
    mesh(s, "/World/Cube")
    api = Usd.ClipsAPI(x.GetPrim())
    api.SetClipAssetPaths([Sdf.AssetPath("./" + name)])
    api.SetClipPrimPath("/Clip")
    api.SetClipActive([(0, 0)])
    api.SetClipTimes([(0, 0), (24, 24)])
    api.SetClipManifestAssetPath(Sdf.AssetPath("./manifest.usda"))
    s.SetStartTimeCode(0)
    s.SetEndTimeCode(24)


@stage
def relocates(s, folder=None):
    def build(o):
        xform(o, "/Asset")
        xform(o, "/Asset/Old", (0, 2, 0))
        mesh(o, "/Asset/Old/Cube")

    name = layer_with(folder, "asset.usda", build)
    p = xform(s, "/World", (1, 0, 0)).GetPrim()
    p.GetReferences().AddReference("./" + name, "/Asset")
    s.GetRootLayer().relocates = [(Sdf.Path("/World/Old"), Sdf.Path("/World/New"))]


def rig(s, shapes=False):
    s.SetStartTimeCode(0)
    s.SetEndTimeCode(24)
    UsdSkel.Root.Define(s, "/Rig")
    UsdGeom.XformCommonAPI(s.GetPrimAtPath("/Rig")).SetTranslate(Gf.Vec3d(2, 0, 0))
    skeleton = UsdSkel.Skeleton.Define(s, "/Rig/Skeleton")
    UsdGeom.XformCommonAPI(skeleton).SetTranslate(Gf.Vec3d(0, 1, 0))
    joints = ["Hip", "Hip/Knee"]
    skeleton.CreateJointsAttr(joints)
    up = Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(0, 2, 0))
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1), up])
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1), up])
    animation = UsdSkel.Animation.Define(s, "/Rig/Animation")
    animation.CreateJointsAttr(joints)
    animation.CreateTranslationsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(0, 2, 0)])
    animation.CreateScalesAttr([Gf.Vec3h(1, 1, 1)] * 2)
    r = animation.CreateRotationsAttr()
    q = Gf.Quatf(math.cos(0.5), 0, 0, math.sin(0.5))
    r.Set([Gf.Quatf(1), Gf.Quatf(1)], 0)
    r.Set([Gf.Quatf(1), q], 24)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/Rig/Animation"])
    m = mesh(s, "/Rig/Cube", [(x, 2 * y + 2, z) for x, y, z in CUBE_POINTS])
    b = UsdSkel.BindingAPI.Apply(m.GetPrim())
    b.CreateSkeletonRel().SetTargets(["/Rig/Skeleton"])
    if shapes:
        shape = UsdSkel.BlendShape.Define(s, "/Rig/Cube/Wide")
        shape.CreateOffsetsAttr([Gf.Vec3f(1, 0, 0), Gf.Vec3f(1, 0, 0)])
        shape.CreatePointIndicesAttr([1, 2])
        between = shape.CreateInbetween("half")
        between.SetWeight(0.5)
        between.SetOffsets([Gf.Vec3f(0, 1, 0), Gf.Vec3f(0, 1, 0)])
        b.CreateBlendShapesAttr(["wide"])
        b.CreateBlendShapeTargetsRel().SetTargets(["/Rig/Cube/Wide"])
        animation.CreateBlendShapesAttr(["wide"])
        w = animation.CreateBlendShapeWeightsAttr()
        w.Set([0.0], 0)
        w.Set([1.0], 24)
    else:
        indices, weights = [], []
        for _, y, _ in CUBE_POINTS:
            indices += [0, 1]
            weights += [1, 0] if y < 0 else [0.25, 0.75]
        b.CreateJointIndicesPrimvar(False, 2).Set(indices)
        b.CreateJointWeightsPrimvar(False, 2).Set(weights)
        b.CreateGeomBindTransformAttr(Gf.Matrix4d(1).SetScale(Gf.Vec3d(1, 1, 2)))


@stage
def skinned(s):
    rig(s)


@stage
def blend_shapes(s):
    rig(s, shapes=True)


@stage
def control_mesh(s):
    mesh(s, "/Ball", scheme=None)


@stage
def creased(s):
    m = mesh(s, "/Cube", scheme="catmullClark")
    m.CreateCreaseIndicesAttr([0, 1, 2, 3, 0, 4, 5, 6, 7, 4])
    m.CreateCreaseLengthsAttr([5, 5])
    m.CreateCreaseSharpnessesAttr([10, 10])


@stage
def flat_grid(s):
    n = 6
    points = [(x, 0, z) for z in range(n + 1) for x in range(n + 1)]
    faces = []
    for z in range(n):
        for x in range(n):
            a = z * (n + 1) + x
            faces += [a, a + n + 1, a + n + 2, a + 1]
    mesh(s, "/Grid", points, [4] * n * n, faces, scheme="bilinear")


@stage
def double_precision_far(s):
    xform(s, "/World", (100000.25, 0, -50000.5))
    mesh(s, "/World/Cube")


@stage
def many_prims(s):
    for i in range(40):
        xform(s, f"/World/G{i % 5}/X{i}", (i, i % 7, 0), (i, 0, 0))
        mesh(s, f"/World/G{i % 5}/X{i}/Mesh")


@stage
def deep(s):
    path = ""
    for i in range(20):
        path += f"/N{i}"
        xform(s, path, (0.1, 0.2, 0), (1, 2, 3), (1.01, 1, 0.99))
    mesh(s, path + "/Cube")


@stage
def bad_primvars(s):
    m = mesh(s, "/Cube")
    color = UsdGeom.PrimvarsAPI(m).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, "vertex")
    color.Set([Gf.Vec3f(1, 0, 0)] * 3)


@stage
def triangles(s):
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    mesh(s, "/Tetrahedron", points, [3] * 4, [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3])


@stage
def spaces_of_units(s):
    UsdGeom.SetStageMetersPerUnit(s, 1000)
    UsdGeom.SetStageUpAxis(s, UsdGeom.Tokens.z)
    mesh(s, "/Cube")


@stage
def pivot(s):
    m = mesh(s, "/Cube")
    UsdGeom.XformCommonAPI(m).SetPivot(Gf.Vec3f(1, 1, 1))
    UsdGeom.XformCommonAPI(m).SetRotate(Gf.Vec3f(0, 45, 0))
    UsdGeom.XformCommonAPI(m).SetTranslate(Gf.Vec3d(1, 2, 3))


@stage
def over_reference(s, folder=None):
    def build(o):
        xform(o, "/Asset")
        mesh(o, "/Asset/Cube")

    name = layer_with(folder, "asset.usda", build)
    p = xform(s, "/World").GetPrim()
    p.GetReferences().AddReference("./" + name, "/Asset", Sdf.LayerOffset(0, 1))
    over = UsdGeom.Mesh(s.OverridePrim("/World/Cube"))
    over.GetPrim().CreateAttribute("points", Sdf.ValueTypeNames.Point3fArray).Set(
        [Gf.Vec3f(3 * x, y, z) for x, y, z in CUBE_POINTS]
    )


# What OpenUSD says.


def polygon_moments(p):
    """Area and area times centroid of a polygon: as a fan, signed where it is concave."""
    normal = np.zeros(3)
    for i in range(len(p)):
        normal += np.cross(p[i], p[(i + 1) % len(p)])
    length = np.linalg.norm(normal)
    unit = normal / length if length else normal
    crosses = [np.cross(p[i] - p[0], p[i + 1] - p[0]) / 2 for i in range(1, len(p) - 1)]
    signs = [np.dot(c, unit) for c in crosses]
    turns = [
        np.dot(np.cross(p[(i + 1) % len(p)] - p[i], p[(i + 2) % len(p)] - p[(i + 1) % len(p)]), unit)
        for i in range(len(p))
    ]
    if min(turns) >= -1e-9:
        areas = [np.linalg.norm(c) for c in crosses]
    else:
        areas = signs
    centres = [(p[0] + p[i] + p[i + 1]) / 3 for i in range(1, len(p) - 1)]
    return sum(areas), sum(a * c for a, c in zip(areas, centres))


def measured(prim, matrix, to_world, time, material_of):
    m = UsdGeom.Mesh(prim)
    points = np.array(m.GetPointsAttr().Get(time) or [], dtype=float).reshape(-1, 3)
    if not len(points):
        return None
    rows = np.array(matrix, dtype=float)
    points = points @ rows[:3, :3] + rows[3, :3]
    points = points @ to_world
    counts = m.GetFaceVertexCountsAttr().Get(time)
    indices = m.GetFaceVertexIndicesAttr().Get(time)
    holes = set(m.GetHoleIndicesAttr().Get(time) or [])
    at, triangles, area, moment, used = 0, 0, 0.0, np.zeros(3), []
    for face, n in enumerate(counts):
        corners = list(indices[at : at + n])
        at += n
        if face in holes:
            continue
        triangles += n - 2
        a, c = polygon_moments(points[corners])
        area, moment = area + a, moment + c
        used += corners
    shown = points[used]
    scheme = m.GetSubdivisionSchemeAttr().Get()
    return {
        "path": str(prim.GetPath()),
        "triangles": triangles,
        "area": area,
        "bounds": [shown.min(0).tolist(), shown.max(0).tolist()],
        "centroid": (moment / area).tolist(),
        "material": material_of(prim),
        "scheme": scheme,
    }


def expected(s, seconds):
    time = Usd.TimeCode.Default() if seconds is None else Usd.TimeCode(seconds * s.GetTimeCodesPerSecond())
    if seconds is None:
        time = Usd.TimeCode.EarliestTime()
    unit = UsdGeom.GetStageMetersPerUnit(s)
    to_world = np.eye(3) * unit
    if UsdGeom.GetStageUpAxis(s) == UsdGeom.Tokens.z:
        to_world = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]) * unit

    def material_of(prim):
        bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(UsdShade.Tokens.full)
        return bound.GetPrim().GetName() if bound else None

    found = []
    cache = UsdGeom.XformCache(time)

    def visit(prim, base=None, root=None):
        image = UsdGeom.Imageable(prim)
        if image and image.GetVisibilityAttr().Get(time) == "invisible":
            return
        if prim.IsA(UsdGeom.PointInstancer):
            p = UsdGeom.PointInstancer(prim)
            matrix = place(prim, base, root)
            prototypes = p.GetPrototypesRel().GetForwardedTargets()
            transforms = p.ComputeInstanceTransformsAtTime(
                time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
            )
            mask = p.ComputeMaskAtTime(time)
            for i, index in enumerate(p.GetProtoIndicesAttr().Get(time)):
                if mask and not mask[i]:
                    continue
                proto = s.GetPrimAtPath(prototypes[index])
                visit(proto, transforms[i] * matrix, proto)
            return
        if prim.IsA(UsdGeom.Mesh):
            purpose = UsdGeom.Imageable(prim).ComputePurpose()
            if purpose in ("default", "render"):
                m = measured(prim, place(prim, base, root), to_world, time, material_of)
                if m:
                    found.append(m)
        for child in prim.GetFilteredChildren(Usd.TraverseInstanceProxies()):
            visit(child, base, root)

    def place(prim, base, root):
        if base is None:
            return cache.GetLocalToWorldTransform(prim)
        above = cache.GetLocalToWorldTransform(root.GetParent())
        return cache.GetLocalToWorldTransform(prim) * above.GetInverse() * base

    for child in s.GetPseudoRoot().GetFilteredChildren(Usd.TraverseInstanceProxies()):
        visit(child)
    return found


def close(a, b, size, tolerance=1e-4):
    return np.allclose(np.array(a, dtype=float), np.array(b, dtype=float), rtol=tolerance, atol=tolerance * size)


def compare(name, reference, info, report):
    """Counts checks, those that pass, and tells of others."""
    checks = passed = 0
    rest = list(info["occurrences"])
    checks += 1
    passed += len(rest) == len(reference)
    if len(rest) != len(reference):
        report.append(f"{name}: {len(rest)} meshes, expected {len(reference)}")
    for want in reference:
        same = [o for o in rest if o["path"] == want["path"]]
        size = max(1e-9, *(abs(x) for corner in want["bounds"] for x in corner))
        extent = max(b - a for a, b in zip(*want["bounds"]))
        got = min(same, key=lambda o: np.abs(np.array(o["centroid"]) - want["centroid"]).sum(), default=None)
        for key in ["triangles", "area", "bounds", "centroid", "material"]:
            checks += 1
            if got is None:
                report.append(f"{name}: {want['path']} is not there")
                continue
            if key == "material":
                good = got[key] == want[key]
            elif want["scheme"] != "none" and key != "material":
                # A limit surface lies within its control mesh.
                if key == "triangles":
                    good = got.get("subdivision", {}).get("control_triangles", got[key]) == want[key]
                elif key == "centroid":
                    good = close(got[key], want[key], extent, 0.05)
                elif key == "area":
                    good = 0.2 * want[key] < got[key] < 1.01 * want[key]
                else:
                    inside = np.array(got[key][0]) >= np.array(want[key][0]) - 1e-4 * extent
                    good = inside.all() and (np.array(got[key][1]) <= np.array(want[key][1]) + 1e-4 * extent).all()
            elif key == "triangles":
                good = got[key] == want[key]
            elif key == "area":
                good = close(got[key], want[key], want[key])
            else:
                # Single precision far from the origin.
                good = close(got[key], want[key], extent + 1e-2 * size, 1e-4)
            passed += bool(good)
            if not good:
                report.append(f"{name}: {want['path']}: {key} is {got[key]}, expected {want[key]}")
        if got is not None:
            rest.remove(got)
    return checks, passed


def reference_stage(path):
    s = Usd.Stage.Open(path)
    roots = [p for p in s.Traverse() if p.IsA(UsdSkel.Root)]
    if not roots:
        return s
    flat = Usd.Stage.Open(s.Flatten())
    for p in roots:
        UsdSkel.BakeSkinning(UsdSkel.Root(flat.GetPrimAtPath(p.GetPath())), Gf.Interval(0, 48))
    return flat


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as temporary:
        top = sys.argv[2] if len(sys.argv) > 2 else temporary
        total = good = 0
        report = []
        for name, build in STAGES.items():
            folder = os.path.join(top, name)
            os.makedirs(folder, exist_ok=True)
            text = os.path.join(folder, name + ".usda")
            if os.path.exists(text):
                os.remove(text)
            for old in os.listdir(folder):
                os.remove(os.path.join(folder, old))
            s = Usd.Stage.CreateNew(text)
            UsdGeom.SetStageMetersPerUnit(s, 1)
            UsdGeom.SetStageUpAxis(s, UsdGeom.Tokens.y)
            build(s, folder=folder) if "folder" in build.__code__.co_varnames else build(s)
            s.GetRootLayer().Save()
            binary = os.path.join(folder, name + ".usdc")
            s.GetRootLayer().Export(binary)
            flat = os.path.join(folder, name + "_flat.usdc")
            s.Flatten().Export(flat)
            package = os.path.join(folder, name + ".usdz")
            UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(flat), package)
            times = [None, 0.4, 1.7] if s.HasAuthoredTimeCodeRange() else [None]
            for path in [text, binary, package]:
                for seconds in times:
                    want = expected(reference_stage(path), seconds)
                    command = [program, "info", path, "--json"]
                    command += [] if seconds is None else ["--at", str(seconds)]
                    run = subprocess.run(command, capture_output=True, text=True)
                    label = f"{os.path.basename(path)} at {seconds}"
                    if run.returncode:
                        total += 1 + 5 * len(want)
                        report.append(f"{label}: {run.stderr.strip()}")
                        continue
                    checks, passed = compare(label, want, json.loads(run.stdout), report)
                    total, good = total + checks, good + passed
        for line in report[:200]:
            print(line)
        share = good / total
        print(f"{len(STAGES)} stages, {good} of {total} checks pass: {100 * share:.2f} %")
        sys.exit(0 if share >= 0.97 else 1)


if __name__ == "__main__":
    main()
