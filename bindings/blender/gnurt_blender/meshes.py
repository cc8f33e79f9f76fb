# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of an evaluated mesh: triangles, normals, and the attributes that its materials read.

Space: the object's. Attributes have names as `nodes.tree.Code.attribute` gives them ("uv:NAME", "named:NAME", ...).
"""

import numpy as np
from gnurt._gnurt import _divide_polygons


def flat(collection, name, dtype, width=1):
    """A property of all items of a collection as an array."""
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def whole(mesh, attribute, name, dtype, width, collection, other):
    """An attribute that every mesh has, or the property of the same values."""
    found = mesh.attributes.get(attribute)
    if found is not None and len(found.data) == len(collection):
        return flat(found.data, name, dtype, width)
    return flat(collection, other, dtype, width)


def triangulated(mesh, vertices, corners, totals):
    """The corners of triangles, (n, 3), their vertices and their polygons: as Blender divides them."""
    made = _divide_polygons(vertices, corners, totals)
    if made is not None:
        return made
    mesh.calc_loop_triangles()
    loops = flat(mesh.loop_triangles, "loops", np.int32, 3)
    # Triangles are in the order of their polygons.
    return loops, corners[loops], np.repeat(np.arange(len(totals), dtype=np.int32), totals - 2)


class MeshArrays:
    """What of a mesh does not depend on materials."""

    def __init__(self, mesh):
        self.mesh = mesh
        # Attributes are arrays that Blender copies as a whole; properties of triangles are computed one by one.
        self.vertices = whole(mesh, "position", "vector", np.float32, 3, mesh.vertices, "co")
        corners = whole(mesh, ".corner_vert", "value", np.int32, 1, mesh.loops, "vertex_index")
        totals = flat(mesh.polygons, "loop_total", np.int32)
        self.loops, self.faces, self.polygons = triangulated(mesh, self.vertices, corners, totals)
        slots = mesh.attributes.get("material_index")
        # Of each triangle; None where all have the first.
        self.slots = None
        if slots is not None and slots.domain == "FACE" and len(slots.data):
            self.slots = flat(slots.data, "value", np.int32)[self.polygons]
        self.normals = self._normals()

    def _normals(self):
        """Normals per vertex or corner; None where faces are flat."""
        mesh = self.mesh
        domain = getattr(mesh, "normals_domain", "CORNER")
        if domain == "FACE":
            return None
        if domain == "POINT":
            return flat(mesh.vertex_normals, "vector", np.float32, 3)
        return flat(mesh.corner_normals, "vector", np.float32, 3)[self.loops]

    def shading_normals(self):
        """Normals per vertex or corner, those of flat faces, too."""
        if self.normals is not None:
            return self.normals
        p = self.vertices[self.faces]
        faces = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        faces /= np.maximum(np.linalg.norm(faces, axis=1, keepdims=True), 1e-30)
        return np.repeat(faces[:, None], 3, axis=1)

    def uv(self, name):
        """Texture coordinates per corner, (triangles, 3, 2), or None."""
        layers = self.mesh.uv_layers
        layer = layers.get(name) if name else next((each for each in layers if each.active_render), None)
        if layer is None:
            return None
        return flat(layer.uv, "vector", np.float32, 2)[self.loops]

    def on_corners(self, values, domain):
        """Values of a domain, per corner."""
        if domain == "POINT":
            return values[self.faces]
        if domain == "CORNER":
            return values[self.loops]
        if domain == "FACE":
            return np.repeat(values[self.polygons][:, None], 3, axis=1)
        return None

    def values(self, name):
        """An attribute of any kind as colours and opacity per corner, (triangles, 3, 4), or None."""
        found = self.mesh.attributes.get(name)
        if found is None:
            coordinates = self.uv(name) if name in self.mesh.uv_layers else None
            return None if coordinates is None else padded(coordinates)
        kinds = {
            "FLOAT": ("value", 1),
            "INT": ("value", 1),
            "INT8": ("value", 1),
            "BOOLEAN": ("value", 1),
            "FLOAT_VECTOR": ("vector", 3),
            "FLOAT2": ("vector", 2),
            "FLOAT_COLOR": ("color", 4),
            "BYTE_COLOR": ("color", 4),
            "QUATERNION": ("value", 4),
        }
        if found.data_type not in kinds or len(found.data) == 0:
            return None
        prop, width = kinds[found.data_type]
        dtype = {"INT": np.int32, "INT8": np.int32, "BOOLEAN": bool}.get(found.data_type, np.float32)
        values = flat(found.data, prop, dtype, width).reshape(-1, width).astype(np.float32)
        corners = self.on_corners(values, found.domain)
        return None if corners is None else padded(corners)


def padded(values):
    """Four numbers: one is grey, two and three are a vector, and the fourth is 1."""
    shape = (*values.shape[:2], 4)
    made = np.zeros(shape, np.float32)
    made[..., 3] = 1.0
    width = values.shape[-1]
    if width == 1:
        made[..., :3] = values
    else:
        made[..., :width] = values
    return made


def tangents(arrays, name):
    """Tangent and side of each corner by texture coordinates, or None."""
    mesh = arrays.mesh
    layer = mesh.uv_layers.get(name) if name else next((each for each in mesh.uv_layers if each.active_render), None)
    if layer is None:
        return None
    try:
        mesh.calc_tangents(uvmap=layer.name)
    except RuntimeError:
        # Polygons with more than four corners have none by that call: the triangles' own.
        return triangle_tangents(arrays, name)
    tangent = flat(mesh.loops, "tangent", np.float32, 3)[arrays.loops]
    side = flat(mesh.loops, "bitangent_sign", np.float32)[arrays.loops][..., None]
    mesh.free_tangents()
    return tangent, side


def triangle_tangents(arrays, name):
    p, t = arrays.vertices[arrays.faces], arrays.uv(name)
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    d1, d2 = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    area = d1[:, 0] * d2[:, 1] - d2[:, 0] * d1[:, 1]
    tangent = (e1 * d2[:, 1:2] - e2 * d1[:, 1:2]) * np.sign(area)[:, None]
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-20)
    side = np.where(area < 0, -1.0, 1.0).astype(np.float32)
    return np.repeat(tangent[:, None], 3, axis=1), np.repeat(side[:, None, None], 3, axis=1)


def islands(arrays):
    """A random number for each connected part, per triangle corner."""
    count = len(arrays.vertices)
    label = np.arange(count)
    edges = np.concatenate([arrays.faces[:, :2], arrays.faces[:, 1:]])
    while True:
        low = np.minimum(label[edges[:, 0]], label[edges[:, 1]])
        new = label.copy()
        np.minimum.at(new, edges[:, 0], low)
        np.minimum.at(new, edges[:, 1], low)
        new = new[new]
        if np.array_equal(new, label):
            break
        label = new
    mixed = (label.astype(np.uint64) * np.uint64(2654435761) + np.uint64(12345)) % np.uint64(1 << 32)
    return (mixed / float(1 << 32)).astype(np.float32)[arrays.faces][..., None]


def pointiness(arrays):
    """How convex a vertex is: 0.5 is flat."""
    p, count = arrays.vertices, len(arrays.vertices)
    n = flat(arrays.mesh.vertex_normals, "vector", np.float32, 3)
    edges = flat(arrays.mesh.edges, "vertices", np.int32, 2)
    total, number = np.zeros((count, 3)), np.zeros(count)
    way = p[edges[:, 1]] - p[edges[:, 0]]
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-20)
    for side, sign in ((0, 1), (1, -1)):
        np.add.at(total, edges[:, side], sign * way)
        np.add.at(number, edges[:, side], 1)
    mean = total / np.maximum(number, 1)[:, None]
    angle = np.arccos(np.clip((n * mean).sum(axis=1), -1, 1)) / np.pi
    smooth, weight = angle.copy(), np.ones(count)
    for a, b in ((0, 1), (1, 0)):
        np.add.at(smooth, edges[:, a], angle[edges[:, b]])
        np.add.at(weight, edges[:, a], 1)
    return (smooth / weight).astype(np.float32)[:, None]


def attribute(arrays, name, warn):
    """The array of an attribute that a shader reads, or None."""
    kind, _, rest = name.partition(":")
    mesh = arrays.mesh
    if kind == "uv":
        found = arrays.uv(rest)
        return None if found is None else np.concatenate([found, np.zeros((*found.shape[:2], 1), np.float32)], axis=2)
    if kind in {"tangent", "side"}:
        found = tangents(arrays, rest)
        return None if found is None else found[0 if kind == "tangent" else 1]
    if kind in {"named", "alpha"}:
        found = arrays.values(rest)
        if found is None and kind == "named":
            warn(f"mesh '{mesh.name}': there is no attribute '{rest}'")
        return None if found is None else found[..., :3] if kind == "named" else found[..., 3:]
    if kind == "mean":
        found = arrays.values(rest)
        is_flat = found is not None and (rest in mesh.uv_layers or getattr(mesh.attributes.get(rest), "data_type", "") == "FLOAT2")
        return None if found is None else found[..., : 1 if is_flat else 3].mean(axis=-1, keepdims=True)
    if kind in {"color", "coloralpha"}:
        own = rest or (mesh.color_attributes[mesh.color_attributes.render_color_index].name if len(mesh.color_attributes) else "")
        found = arrays.values(own) if own else None
        if found is None and kind == "color":
            warn(f"mesh '{mesh.name}': there is no colour attribute '{rest}'")
        return None if found is None else found[..., :3] if kind == "color" else found[..., 3:]
    if kind == "island":
        return islands(arrays)
    if kind == "pointiness":
        return pointiness(arrays)
    if kind == "parametric":
        corners = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 0]], np.float32)
        return np.broadcast_to(corners, (len(arrays.faces), 3, 3)).copy()
    if kind == "bars":
        p = arrays.vertices[arrays.faces].astype(np.float64)
        area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
        made = np.zeros((len(p), 3, 3), np.float32)
        for k in range(3):
            base = np.linalg.norm(p[:, (k + 2) % 3] - p[:, (k + 1) % 3], axis=1)
            made[:, k, k] = area / np.maximum(base, 1e-20)
        return made
    if kind == "rest":
        return arrays.vertices
    if kind == "rest_normal":
        return arrays.shading_normals()
    if kind == "box_low":
        return np.tile(np.asarray(box(mesh)[0], np.float32), (len(arrays.vertices), 1))
    if kind == "box_scale":
        return np.tile(np.asarray(box(mesh)[1], np.float32), (len(arrays.vertices), 1))
    return None


def box(mesh):
    """The lower corner of the texture space, and one over its size."""
    where, size = np.array(mesh.texspace_location), np.array(mesh.texspace_size)
    size = np.where(np.abs(size) < 1e-12, 1.0, size)
    return where - size, 0.5 / size
