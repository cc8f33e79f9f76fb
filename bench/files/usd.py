# SPDX-License-Identifier: GPL-3.0-or-later
"""`usd.py FILE COUNT`: as src/main.rs, by OpenUSD (the package usd-core): all meshes' points, faces and normals as arrays."""

import sys
import time

import numpy as np
from pxr import Usd, UsdGeom

for _ in range(int(sys.argv[2])):
    begin = time.perf_counter()
    stage = Usd.Stage.Open(sys.argv[1])
    triangles = 0
    # A scene has all of them.
    kept = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get())
            kept += [np.asarray(mesh.GetPointsAttr().Get()), counts, np.asarray(mesh.GetFaceVertexIndicesAttr().Get()),
                     mesh.GetNormalsAttr().Get()]
            st = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
            if st.HasValue():
                kept.append(st.Get())
            triangles += int((counts - 2).sum())
    print(f"{time.perf_counter() - begin:.6f} {triangles}")
    del stage, kept
