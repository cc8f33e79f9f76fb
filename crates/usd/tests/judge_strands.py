# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves and points through `gnurt convert`: stages that this script makes, written again, and read by OpenUSD.

    pip install usd-core numpy
    python3 crates/usd/tests/judge_strands.py target/debug/gnurt [FOLDER]

Both stages are evaluated by the definition of UsdGeomBasisCurves: positions and widths at nine parameters of each segment, in
metres; points, widths and colours of vertices. Exit status 0 if all agree to 1e-5.
"""
import itertools
import os
import subprocess
import sys
import tempfile

import numpy as np
from pxr import Gf, Usd, UsdGeom

BASES = {
    "bezier": np.array([[-1, 3, -3, 1], [3, -6, 3, 0], [-3, 3, 0, 0], [1, 0, 0, 0]], dtype=float),
    "bspline": np.array([[-1, 3, -3, 1], [3, -6, 3, 0], [-3, 0, 3, 0], [1, 4, 1, 0]], dtype=float) / 6,
    "catmullRom": np.array([[-1, 3, -3, 1], [2, -5, 4, -1], [-1, 0, 1, 0], [0, 2, 0, 0]], dtype=float) / 2,
}
PARAMETERS = np.linspace(0, 1, 9)


def windows(count, kind, basis, wrap):
    """The points of each segment; -1 and `count` are the ones beyond both ends of a pinned curve."""
    if kind == "linear":
        return [[i, (i + 1) % count] for i in range(count if wrap == "periodic" else count - 1)]
    if basis == "bezier":
        segments = count // 3 if wrap == "periodic" else (count - 1) // 3
        return [[(3 * s + k) % count if wrap == "periodic" else 3 * s + k for k in range(4)] for s in range(segments)]
    if wrap == "periodic":
        return [[(s + k) % count for k in range(4)] for s in range(count)]
    if wrap == "pinned":
        return [[s - 1 + k for k in range(4)] for s in range(count - 1)]
    return [[s + k for k in range(4)] for s in range(count - 3)]


def at(values, i):
    if i < 0:
        return 2 * values[0] - values[1]
    if i >= len(values):
        return 2 * values[-1] - values[-2]
    return values[i]


def sampled(values, kind, basis, wrap):
    """Values of vertices along a curve: its segments, then parameters."""
    out = []
    for window in windows(len(values), kind, basis, wrap):
        corners = np.array([at(values, i) for i in window], dtype=float)
        for t in PARAMETERS:
            weights = np.array([1 - t, t]) if kind == "linear" else np.array([t**3, t**2, t, 1]) @ BASES[basis]
            out.append(weights @ corners)
    return np.array(out)


def along(values, kind, basis, wrap, segments):
    """Values that vary along a curve, linear in each segment."""
    n = len(values)
    ends = [(s, (s + 1) % n if wrap == "periodic" else s + 1) for s in range(segments)]
    return np.array([values[a] + (values[b] - values[a]) * t for a, b in ends for t in PARAMETERS])


def curves_of(prim, world):
    c = UsdGeom.BasisCurves(prim)
    kind, basis, wrap = c.GetTypeAttr().Get(), c.GetBasisAttr().Get(), c.GetWrapAttr().Get()
    points = np.array(c.GetPointsAttr().Get(), dtype=float)
    points = points @ world[:3, :3] + world[3, :3]
    scale = abs(np.linalg.det(world[:3, :3])) ** (1 / 3)
    widths = np.array(c.GetWidthsAttr().Get(), dtype=float) * scale
    interpolation = c.GetWidthsInterpolation()
    counts, first, knot, out = c.GetCurveVertexCountsAttr().Get(), 0, 0, []
    for curve, count in enumerate(counts):
        own = points[first : first + count]
        segments = len(windows(count, kind, basis, wrap))
        knots = segments if wrap == "periodic" else segments + 1
        if interpolation == "vertex":
            wide = sampled(widths[first : first + count].reshape(-1, 1), kind, basis, wrap)[:, 0]
        elif interpolation == "varying":
            wide = along(widths[knot : knot + knots], kind, basis, wrap, segments)
        else:
            wide = np.full(segments * len(PARAMETERS), widths[0 if interpolation == "constant" else curve])
        out.append((sampled(own, kind, basis, wrap), wide))
        first, knot = first + count, knot + knots
    return out


def contents(path):
    """Curves and points of a stage in the world, metres, y up."""
    stage = Usd.Stage.Open(path)
    unit = UsdGeom.GetStageMetersPerUnit(stage)
    turn = np.eye(4)
    if UsdGeom.GetStageUpAxis(stage) == "Z":
        turn[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    turn[:3, :3] *= unit
    cache = UsdGeom.XformCache()
    curves, points = [], []
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
        world = np.array(cache.GetLocalToWorldTransform(prim)) @ turn
        if prim.IsA(UsdGeom.BasisCurves):
            curves += curves_of(prim, world)
        if prim.IsA(UsdGeom.Points):
            p = UsdGeom.Points(prim)
            at_rest = np.array(p.GetPointsAttr().Get(), dtype=float) @ world[:3, :3] + world[3, :3]
            scale = abs(np.linalg.det(world[:3, :3])) ** (1 / 3)
            widths = np.array(p.GetWidthsAttr().Get(), dtype=float) * scale
            widths = np.broadcast_to(widths, len(at_rest))
            colors = UsdGeom.PrimvarsAPI(prim).GetPrimvar("displayColor").Get()
            colors = np.broadcast_to(np.array(colors if colors else [(-1, -1, -1)], dtype=float), (len(at_rest), 3))
            points += [np.concatenate([a, [w], c]) for a, w, c in zip(at_rest, widths, colors)]
    return curves, points


def make(path, kind, basis, wrap, interpolation, shared):
    stage = Usd.Stage.CreateNew(path)
    UsdGeom.SetStageMetersPerUnit(stage, 0.1)
    UsdGeom.SetStageUpAxis(stage, "Z")
    top = UsdGeom.Xform.Define(stage, "/World")
    top.AddTranslateOp().Set(Gf.Vec3d(3, -4, 5))
    top.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    root = "/World"
    if shared:
        stage.CreateClassPrim("/Proto")
        root = "/Proto"
        for i in range(2):
            prim = UsdGeom.Xform.Define(stage, f"/World/I{i}")
            prim.AddTranslateOp().Set(Gf.Vec3d(i, 0, 0))
            prim.GetPrim().GetReferences().AddInternalReference("/Proto")
            prim.GetPrim().SetInstanceable(True)
    random = np.random.default_rng(len(basis) + 10 * len(wrap))
    counts = {"linear": [2, 5, 3], "bezier": [4, 7, 10], "bspline": [4, 6, 5], "catmullRom": [4, 6, 5]}[basis]
    if basis == "bezier" and wrap == "periodic":
        counts = [6, 9, 3]
    points = random.uniform(-1, 1, (sum(counts), 3))
    curves = UsdGeom.BasisCurves.Define(stage, root + "/Hair")
    curves.CreateTypeAttr(kind)
    if kind == "cubic":
        curves.CreateBasisAttr(basis)
    curves.CreateWrapAttr(wrap)
    curves.CreateCurveVertexCountsAttr(counts)
    curves.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
    segments = [len(windows(n, kind, basis, wrap)) for n in counts]
    knots = sum(s if wrap == "periodic" else s + 1 for s in segments)
    number = {"constant": 1, "uniform": len(counts), "varying": knots, "vertex": len(points)}[interpolation]
    curves.CreateWidthsAttr([float(w) for w in random.uniform(0.06, 0.1, number)])
    curves.SetWidthsInterpolation(interpolation)
    dots = UsdGeom.Points.Define(stage, root + "/Dots")
    dots.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in random.uniform(-1, 1, (7, 3))])
    dots.CreateWidthsAttr([float(w) for w in random.uniform(0.1, 0.4, 7)])
    colors = [Gf.Vec3f(*map(float, c)) for c in random.uniform(0, 1, (7, 3))]
    UsdGeom.Gprim(dots).CreateDisplayColorPrimvar("vertex").Set(colors)
    stage.GetRootLayer().Save()


def differences(before, after, linear_widths):
    (curves, points), (new_curves, new_points) = before, after
    if len(curves) != len(new_curves) or len(points) != len(new_points):
        return f"{len(new_curves)} curves and {len(new_points)} points, expected {len(curves)} and {len(points)}"
    worst = 0.0
    for (a, wide), (b, new_wide) in zip(curves, new_curves):
        if a.shape != b.shape:
            return f"{len(b)} samples of a curve, expected {len(a)}"
        worst = max(worst, np.abs(a - b).max())
        # Vertices of B-splines and Catmull-Rom curves cannot say widths that vary linearly.
        if linear_widths:
            worst = max(worst, np.abs(wide - new_wide).max())
    for a, b in zip(points, new_points):
        worst = max(worst, np.abs(a - b).max())
    return "" if worst <= 1e-5 else f"off by {worst:g}"


def main():
    program = sys.argv[1]
    bad = total = 0
    with tempfile.TemporaryDirectory() as temporary:
        top = sys.argv[2] if len(sys.argv) > 2 else temporary
        os.makedirs(top, exist_ok=True)
        kinds = [("linear", "linear")] + [("cubic", basis) for basis in BASES]
        wraps, interpolations = ["nonperiodic", "periodic", "pinned"], ["constant", "uniform", "varying", "vertex"]
        for (kind, basis), wrap, interpolation, shared in itertools.product(kinds, wraps, interpolations, [False, True]):
            if wrap == "pinned" and basis in ("linear", "bezier"):
                continue
            name = f"{basis}_{wrap}_{interpolation}_{shared}"
            source = os.path.join(top, name + ".usda")
            if os.path.exists(source):
                os.remove(source)
            make(source, kind, basis, wrap, interpolation, shared)
            before = contents(source)
            for extension in ["usda", "usdc"]:
                total += 1
                target = os.path.join(top, f"{name}_out.{extension}")
                run = subprocess.run([program, "convert", source, target], capture_output=True, text=True)
                if run.returncode:
                    told = run.stderr.strip()
                else:
                    told = differences(before, contents(target), interpolation != "varying" or basis in ("linear", "bezier"))
                if told:
                    bad += 1
                    print(f"{name}.{extension}: {told}")
    print(f"{total - bad} of {total} stages agree")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
