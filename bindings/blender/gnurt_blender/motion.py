# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: places of objects and of the camera while the shutter is open.

Blender's frames are evaluated at a few moments before the export. Shapes that deform stay as they are in the middle.
"""

import numpy as np

from . import cameras

KEYS = 3


class Ways:
    """Matrices by instance at moments evenly spaced over the time that the shutter is open."""

    def __init__(self, engine, depsgraph, camera, size, warned):
        scene = depsgraph.scene
        frame, shutter = scene.frame_current + scene.frame_subframe, scene.render.motion_blur_shutter
        start = {"START": frame, "CENTER": frame - shutter / 2, "END": frame - shutter}[motion_position(scene)]
        self.cameras, self.instances = [], {}
        for key in range(KEYS):
            moment = start + shutter * key / (KEYS - 1)
            whole = int(np.floor(moment))
            engine.frame_set(whole, moment - whole)
            view = cameras.of_scene(depsgraph.scene, camera.evaluated_get(depsgraph), size, warned)
            self.cameras.append(view.camera)
            for instance in depsgraph.object_instances:
                persistent = tuple(instance.persistent_id) if instance.is_instance else ()
                matrix = np.array(instance.matrix_world, dtype=np.float64)
                self.instances.setdefault((instance.object.name, persistent), []).append(matrix)
        engine.frame_set(int(np.floor(frame)), frame - np.floor(frame))
        for found in scene.objects:
            if any(modifier.type in DEFORMING for modifier in found.modifiers) or getattr(found.data, "shape_keys", None):
                warned(f"object '{found.name}': shapes that deform are not blurred")

    def options(self, export):
        """The argument `motion` of `Scene.render`."""
        moving = {}
        for key, number in export.numbers.items():
            keys = self.instances.get(key, [])
            if len(keys) == KEYS and any(not np.allclose(keys[0], other) for other in keys[1:]):
                moving[number] = keys
        still = all(other == self.cameras[0] for other in self.cameras[1:])
        if not moving and still:
            return {}
        made = {"instances": moving} if moving else {}
        if not still:
            made["cameras"] = self.cameras
        return {"motion": made}


DEFORMING = {"ARMATURE", "CLOTH", "SOFT_BODY", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "HOOK", "LATTICE", "WAVE", "OCEAN"}


def motion_position(scene):
    own = getattr(scene.render, "motion_blur_position", None)
    return own or getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")
