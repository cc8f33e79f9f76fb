# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: places of objects and of the camera, and shapes of meshes, while the shutter is open.

Blender's frames are evaluated at a few moments before the export. Between them all moves straight on.
"""

import numpy as np

from . import cameras
from .meshes import MeshArrays

KEYS = 3


class Ways:
    """Matrices by instance at moments evenly spaced over the time that the shutter is open."""

    def __init__(self, engine, depsgraph, camera, size, warned):
        scene = depsgraph.scene
        frame, shutter = scene.frame_current + scene.frame_subframe, scene.render.motion_blur_shutter
        start = {"START": frame, "CENTER": frame - shutter / 2, "END": frame - shutter}[motion_position(scene)]
        self.cameras, self.instances, self.shapes = [], {}, {}
        for key in range(KEYS):
            moment = start + shutter * key / (KEYS - 1)
            whole = int(np.floor(moment))
            engine.frame_set(whole, moment - whole)
            view = cameras.of_scene(depsgraph.scene, camera.evaluated_get(depsgraph), size, warned)
            self.cameras.append(view.camera)
            for instance in depsgraph.object_instances:
                persistent = tuple(instance.persistent_id) if instance.is_instance else ()
                matrix = np.array(instance.matrix_world, dtype=np.float64)
                place = (instance.object.name, persistent)
                self.instances.setdefault(place, []).append(matrix)
                if may_bend(instance.object):
                    arrays = MeshArrays(instance.object.data)
                    self.shapes.setdefault(place, []).append((arrays.vertices, arrays.normals))
        engine.frame_set(int(np.floor(frame)), frame - np.floor(frame))

    def options(self, export):
        """The argument `motion` of `Scene.render`."""
        moving = {}
        for key, number in export.numbers.items():
            keys = self.instances.get(key, [])
            if len(keys) == KEYS and any(not np.allclose(keys[0], other) for other in keys[1:]):
                moving[number] = keys
        still = all(other == self.cameras[0] for other in self.cameras[1:])
        if not moving and still and not export.bent:
            return {}
        made = {"instances": moving} if moving else {}
        if export.bent:
            made["meshes"] = export.bent
        if not still:
            made["cameras"] = self.cameras
        return {"motion": made}


def may_bend(found):
    """Whether the vertices of an object may move within it."""
    return found.type == "MESH" and (len(found.modifiers) > 0 or getattr(found.data, "shape_keys", None) is not None)


def moments(shapes, arrays):
    """The argument `moments` of a mesh; None if it keeps its shape, or has other vertices at some moment."""
    if len(shapes) != KEYS or all(np.array_equal(shapes[0][0], vertices) for vertices, _ in shapes[1:]):
        return None
    if any(vertices.shape != arrays.vertices.shape for vertices, _ in shapes):
        return None
    made = {"vertices": [vertices for vertices, _ in shapes]}
    if arrays.normals is not None:
        if any(normals is None or normals.shape != arrays.normals.shape for _, normals in shapes):
            return None
        made["normals"] = [normals for _, normals in shapes]
    return made


def motion_position(scene):
    own = getattr(scene.render, "motion_blur_position", None)
    return own or getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")
