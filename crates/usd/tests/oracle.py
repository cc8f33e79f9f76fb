# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes and implicit shapes that OpenUSD shows, and their comparison with `gnurt info --json`.

Space of all numbers: metres, y up, world. Polygons count as fans; skinned meshes are those of UsdSkel; a limit surface of a
subdivision lies within its control mesh. `judge.py` and `judge_assets.py` use it.
"""
import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

SHAPES = (UsdGeom.Cube, UsdGeom.Sphere, UsdGeom.Cylinder, UsdGeom.Cone, UsdGeom.Capsule, UsdGeom.Plane)
SEGMENTS = 96
TURN = np.linspace(0, 2 * np.pi, SEGMENTS + 1)


def turned(profile):
    """Quads of the surface of revolution of points (radius, height) about z."""
    radius, height = np.array(profile, dtype=float).T
    x, y = np.outer(radius, np.cos(TURN)), np.outer(radius, np.sin(TURN))
    z = np.outer(height, np.ones(len(TURN)))
    grid = np.stack([x, y, z], axis=-1)
    return np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-2).reshape(-1, 4, 3)


def shape_quads(prim, time):
    """The surface of an implicit shape, in its own space."""
    get = lambda name: prim.GetAttribute(name).Get(time)
    arc = np.linspace(-np.pi / 2, np.pi / 2, SEGMENTS // 2 + 1)
    if prim.IsA(UsdGeom.Cube):
        s = get("size") / 2
        a, b = np.array([-s, s, s, -s]), np.array([-s, -s, s, s])
        c = np.ones(4)
        faces = [(a, b, c * s), (a, b, -c * s), (a, c * s, b), (a, -c * s, b), (c * s, a, b), (-c * s, a, b)]
        return np.array([np.stack(f, axis=-1) for f in faces])
    if prim.IsA(UsdGeom.Sphere):
        return turned([(get("radius") * np.cos(t), get("radius") * np.sin(t)) for t in arc])
    if prim.IsA(UsdGeom.Plane):
        w, l = get("width") / 2, get("length") / 2
        if get("axis") == "Z":
            quad = [(-w, -l, 0), (w, -l, 0), (w, l, 0), (-w, l, 0)]
        elif get("axis") == "Y":
            quad = [(-w, 0, -l), (w, 0, -l), (w, 0, l), (-w, 0, l)]
        else:
            quad = [(0, -l, -w), (0, l, -w), (0, l, w), (0, -l, w)]
        return np.array([quad], dtype=float)
    r, h = get("radius"), get("height") / 2
    if prim.IsA(UsdGeom.Cylinder):
        quads = turned([(0, -h), (r, -h), (r, h), (0, h)])
    elif prim.IsA(UsdGeom.Cone):
        quads = turned([(0, -h), (r, -h), (0, h)])
    else:
        quads = turned([(r * np.cos(t), r * np.sin(t) + (h if t > 0 else -h)) for t in np.insert(arc, len(arc) // 2, -1e-12)])
    axis = get("axis")
    return quads if axis == "Z" else quads[..., [2, 0, 1]] if axis == "X" else quads[..., [1, 2, 0]]


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


class Skins:
    """Positions of skinned meshes by UsdSkel."""

    def __init__(self, stage):
        self.cache = UsdSkel.Cache()
        self.bound = {}
        predicate = Usd.TraverseInstanceProxies()
        for prim in Usd.PrimRange(stage.GetPseudoRoot(), predicate):
            if not prim.IsA(UsdSkel.Root):
                continue
            root = UsdSkel.Root(prim)
            self.cache.Populate(root, predicate)
            for binding in self.cache.ComputeSkelBindings(root, predicate):
                for target in binding.GetSkinningTargets():
                    self.bound[str(target.GetPrim().GetPath())] = (binding.GetSkeleton(), target)

    def posed(self, prim, points, time, places):
        """Points of the mesh and the matrix that brings them to the world, or nothing if it is not skinned."""
        if str(prim.GetPath()) not in self.bound:
            return None
        skeleton, skinning = self.bound[str(prim.GetPath())]
        query = self.cache.GetSkelQuery(skeleton)
        moved = Vt.Vec3fArray([Gf.Vec3f(*p) for p in points])
        animation = query.GetAnimQuery()
        if skinning.HasBlendShapes() and animation:
            weights = animation.ComputeBlendShapeWeights(time)
            mapper = skinning.GetBlendShapeMapper()
            if mapper:
                weights = mapper.Remap(weights)
            if weights:
                shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
                parts = shapes.ComputeSubShapeWeights(weights)
                shapes.ComputeDeformedPoints(
                    parts[0], parts[1], parts[2], shapes.ComputeBlendShapePointIndices(), shapes.ComputeSubShapePointOffsets(), moved
                )
        joints = query.ComputeSkinningTransforms(time)
        if not skinning.HasJointInfluences() or not joints:
            return (moved, None) if skinning.HasBlendShapes() else None
        if skinning.IsRigidlyDeformed():
            matrix = skinning.ComputeSkinnedTransform(joints, time)
            return moved, matrix * places.GetLocalToWorldTransform(skeleton.GetPrim())
        skinning.ComputeSkinnedPoints(joints, moved, time)
        return moved, places.GetLocalToWorldTransform(skeleton.GetPrim())


def summed(polygons):
    """Area and moment of polygons with one number of corners, (n, corners, 3): convex ones as fans, others one by one."""
    first, second, third = polygons[:, 0], polygons[:, 1:-1], polygons[:, 2:]
    crosses = np.cross(second - first[:, None], third - first[:, None]) / 2
    areas = np.linalg.norm(crosses, axis=-1)
    normals = crosses.sum(1)
    steps = np.roll(polygons, -1, axis=1) - polygons
    turns = np.einsum("nik,nk->ni", np.cross(steps, np.roll(steps, -1, axis=1)), normals)
    convex = turns.min(1) >= -1e-9 * np.abs(turns).max(1)
    centres = (first[:, None] + second + third) / 3
    area, moment = areas[convex].sum(), np.einsum("ni,nik->k", areas[convex], centres[convex])
    for polygon in polygons[~convex]:
        a, c = polygon_moments(polygon)
        area, moment = area + a, moment + c
    return area, moment


def expected(stage, seconds):
    """The meshes and implicit shapes that OpenUSD shows at a moment in seconds; at rest if that is None."""
    time = Usd.TimeCode(seconds * stage.GetTimeCodesPerSecond()) if seconds is not None else Usd.TimeCode.EarliestTime()
    to_world = np.eye(3) * UsdGeom.GetStageMetersPerUnit(stage)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        to_world = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]) @ to_world
    places = UsdGeom.XformCache(time)
    skins = Skins(stage)
    found = []

    def name_of(prim):
        bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(UsdShade.Tokens.full)
        if bound:
            return bound.GetPrim().GetName()
        # The wheel of OpenUSD does not read documents of MaterialX: a target that is missing may be one of theirs.
        while prim:
            targets = UsdShade.MaterialBindingAPI(prim).GetDirectBindingRel().GetTargets()
            if targets:
                return None if stage.GetPrimAtPath(targets[0]) else (None, targets[0].name)
            prim = prim.GetParent()
        return None

    def placed(points, matrix):
        rows = np.array(matrix, dtype=float)
        return (np.asarray(points, dtype=float) @ rows[:3, :3] + rows[3, :3]) @ to_world

    def entry(prim, polygons, used, triangles, scheme):
        area, moment = 0.0, np.zeros(3)
        for some in polygons:
            a, c = summed(some)
            area, moment = area + a, moment + c
        if not used.size or not area:
            return
        corners = [used.min(0).tolist(), used.max(0).tolist()]
        found.append({
            "path": str(prim.GetPath()),
            "triangles": triangles,
            "area": area,
            "bounds": corners,
            "centroid": (moment / area).tolist(),
            "material": name_of(prim),
            "scheme": scheme,
        })

    def mesh(prim, matrix):
        m = UsdGeom.Mesh(prim)
        points = m.GetPointsAttr().Get(time)
        if np.array(points).ndim != 2:
            return
        counts, indices = m.GetFaceVertexCountsAttr().Get(time), m.GetFaceVertexIndicesAttr().Get(time)
        if not points or not counts or not indices:
            return
        posed = skins.posed(prim, points, time, places)
        if posed:
            points, matrix = posed[0], matrix if posed[1] is None else posed[1]
        shown = placed(points, matrix)
        counts, indices = np.array(counts), np.array(indices)
        starts = np.cumsum(counts) - counts
        is_shown = counts > 2
        is_shown[[hole for hole in m.GetHoleIndicesAttr().Get(time) or [] if hole < len(counts)]] = False
        polygons, used, triangles = [], [], 0
        for n in np.unique(counts[is_shown]):
            corners = indices[starts[is_shown & (counts == n)][:, None] + np.arange(n)]
            polygons.append(shown[corners])
            used.append(corners.ravel())
            triangles += int(len(corners) * (n - 2))
        if used:
            entry(prim, polygons, shown[np.concatenate(used)], triangles, m.GetSubdivisionSchemeAttr().Get(time))

    def visit(prim, base=None, root=None):
        image = UsdGeom.Imageable(prim)
        if image and image.GetVisibilityAttr().Get(time) == "invisible":
            return
        matrix = places.GetLocalToWorldTransform(prim)
        if base is not None:
            matrix = matrix * places.GetLocalToWorldTransform(root.GetParent()).GetInverse() * base
        shows = image and image.ComputePurpose() in ("default", "render")
        if prim.IsA(UsdGeom.PointInstancer):
            p = UsdGeom.PointInstancer(prim)
            prototypes = p.GetPrototypesRel().GetForwardedTargets()
            transforms = p.ComputeInstanceTransformsAtTime(
                time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
            )
            mask = p.ComputeMaskAtTime(time)
            for i, index in enumerate(p.GetProtoIndicesAttr().Get(time) or []):
                if shows and (not mask or mask[i]) and index < len(prototypes):
                    prototype = stage.GetPrimAtPath(prototypes[index])
                    visit(prototype, transforms[i] * matrix, prototype)
            return
        if shows and prim.IsA(UsdGeom.Mesh):
            mesh(prim, matrix)
        elif shows and any(prim.IsA(kind) for kind in SHAPES):
            quads = shape_quads(prim, time)
            shown = placed(quads.reshape(-1, 3), matrix)
            entry(prim, [shown.reshape(-1, 4, 3)], shown, None, "none")
        for child in prim.GetFilteredChildren(Usd.TraverseInstanceProxies()):
            visit(child, base, root)

    for child in stage.GetPseudoRoot().GetFilteredChildren(Usd.TraverseInstanceProxies()):
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
                good = got[key] in want[key] if isinstance(want[key], tuple) else got[key] == want[key]
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
                # Round shapes have as many as a renderer likes.
                good = want[key] is None or got[key] == want[key]
            elif key == "area":
                good = close(got[key], want[key], want[key], 1e-4 if want["triangles"] else 2e-3)
            else:
                # Single precision far from the origin.
                good = close(got[key], want[key], extent + 1e-2 * size, 1e-4)
            passed += bool(good)
            if not good:
                report.append(f"{name}: {want['path']}: {key} is {got[key]}, expected {want[key]}")
        if got is not None:
            rest.remove(got)
    return checks, passed
