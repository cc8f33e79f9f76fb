# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive subdivision: the length of edges that displaced surfaces are cut to.

Blender leaves the adaptive modifier to the renderer; what it evaluates is the mesh at the modifier's own levels. Displaced meshes are cut
further, in straight lines, until no edge is longer than the modifier asks for, seen from the camera at the middle of the object.
"""

import math

import numpy as np


def modifier_of(found):
    """The last modifier, if that subdivides adaptively in renders."""
    last = next((each for each in reversed(getattr(found, "modifiers", None) or ()) if each.show_render), None)
    return last if last is not None and last.type == "SUBSURF" and getattr(last, "use_adaptive_subdivision", False) else None


def longest_edge(export, found):
    """The longest edge of a displaced mesh, in its space; or None."""
    modifier = modifier_of(found)
    if modifier is None:
        return None
    matrix = np.array(found.matrix_world)
    scale = abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3) or 1.0
    if modifier.adaptive_space == "OBJECT":
        return max(float(modifier.adaptive_object_edge_length), 1e-6)
    camera = export.scene_data.camera
    if camera is None or camera.type != "CAMERA":
        return None
    corners = np.array([[*corner, 1.0] for corner in found.bound_box]) @ matrix.T
    eye = np.array(camera.matrix_world)[:3, 3]
    distance = float(np.linalg.norm(corners[:, :3].mean(axis=0) - eye))
    width = max(export.size)
    seen = camera.data.ortho_scale if camera.data.type == "ORTHO" else 2.0 * math.tan(camera.data.angle / 2.0) * distance
    return max(float(modifier.adaptive_pixel_size) * seen / width / scale, 1e-6)
