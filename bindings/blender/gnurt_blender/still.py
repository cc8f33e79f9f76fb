# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that are as they were in the last frame, by Blender's list of updates: with persistent data they are not read again.

Only within an animation: for a picture of its own Blender lists all that the scene has.
"""

import bpy

# What changes no mesh and no material.
HARMLESS = (bpy.types.Object, bpy.types.Mesh, bpy.types.Key, bpy.types.Action, bpy.types.Camera, bpy.types.Light)


class Still:
    """What Blender has evaluated since the last frame. `follows` says whether its scene is there."""

    def __init__(self, depsgraph, follows):
        updates = list(depsgraph.updates) if follows else []
        self.follows = follows and all(isinstance(update.id, HARMLESS) for update in updates)
        self.changed = {
            update.id.original.as_pointer()
            for update in updates
            if isinstance(update.id, bpy.types.Mesh) or update.is_updated_geometry or update.is_updated_shading
        }

    def has(self, instance, found):
        """Whether the mesh of an object is the last frame's."""
        if not self.follows or found.type != "MESH" or instance.is_instance:
            return False
        return not self.changed & {found.original.as_pointer(), found.data.original.as_pointer()}
