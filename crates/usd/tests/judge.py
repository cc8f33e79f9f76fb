# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares `gnurt info --json` with OpenUSD on files that this script makes: 57 stages, each as text, binary and package.

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

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, UsdUtils, Vt

from oracle import compare, expected

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


@stage
def shapes_with_axes(s):
    UsdGeom.SetStageUpAxis(s, UsdGeom.Tokens.z)
    xform(s, "/World", (1, 2, 3), (10, 20, 30), (1, 2, 0.5))
    for i, axis in enumerate("XYZ"):
        xform(s, f"/World/{axis}", (0, 10 * i, 0))
        for k, kind in enumerate([UsdGeom.Cylinder, UsdGeom.Cone, UsdGeom.Capsule, UsdGeom.Plane]):
            name = kind.__name__
            xform(s, f"/World/{axis}/At{name}", (5 * k, 0, 0))
            shape = kind.Define(s, f"/World/{axis}/At{name}/{name}")
            shape.CreateAxisAttr(axis)
            if kind is UsdGeom.Plane:
                shape.CreateWidthAttr(3.0)
                shape.CreateLengthAttr(1.5)
            else:
                shape.CreateRadiusAttr(0.75)
                shape.CreateHeightAttr(2.5)
    UsdGeom.Cube.Define(s, "/World/Cube").CreateSizeAttr(3.0)
    ball = UsdGeom.Sphere.Define(s, "/World/Ball")
    ball.CreateRadiusAttr(0.5)
    bind(ball, material(s, "/Looks/Red"))


@stage
def shapes_as_they_are(s):
    for kind in ["Cube", "Sphere", "Cylinder", "Cone", "Capsule", "Plane"]:
        getattr(UsdGeom, kind).Define(s, "/" + kind)


@stage
def loop_scheme(s):
    points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5]
    mesh(s, "/Octahedron", points, [3] * 8, faces, scheme="loop")


