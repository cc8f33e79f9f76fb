# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the benchmark interiors as `gnurt --force-diffuse` shows them: triangles by material, reflectance, emission, camera.

Source: original; the rules are those of the reference images: flat normals, reflectance Kd times map_Kd, Ke leaves the
side that the triangle's corners go round counter-clockwise.
"""
import os
from dataclasses import dataclass

import numpy as np

# Scene: eye, target, up, vertical field of view in degrees, columns, rows.
CAMERAS = {
    "cornell-box": ((0, 1, 6.8), (0, 1, 0), (0, 1, 0), 19.5, 192, 192),
    "office": ((2.1, 3.2, 2.0), (-1.2, 1.9, -0.8), (0, 1, 0), 50, 256, 192),
    "conference": ((30, 21, 7), (26.1962, 17.9239, 5.9663), (0, 0, 1), 36.4, 256, 192),
    "modern-hall": ((6.9118, 1.6516, 2.5541), (2.4108, 1.6516, 0.3766), (0, 1, 0), 43, 256, 192),
    "veach-bidir": ((16.2155, 4.0517, 0.0115), (6.2155, 4.0047, -0.0385), (0, 1, 0), 35, 192, 192),
}


@dataclass
class Part:
    """The triangles of a material: three corners each, float32 (n, 3, 3); texture coordinates (n, 3, 2) or None."""

    name: str
    corners: np.ndarray
    texcoords: np.ndarray | None
    reflectance: tuple
    texture: str | None
    emission: tuple


def gnurt_arguments(scene):
    """The scene's camera as arguments of gnurt."""
    return camera_arguments(CAMERAS[scene])


def camera_arguments(camera):
    """A camera as arguments of gnurt."""
    eye, target, up, fov, width, height = camera
    join = lambda v: ",".join(map(str, v))
    return ["--eye=" + join(eye), "--target=" + join(target), "--up=" + join(up), f"--fov={fov}", f"-r={width}x{height}"]


def read_materials(path):
    materials, current = {}, None
    for line in open(path, errors="replace"):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "newmtl":
            current = materials.setdefault(words[1], {"Kd": (0.6, 0.6, 0.6), "Ke": (0, 0, 0), "map_Kd": None})
        elif words[0] in ("Kd", "Ke"):
            current[words[0]] = tuple(map(float, words[1:4]))
        elif words[0] == "map_Kd":
            current["map_Kd"] = os.path.join(os.path.dirname(path), words[-1])
    return materials


def read(folder, scene):
    """The parts of FOLDER/SCENE/SCENE.obj."""
    base = os.path.join(folder, scene, scene)
    materials = read_materials(base + ".mtl")
    points, texcoords, faces, current = [], [], {}, None
    for line in open(base + ".obj", errors="replace"):
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            points.append(tuple(map(float, words[1:4])))
        elif words[0] == "vt":
            texcoords.append(tuple(map(float, words[1:3])))
        elif words[0] == "usemtl":
            current = words[1]
        elif words[0] == "f":
            corners = [(w.split("/") + [""])[:2] for w in words[1:]]
            index = lambda text, count: int(text) - 1 if int(text) > 0 else count + int(text)
            corners = [(index(v, len(points)), index(t, len(texcoords)) if t else -1) for v, t in corners]
            for k in range(1, len(corners) - 1):
                faces.setdefault(current, []).append((corners[0], corners[k], corners[k + 1]))
    points, texcoords = np.array(points, np.float32), np.array(texcoords + [(0, 0)], np.float32)
    parts = []
    for name, triangles in faces.items():
        index = np.array(triangles)
        material = materials[name]
        textured = material["map_Kd"] is not None
        parts.append(
            Part(
                name,
                points[index[:, :, 0]],
                texcoords[index[:, :, 1]] if textured else None,
                material["Kd"],
                material["map_Kd"],
                material["Ke"],
            )
        )
    return parts


def rel_mse(picture, reference, variance):
    """Mean over pixels and channels of the squared error over the squared reference, less what the reference's own noise
    makes of it; and the same without the worst thousandth of the pixels."""
    error = ((picture - reference) ** 2 - variance) / (reference**2 + 1e-2)
    pixels = np.sort(error.mean(axis=-1).ravel())
    return pixels.mean(), pixels[: len(pixels) * 999 // 1000].mean()
