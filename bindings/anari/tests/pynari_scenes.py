#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten scenes through pynari, each checked by what must be seen in it.

    LD_LIBRARY_PATH=target/release python3 bindings/anari/tests/pynari_scenes.py [--out FOLDER]

Needs pynari and numpy; without them it says so and ends well.
"""

import argparse
import math
import os
import sys

try:
    import numpy as np
    import pynari as anari
except ImportError as missing:
    print(f"SKIPPED: {missing}; pip install pynari numpy")
    sys.exit(0)

SIZE = 96


class Scene:
    """A world before a camera at (0, 0, 5) that looks along -z and shows 2 x 2 of the plane z = 0."""

    def __init__(self, renderer="default", ambient=1.0, samples=32):
        self.device = anari.newDevice("gnurt")
        self.surfaces, self.lights, self.volumes = [], [], []
        self.camera = self.device.newCamera("orthographic")
        self.camera.setParameter("position", anari.float3, (0.0, 0.0, 5.0))
        self.camera.setParameter("direction", anari.float3, (0.0, 0.0, -1.0))
        self.camera.setParameter("up", anari.float3, (0.0, 1.0, 0.0))
        self.camera.setParameter("height", anari.FLOAT32, 2.0)
        self.camera.setParameter("aspect", anari.FLOAT32, 1.0)
        self.camera.commitParameters()
        self.renderer = self.device.newRenderer(renderer)
        self.renderer.setParameter("ambientRadiance", anari.FLOAT32, ambient)
        self.renderer.setParameter("pixelSamples", anari.INT32, samples)
        self.renderer.setParameter("background", anari.float4, (0.0, 0.0, 0.0, 0.0))
        self.renderer.commitParameters()

    def array(self, kind, values, dtype=np.float32):
        return self.device.newArray(kind, np.ascontiguousarray(values, dtype=dtype))

    def geometry(self, subtype, arrays=(), numbers=()):
        geometry = self.device.newGeometry(subtype)
        for name, kind, values, dtype in arrays:
            geometry.setParameter(name, anari.ARRAY, self.array(kind, values, dtype))
        for name, value in numbers:
            geometry.setParameter(name, anari.FLOAT32, value)
        geometry.commitParameters()
        return geometry

    def points(self, subtype, places, radius):
        arrays = [("vertex.position", anari.FLOAT32_VEC3, places, np.float32)]
        return self.geometry(subtype, arrays, [("radius", radius)])

    def material(self, subtype="matte", **parameters):
        material = self.device.newMaterial(subtype)
        for name, value in parameters.items():
            if isinstance(value, str):
                material.setParameter(name, anari.STRING, value)
            elif isinstance(value, (tuple, list)):
                material.setParameter(name, anari.float3, tuple(value))
            elif isinstance(value, float):
                material.setParameter(name, anari.FLOAT32, value)
            else:
                material.setParameter(name, anari.SAMPLER, value)
        material.commitParameters()
        return material

    def add(self, geometry, material):
        surface = self.device.newSurface()
        surface.setParameter("geometry", anari.GEOMETRY, geometry)
        surface.setParameter("material", anari.MATERIAL, material)
        surface.commitParameters()
        self.surfaces.append(surface)

    def light(self, subtype, **parameters):
        light = self.device.newLight(subtype)
        for name, value in parameters.items():
            kind = anari.float3 if isinstance(value, tuple) else anari.FLOAT32
            light.setParameter(name, kind, value)
        light.commitParameters()
        self.lights.append(light)

    def picture(self):
        """Linear colours, the lowest row first."""
        world = self.device.newWorld()
        for name, kind, values in (
            ("surface", anari.SURFACE, self.surfaces),
            ("light", anari.LIGHT, self.lights),
            ("volume", anari.VOLUME, self.volumes),
        ):
            if values:
                world.setParameterArray(name, kind, values)
        world.commitParameters()
        frame = self.device.newFrame()
        frame.setParameter("size", anari.uint2, (SIZE, SIZE))
        frame.setParameter("channel.color", anari.DATA_TYPE, anari.FLOAT32_VEC4)
        frame.setParameter("renderer", anari.OBJECT, self.renderer)
        frame.setParameter("camera", anari.OBJECT, self.camera)
        frame.setParameter("world", anari.OBJECT, world)
        frame.commitParameters()
        frame.render()
        return np.array(frame.get("channel.color"), dtype=np.float32).reshape(SIZE, SIZE, 4)


def covered(picture):
    """Area that something covers, over a background of nothing; the picture shows 4."""
    return 4.0 * float(picture[..., 3].mean())


def close(found, expected, share=0.02):
    assert abs(found - expected) <= share * abs(expected), f"{found}, expected {expected}"


SQUARE = [[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]]


def square(scene, extra=(), half=0.5):
    places = (np.array(SQUARE, dtype=np.float32) * (half / 0.5)).tolist()
    arrays = [
        ("vertex.position", anari.FLOAT32_VEC3, places, np.float32),
        ("primitive.index", anari.UINT32_VEC3, [[0, 1, 2], [0, 2, 3]], np.uint32),
    ]
    return scene.geometry("triangle", arrays + list(extra))


def spheres():
    scene = Scene()
    scene.add(scene.points("sphere", [[-0.5, 0, 0], [0.5, 0, 0]], 0.4), scene.material(color=(0.8, 0.4, 0.2)))
    picture = scene.picture()
    close(covered(picture), 2 * math.pi * 0.16)
    close(picture[SIZE // 2, SIZE // 4, 0], 0.8, 0.05)
    return picture


def cylinder():
    scene = Scene()
    scene.add(scene.points("cylinder", [[-0.6, 0, 0], [0.6, 0, 0]], 0.3), scene.material(color=(0.5, 0.5, 0.5)))
    picture = scene.picture()
    close(covered(picture), 1.2 * 0.6)
    return picture


def cone():
    scene = Scene()
    arrays = [
        ("vertex.position", anari.FLOAT32_VEC3, [[0, -0.5, 0], [0, 0.5, 0]], np.float32),
        ("vertex.radius", anari.FLOAT32, [0.6, 0.0], np.float32),
    ]
    scene.add(scene.geometry("cone", arrays), scene.material(color=(0.5, 0.7, 0.5)))
    picture = scene.picture()
    close(covered(picture), 0.6)
    return picture


def curve():
    scene = Scene()
    scene.add(scene.points("curve", [[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0]], 0.1), scene.material())
    picture = scene.picture()
    # Two rods that share a corner's square, and three quarters of a disc around it, two halves at the ends.
    close(covered(picture), 2 * 0.2 + math.pi * 0.01 * 1.25 - 0.01, 0.05)
    return picture


def vertex_colours():
    scene = Scene(renderer="ao")
    colours = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    extra = [("vertex.color", anari.FLOAT32_VEC3, colours, np.float32)]
    scene.add(square(scene, extra, 1.0), scene.material(color="color"))
    picture = scene.picture()
    for (row, column), colour in zip([(1, 1), (1, -2), (-2, -2), (-2, 1)], colours):
        assert np.allclose(picture[row, column, :3], colour, atol=0.06), (row, column, picture[row, column])
    return picture


def directional_light():
    scene = Scene(ambient=0.0)
    scene.add(square(scene, half=1.5), scene.material(color=(1.0, 0.5, 0.25)))
    scene.light("directional", direction=(0.0, -1.0, -1.0), irradiance=math.pi)
    picture = scene.picture()
    close(picture[..., 0].mean(), math.sqrt(0.5))
    close(picture[..., 2].mean(), 0.25 * math.sqrt(0.5))
    return picture


def point_light():
    scene = Scene(ambient=0.0)
    scene.add(square(scene, half=1.5), scene.material(color=(1.0, 1.0, 1.0)))
    scene.light("point", position=(0.0, 0.0, 2.0), intensity=4 * math.pi)
    picture = scene.picture()
    close(picture[SIZE // 2, SIZE // 2, 0], 1.0)
    assert picture[2, 2, 0] < 0.7, "it falls off"
    return picture


def furnace():
    scene = Scene()
    gold = scene.material("physicallyBased", baseColor=(1.0, 1.0, 1.0), metallic=1.0, roughness=0.3)
    scene.add(scene.points("sphere", [[0, 0, 0]], 0.8), gold)
    picture = scene.picture()
    inside = picture[SIZE // 2 - 8 : SIZE // 2 + 8, SIZE // 2 - 8 : SIZE // 2 + 8, :3]
    close(inside.mean(), 1.0, 0.03)
    return picture


def opacity():
    scene = Scene()
    glassy = scene.material(color=(1.0, 0.0, 0.0), opacity=0.5, alphaMode="blend")
    scene.add(square(scene, half=1.5), glassy)
    scene.renderer.setParameter("background", anari.float4, (0.0, 0.0, 1.0, 1.0))
    scene.renderer.commitParameters()
    picture = scene.picture()
    close(picture[..., 0].mean(), 0.5, 0.03)
    close(picture[..., 2].mean(), 0.5, 0.03)
    return picture


def volume():
    scene = Scene(ambient=0.0)
    field = scene.device.newSpatialField("structuredRegular")
    field.setParameter("data", anari.ARRAY, scene.array(anari.FLOAT32, np.full((4, 4, 4), 0.5)))
    field.setParameter("origin", anari.float3, (-0.5, -0.5, -0.5))
    field.setParameter("spacing", anari.float3, (1 / 3, 1 / 3, 1 / 3))
    field.commitParameters()
    fog = scene.device.newVolume("transferFunction1D")
    fog.setParameter("value", anari.SPATIAL_FIELD, field)
    fog.setParameter("color", anari.ARRAY, scene.array(anari.FLOAT32_VEC3, [[1, 0, 0], [1, 0, 0]]))
    fog.setParameter("opacity", anari.ARRAY, scene.array(anari.FLOAT32, [0.5, 0.5]))
    fog.setParameter("unitDistance", anari.FLOAT32, 0.5)
    fog.commitParameters()
    scene.volumes.append(fog)
    picture = scene.picture()
    close(picture[SIZE // 2, SIZE // 2, 0], 0.75)
    close(covered(picture), 0.75, 0.05)
    return picture


SCENES = [
    spheres,
    cylinder,
    cone,
    curve,
    vertex_colours,
    directional_light,
    point_light,
    furnace,
    opacity,
    volume,
]


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--out", help="save pictures in this folder, as numpy arrays")
    out = arguments.parse_args().out
    failed = 0
    for scene in SCENES:
        try:
            picture = scene()
            print(f"ok      {scene.__name__}")
            if out:
                os.makedirs(out, exist_ok=True)
                np.save(os.path.join(out, f"{scene.__name__}.npy"), picture)
        except Exception as fault:  # noqa: BLE001 - the others are to be run
            failed += 1
            print(f"FAILED  {scene.__name__}: {fault!r}")
    print(f"{len(SCENES) - failed} of {len(SCENES)} scenes")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