@stage
def rotations(s):
    for i, order in enumerate(["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]):
        p = UsdGeom.Xform.Define(s, f"/World/{order}")
        p.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat).Set(Gf.Vec3f(4 * i, 0, 0))
        getattr(p, f"AddRotate{order}Op")(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(20, 40, 60))
        p.AddScaleOp(UsdGeom.XformOp.PrecisionHalf).Set(Gf.Vec3h(1, 0.5, 2))
        p.AddRotateXOp(opSuffix="own", isInverseOp=False).Set(15.0)
        mesh(s, f"/World/{order}/Cube")


@stage
def mixed_samples(s):
    """Values of a coarse and of a fine series, at moments between."""
    s.SetStartTimeCode(0)
    s.SetEndTimeCode(50)
    s.SetTimeCodesPerSecond(25)
    top = UsdGeom.Xform.Define(s, "/World")
    move, turn = top.AddTranslateOp(), top.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    for t in range(0, 51, 5):
        move.Set(Gf.Vec3d(t * t / 100, 0, 0), t)
    turn.Set(Gf.Quatd(1, 0, 0, 0), 0)
    turn.Set(Gf.Quatd(0.5, 0.5, 0.5, 0.5), 50)
    m = mesh(s, "/World/Cube")
    m.GetFaceVertexIndicesAttr().Set(CUBE_FACES, 0)
    m.GetFaceVertexIndicesAttr().Set([CUBE_FACES[(k + 4) % 24] for k in range(24)], 25)
    hole = m.CreateHoleIndicesAttr()
    hole.Set([], 0)
    hole.Set([2], 30)


@stage
def moving_instancer(s):
    s.SetStartTimeCode(0)
    s.SetEndTimeCode(48)
    p = instancer(s, "/Many", ["/Many/A"], [0, 0, 0], [(3 * i, 0, 0) for i in range(3)])
    p.GetPositionsAttr().Set([Gf.Vec3f(3 * i, 0, 0) for i in range(3)], 0)
    p.GetPositionsAttr().Set([Gf.Vec3f(3 * i, 5, i) for i in range(3)], 48)
    p.CreateScalesAttr().Set([Gf.Vec3f(1, 1, 1)] * 3, 0)
    p.GetScalesAttr().Set([Gf.Vec3f(2, 1, 1)] * 3, 48)
    p.CreateInvisibleIdsAttr().Set([], 0)
    p.GetInvisibleIdsAttr().Set([1], 24)
    mesh(s, "/Many/A")


@stage
def instancer_of_instances(s):
    s.CreateClassPrim("/Asset")
    mesh(s, "/Asset/Cube")
    mesh(s, "/Asset/Proxy").CreatePurposeAttr("proxy")
    p = instancer(s, "/Many", ["/Many/A", "/Many/B"], [1, 0, 1], [(4 * i, i, 0) for i in range(3)])
    p.DeactivateIds([2])
    for name in "AB":
        x = xform(s, f"/Many/{name}", scale=(1, 1 + (name == "B"), 1)).GetPrim()
        x.GetReferences().AddInternalReference("/Asset")
        x.SetInstanceable(True)


@stage
def instanced_instancer(s):
    s.CreateClassPrim("/Asset")
    instancer(s, "/Asset/Many", ["/Asset/Many/A"], [0, 0], [(0, 0, 0), (0, 4, 0)])
    mesh(s, "/Asset/Many/A")
    for i in range(2):
        x = xform(s, f"/World/I{i}", (5 * i, 0, 0), (0, 0, 30 * i)).GetPrim()
        x.GetReferences().AddInternalReference("/Asset")
        x.SetInstanceable(True)


@stage
def instances_with_materials(s):
    s.CreateClassPrim("/Asset")
    mesh(s, "/Asset/Cube")
    for i, color in enumerate([(1, 0, 0), (0, 1, 0)]):
        x = xform(s, f"/World/I{i}", (4 * i, 0, 0))
        x.GetPrim().GetReferences().AddInternalReference("/Asset")
        x.GetPrim().SetInstanceable(True)
        bind(x, material(s, f"/Looks/M{i}", color))


@stage
def nested_variants(s):
    p = xform(s, "/World").GetPrim()
    outer = p.GetVariantSets().AddVariantSet("outer")
    for name in ["a", "b"]:
        outer.AddVariant(name)
        outer.SetVariantSelection(name)
        with outer.GetVariantEditContext():
            inner = p.GetVariantSets().AddVariantSet("inner")
            for k in [1, 2]:
                inner.AddVariant(f"k{k}")
                inner.SetVariantSelection(f"k{k}")
                with inner.GetVariantEditContext():
                    mesh(s, f"/World/{name}{k}", [(x * k, y, z) for x, y, z in CUBE_POINTS])
    outer.SetVariantSelection("b")
    p.GetVariantSets().GetVariantSet("inner").SetVariantSelection("k2")


@stage
def list_operations(s, folder=None):
    def build(o):
        for name in "ABC":
            xform(o, "/" + name)
            mesh(o, f"/{name}/{name}")

    name = "./" + layer_with(folder, "parts.usda", build)
    r = xform(s, "/World").GetPrim().GetReferences()
    for part in "ABC":
        r.AddReference(name, "/" + part, position=Usd.ListPositionFrontOfPrependList)
    r.RemoveReference(Sdf.Reference(name, "/B"))


@stage
def strengths(s, folder=None):
    """A local opinion over a sublayer's, over an inherited one, over a reference's."""

    def build(o):
        xform(o, "/Asset", (0, 7, 0))
        mesh(o, "/Asset/Cube", [(3 * x, y, z) for x, y, z in CUBE_POINTS])

    def below(o):
        x = UsdGeom.Xform.Define(o, "/World/A")
        x.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))

    asset = "./" + layer_with(folder, "asset.usda", build)
    s.GetRootLayer().subLayerPaths.append("./" + layer_with(folder, "below.usda", below))
    s.CreateClassPrim("/_class")
    mesh(s, "/_class/Cube", [(x, 2 * y, z) for x, y, z in CUBE_POINTS])
    for n in "AB":
        p = xform(s, f"/World/{n}").GetPrim()
        p.GetReferences().AddReference(asset, "/Asset")
        p.GetInherits().AddInherit("/_class")
    over = s.OverridePrim("/World/B/Cube")
    over.CreateAttribute("points", Sdf.ValueTypeNames.Point3fArray).Set([Gf.Vec3f(x, y, 4 * z) for x, y, z in CUBE_POINTS])


@stage
def blocked_values(s, folder=None):
    def build(o):
        xform(o, "/Asset", (0, 7, 0))
        m = mesh(o, "/Asset/Cube")
        m.CreateHoleIndicesAttr([0, 1])
        m.CreateOrientationAttr("leftHanded")

    name = layer_with(folder, "asset.usda", build)
    p = xform(s, "/World").GetPrim()
    p.GetReferences().AddReference("./" + name, "/Asset")
    p.CreateAttribute("xformOp:translate", Sdf.ValueTypeNames.Double3).Block()
    s.OverridePrim("/World/Cube").CreateAttribute("holeIndices", Sdf.ValueTypeNames.IntArray).Block()


@stage
def subset_families(s):
    m = mesh(s, "/World/Cube")
    red, base = material(s, "/Looks/Red"), material(s, "/Looks/Base")
    bind(m, base, UsdShade.Tokens.strongerThanDescendants)
    for name, faces, family in [("A", [0, 1], "materialBind"), ("B", [2, 3], "other")]:
        bind(UsdGeom.Subset.CreateGeomSubset(m, name, "face", Vt.IntArray(faces), family), red)


@stage
def rigid_skin(s):
    rig(s)
    m = UsdSkel.BindingAPI(s.GetPrimAtPath("/Rig/Cube"))
    for name in ["primvars:skel:jointIndices", "primvars:skel:jointWeights"]:
        s.GetPrimAtPath("/Rig/Cube").RemoveProperty(name)
    m.CreateJointIndicesPrimvar(True, 1).Set([1])
    m.CreateJointWeightsPrimvar(True, 1).Set([1.0])


@stage
def flat_triangles(s):
    mesh(s, "/A", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0, 0)], [4, 3, 3], [0, 1, 2, 3, 0, 1, 4, 2, 2, 1])


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
                    want = expected(Usd.Stage.Open(path), seconds)
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
