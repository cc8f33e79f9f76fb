# SPDX-License-Identifier: GPL-3.0-or-later
"""The pass Vector: motion of what is seen since the frame before (X, Y) and until the next one (Z, W), in pixels.

X, Y is the place in the frame before minus that in this one; Z, W is that in this one minus that in the next one. y points up.
"""

import numpy as np

from . import cameras
from .meshes import MeshArrays
from .motion import may_bend
from .passes import ID_INSTANCE, ID_PRIMITIVE


class Speeds:
    """Places of objects and cameras, and vertices of meshes, one frame before and after."""

    def __init__(self, engine, depsgraph, camera, size, warned):
        scene = depsgraph.scene
        frame = scene.frame_current + scene.frame_subframe
        self.size, self.views, self.places, self.shapes = size, [], [], {}
        for moment in (frame - 1, frame, frame + 1):
            whole = int(np.floor(moment))
            engine.frame_set(whole, moment - whole)
            self.views.append(cameras.of_scene(depsgraph.scene, camera.evaluated_get(depsgraph), size, warned))
            places = {}
            for instance in depsgraph.object_instances:
                persistent = tuple(instance.persistent_id) if instance.is_instance else ()
                places[instance.object.name, persistent] = np.array(instance.matrix_world, dtype=np.float64)
                if may_bend(instance.object):
                    arrays = MeshArrays(instance.object.data)
                    self.shapes.setdefault((instance.object.name, persistent), []).append((arrays.vertices, arrays.faces))
            self.places.append(places)
        engine.frame_set(int(np.floor(frame)), frame - np.floor(frame))

    def pixels(self, key, points):
        """Where points of the world are in the picture of a moment; directions have a fourth coordinate of 0."""
        view = self.views[key]
        seen = points @ (view.window_from_camera @ np.linalg.inv(view.world_from_camera)).T
        depth = seen[..., 3:]
        return seen[..., :2] / np.where(np.abs(depth) < 1e-12, 1e-12, depth) * self.size

    def of_picture(self, picture, export):
        """The pass, (height, width, 4)."""
        if export.view.parameters.get("kind", 0) >= 2:
            export.warn("the pass Vector of panoramas is empty")
            return np.zeros((*picture["depth"].shape, 4))
        hit = np.isfinite(picture["depth"])
        now = np.concatenate([picture["P"].astype(np.float64), np.ones((*hit.shape, 1))], axis=-1)
        now[~hit] = self.behind()[~hit]
        before, after = now.copy(), now.copy()
        instance, primitive = picture["id"][..., ID_INSTANCE], picture["id"][..., ID_PRIMITIVE].astype(int)
        for key, number in export.numbers.items():
            own = [places.get(key) for places in self.places]
            if any(place is None for place in own):
                continue
            shapes = self.bent(key)
            if shapes is None and all(np.array_equal(own[1], place) for place in own):
                continue
            there = hit & (instance == number)
            back = now[there] @ np.linalg.inv(own[1]).T
            first, last = (back, back) if shapes is None else carried(back, primitive[there], *shapes)
            before[there], after[there] = first @ own[0].T, last @ own[2].T
        at = self.pixels(1, now)
        return np.concatenate([self.pixels(0, before) - at, at - self.pixels(2, after)], axis=-1)

    def bent(self, key):
        """Triangles of a mesh, and its vertices before, now and after; None where it keeps its shape or has other vertices."""
        shapes = self.shapes.get(key, ())
        if len(shapes) != len(self.places):
            return None
        vertices, faces = [each for each, _ in shapes], [each for _, each in shapes]
        if any(each.shape != vertices[1].shape for each in vertices) or any(not np.array_equal(each, faces[1]) for each in faces):
            return None
        return None if all(np.array_equal(each, vertices[1]) for each in vertices) else (faces[1], vertices)

    def behind(self):
        """Directions to the world behind each pixel."""
        width, height = self.size
        view = self.views[1].parameters
        x = (np.arange(width) + 0.5) / width - 0.5
        y = 0.5 - (np.arange(height) + 0.5) / height
        x, y = np.meshgrid(x * view["wide"] + view["across"], y * view["high"] + view["up"])
        is_orthographic = view.get("kind", 0) == 1
        seen = np.stack([x * (not is_orthographic), y * (not is_orthographic), -np.ones_like(x), np.zeros_like(x)], axis=-1)
        return seen @ self.views[1].world_from_camera.T


def carried(points, primitives, faces, vertices):
    """Points of triangles, (n, 4), where these are before and after."""
    corners = faces[np.clip(primitives, 0, len(faces) - 1)]
    a, b, c = (vertices[1][corners[:, i]].astype(np.float64) for i in range(3))
    # Shares of the second and the third corner in the plane of the triangle.
    along, across, way = b - a, c - a, points[:, :3] - a
    aa, bb, ab = (along * along).sum(1), (across * across).sum(1), (along * across).sum(1)
    wa, wb = (way * along).sum(1), (way * across).sum(1)
    size = np.maximum(aa * bb - ab * ab, 1e-30)
    s, t = ((bb * wa - ab * wb) / size)[:, None], ((aa * wb - ab * wa) / size)[:, None]
    moved = []
    for shape in (vertices[0], vertices[2]):
        there = shape[corners[:, 0]] * (1 - s - t) + shape[corners[:, 1]] * s + shape[corners[:, 2]] * t
        moved.append(np.concatenate([there, np.ones((len(there), 1))], axis=1))
    return moved
