# SPDX-License-Identifier: GPL-3.0-or-later
"""A room of 2 x 2 x 2 with coloured walls, a lamp and a ball of flat triangles, as OBJ or glTF, and where the ball is seen.

Flat triangles: no shading normals are in play. Corners go round counter-clockwise seen from inside the room and from
outside the ball. 
"""
import json
import os

import numpy as np

import interiors

SIZE = 96
CAMERA = ((0, 1, 0.95), (0, 0.9, -1), (0, 1, 0), 75, SIZE, SIZE)
LAMP = (4.0, 3.5, 3.0)
CENTRE, RADIUS = (0, 0.75, -0.3), 0.5


def gnurt_arguments():
    """The camera as arguments of gnurt."""
    return interiors.camera_arguments(CAMERA)


def ball(centre, radius, times=2):
    """A sphere as triangles, counter-clockwise seen from outside: (n, 3, 3)."""
    g = (1 + 5**0.5) / 2
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    unit = lambda v: v / np.linalg.norm(v)
    triangles = [[unit(np.array(corners[i], float)) for i in face] for face in faces]
    for _ in range(times):
        cut = []
        for a, b, c in triangles:
            ab, bc, ca = unit(a + b), unit(b + c), unit(c + a)
            cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = cut
    return np.array(triangles) * radius + np.array(centre)


def parts():
    """Everything but the ball's material: `interiors.Part`s, the last of which is the ball."""
    quad = lambda a, b, c, d: np.array([[a, b, c], [a, c, d]], float)
    walls = [
        ("floor", (0.6, 0.6, 0.6), quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))),
        ("ceiling", (0.7, 0.7, 0.7), quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1))),
        ("back", (0.5, 0.6, 0.7), quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1))),
        ("front", (0.5, 0.5, 0.5), quad((1, 0, 1), (-1, 0, 1), (-1, 2, 1), (1, 2, 1))),
        ("left", (0.7, 0.2, 0.1), quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1))),
        ("right", (0.1, 0.6, 0.2), quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1))),
        ("lamp", (0.0, 0.0, 0.0), quad((-0.8, 1.98, -0.8), (0.8, 1.98, -0.8), (0.8, 1.98, 0.8), (-0.8, 1.98, 0.8))),
        ("thing", (0.0, 0.0, 0.0), ball(CENTRE, RADIUS)),
    ]
    black = (0.0, 0.0, 0.0)
    return [
        interiors.Part(name, corners.astype(np.float32), None, colour, None, LAMP if name == "lamp" else black)
        for name, colour, corners in walls
    ]


def write_obj(folder, lines):
    """The room as OBJ; `lines` of MTL say what the ball is of."""
    base = os.path.join(folder, "room")
    with open(base + ".mtl", "w") as mtl, open(base + ".obj", "w") as obj:
        obj.write("mtllib room.mtl\n")
        for part in parts():
            triple = lambda key, v: key + " %g %g %g\n" % v
            material = lines if part.name == "thing" else triple("Kd", part.reflectance) + triple("Ke", part.emission)
            mtl.write(f"newmtl {part.name}\n{material}\n")
            obj.write(f"usemtl {part.name}\n")
            for triangle in part.corners:
                obj.writelines("v %.9g %.9g %.9g\n" % tuple(corner) for corner in triangle)
                obj.write("f -3 -2 -1\n")
    return base + ".obj"


def write_gltf(folder, material):
    """The room as glTF; `material` is the ball's, as glTF has it. Meshes without normals are flat."""
    base = os.path.join(folder, "room")
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "buffers": [], "extensionsUsed": []}
    document |= {"materials": [], "meshes": [], "nodes": [], "accessors": [], "bufferViews": []}
    data = b""
    for k, part in enumerate(parts()):
        points = part.corners.reshape(-1, 3).astype("<f4")
        bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
        view = {"buffer": 0, "byteOffset": len(data), "byteLength": points.nbytes}
        data += points.tobytes()
        matte = {
            "pbrMetallicRoughness": {"baseColorFactor": [*part.reflectance, 1], "metallicFactor": 0},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
        }
        if any(part.emission):
            strength = max(part.emission)
            matte["emissiveFactor"] = [e / strength for e in part.emission]
            matte["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        document["materials"].append(material if part.name == "thing" else matte)
        document["bufferViews"].append(view)
        document["accessors"].append({"bufferView": k, "componentType": 5126, "count": len(points), "type": "VEC3", **bounds})
        document["meshes"].append({"primitives": [{"attributes": {"POSITION": k}, "material": k}]})
        document["nodes"].append({"mesh": k})
        document["scenes"][0]["nodes"].append(k)
    used = {name for one in document["materials"] for name in one.get("extensions", {})}
    document["extensionsUsed"] = sorted(used)
    document["buffers"] = [{"uri": "room.bin", "byteLength": len(data)}]
    with open(base + ".bin", "wb") as file:
        file.write(data)
    with open(base + ".gltf", "w") as file:
        json.dump(document, file)
    return base + ".gltf"


def sees_ball():
    """Pixels whose middle sees the ball: (SIZE, SIZE) bools."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    eye, target = np.array(CAMERA[0]), np.array(CAMERA[1])
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up, scale = np.cross(right, forward), np.tan(np.radians(CAMERA[3] / 2)) * 2 / SIZE
    d = forward + (x + 0.5 - SIZE / 2)[..., None] * scale * right - (y + 0.5 - SIZE / 2)[..., None] * scale * up
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    to = np.array(CENTRE) - eye
    return np.linalg.norm(to - (d @ to)[..., None] * d, axis=-1) < 0.98 * RADIUS
