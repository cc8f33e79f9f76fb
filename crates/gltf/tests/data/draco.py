# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes draco-*.glb, compressed, and draco-*-plain.glb, with the values that Google's decoder finds in them: the oracle of draco.rs.

    python3 draco.py     (numpy, DracoPy 2.2; in this folder)
"""
import json, struct
import DracoPy
import numpy as np

rng = np.random.default_rng(5)
UNITS = {np.dtype(np.uint8): 5121, np.dtype(np.uint16): 5123, np.dtype(np.uint32): 5125, np.dtype(np.float32): 5126}
SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def torus(n, m, missing=0.0):
    """A torus of 2 n m triangles, some of them missing."""
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    points = np.stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)], -1).reshape(-1, 3)
    corner = lambda i, j: (i % n) * m + j % m
    faces = []
    for i in range(n):
        for j in range(m):
            a, b, c, d = corner(i, j), corner(i, j + 1), corner(i + 1, j), corner(i + 1, j + 1)
            faces += [[a, c, b], [b, c, d]]
    faces = np.array(faces, np.uint32)
    return points.astype(np.float32), faces[rng.random(len(faces)) >= missing]


def seams(points, faces, share):
    """Some triangles get corners of their own."""
    points, faces = list(points), faces.copy()
    for face in faces:
        if rng.random() < share:
            for k in range(3):
                points.append(points[face[k]])
                face[k] = len(points) - 1
    return np.array(points, np.float32), faces


def used(points, faces):
    numbers, faces = np.unique(faces, return_inverse=True)
    return points[numbers], faces.reshape(-1, 3).astype(np.uint32)


class File:
    def __init__(self):
        self.binary, self.views, self.accessors = b"", [], []

    def view(self, data):
        self.binary += bytes(-len(self.binary) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        return len(self.views) - 1

    def accessor(self, array, stored, **more):
        array = array.reshape(len(array), -1)
        entry = {"componentType": UNITS[array.dtype], "count": len(array), "type": SHAPES[array.shape[1]], **more}
        if stored:
            entry["bufferView"] = self.view(array.tobytes())
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def write(self, name, root):
        root = {"asset": {"version": "2.0"}, **root, "accessors": self.accessors, "bufferViews": self.views,
                "buffers": [{"byteLength": len(self.binary)}]}
        text = json.dumps(root, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + bytes(-len(self.binary) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
        with open(name, "wb") as out:
            out.write(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)


NAMES = {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2, "TEXCOORD_0": 3}


def write(name, points, faces, level, bits, joints=None, weights=None, morph=None, fallback=False, **more):
    generic = {} if joints is None else {40: joints, 41: weights}
    stream = DracoPy.encode(points, faces, quantization_bits=bits, compression_level=level,
                            generic_attributes=generic or None, **more)
    mesh = DracoPy.decode(stream)
    found = {}
    for entry in mesh.attributes:
        key = {40: "JOINTS_0", 41: "WEIGHTS_0"}.get(entry["unique_id"]) or next(
            n for n, kind in NAMES.items() if kind == entry["attribute_type"])
        found[key] = (entry["unique_id"], np.asarray(entry["data"]))
    count = len(mesh.points)
    for packed in (True, False):
        file = File()
        normal = lambda key: {"normalized": True} if key == "COLOR_0" else {}
        attributes = {key: file.accessor(data, not packed, **normal(key)) for key, (_, data) in found.items()}
        primitive = {"attributes": attributes, "material": 0,
                     "indices": file.accessor(mesh.faces.astype(np.uint32).ravel(), not packed)}
        root = {"materials": [{}], "nodes": [{"mesh": 0}], "extensionsUsed": [], "extensionsRequired": []}
        if packed:
            ids = {key: number for key, (number, _) in found.items()}
            primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": file.view(stream), "attributes": ids}}
            root["extensionsUsed"] = ["KHR_draco_mesh_compression"]
            root["extensionsRequired"] = [] if fallback else ["KHR_draco_mesh_compression"]
            if fallback:
                other = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
                primitive["attributes"] = {"POSITION": file.accessor(other, True)}
                primitive["indices"] = file.accessor(np.arange(3, dtype=np.uint32), True)
        if morph is not None:
            move = np.sin(np.arange(3 * count, dtype=np.float32)).reshape(-1, 3)
            primitive["targets"] = [{"POSITION": file.accessor(move, True)}]
        if joints is not None:
            root["nodes"] = [{"mesh": 0, "skin": 0}, {"translation": [1, 2, 3]}, {"scale": [2, 1, 1]}]
            root["scenes"], root["scene"] = [{"nodes": [0, 1, 2]}], 0
            root["skins"] = [{"joints": [1, 2]}]
        root["meshes"] = [{"primitives": [primitive], **({"weights": [morph]} if morph is not None else {})}]
        file.write(f"draco-{name}{'' if packed else '-plain'}.glb", root)
    print(name, len(stream), "bytes", len(mesh.faces), "triangles", count, "vertices")


def unit(vectors):
    return (vectors / np.linalg.norm(vectors, axis=1, keepdims=True)).astype(np.float64)


p, f = used(*torus(6, 5, 0.1))
write("sequential", p, f, 0, 12, colors=rng.integers(0, 256, (len(p), 4)).astype(np.uint8),
      tex_coord=p[:, :2].astype(np.float64), normals=unit(p), normal_quantization_bits=10)
p, f = used(*seams(*torus(9, 6, 0.2), 0.2))
share = rng.random(len(p)).astype(np.float32)
write("standard", p, f, 5, 11, joints=rng.integers(0, 2, (len(p), 4)).astype(np.uint8), morph=0.5,
      weights=np.stack([share, 1 - share, 0 * share, 0 * share], 1),
      tex_coord=p[:, :2].astype(np.float64), tex_coord_quantization_bits=10)
p, f = torus(36, 15, 0.02)
write("valence", *used(p, f), 10, 9, tex_coord=used(p, f)[0][:, :2].astype(np.float64) / 4, tex_coord_quantization_bits=9,
      normals=unit(used(p, f)[0]), normal_quantization_bits=8)
p, f = used(*torus(5, 4))
write("fallback", p, f, 7, 10, fallback=True)
