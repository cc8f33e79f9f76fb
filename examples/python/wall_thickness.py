#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The wall thickness of a mesh at each face: the distance along the inner normal to the opposite side.

pip install trimesh gnurt; wall_thickness.py [MESH] [COLOURED.ply]. Without a mesh, a hollow box with walls of 2 mm.
"""

import sys

import numpy as np
import trimesh

import gnurt


def hollow_box():
    """A box of 40 x 30 x 20 mm around a cavity; walls of 2 mm, a floor of 3 mm."""
    outer = trimesh.creation.box((40, 30, 20))
    inner = trimesh.creation.box((36, 26, 15))
    inner.apply_translation((0, 0, 0.5))
    inner.invert()
    return trimesh.util.concatenate([outer.subdivide().subdivide(), inner])


def thickness(mesh):
    """Thickness at the centre of each face; infinity where no side is opposite."""
    scene = gnurt.RayScene()
    scene.add_triangles(mesh.vertices, mesh.faces)
    inward = -mesh.face_normals
    # From a little inside, so that a ray leaves its own face behind.
    step = 1e-4 * mesh.scale
    hits = scene.intersect(mesh.triangles_center + step * inward, inward)
    return np.where(hits.prim_id >= 0, hits.t + step, np.inf)


def main():
    mesh = trimesh.load(sys.argv[1], force="mesh") if len(sys.argv) > 1 else hollow_box()
    found = thickness(mesh)
    known = found[np.isfinite(found)]
    print(f"{len(mesh.faces)} faces: thinnest {known.min():.3f}, median {np.median(known):.3f}")
    if len(sys.argv) > 2:
        mesh.visual.face_colors = trimesh.visual.interpolate(np.clip(found, 0, np.percentile(known, 95)), "viridis")
        mesh.export(sys.argv[2])


if __name__ == "__main__":
    main()
