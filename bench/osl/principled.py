#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A principled material in the shading language against the built-in one: the same picture, user seconds by turns.

    bench/osl/principled.py target/release/gnurt [--turns 5] [--spp 16] [--texture | --varying] [--shader FILE.osl]

Three balls and a floor: coat over sheen over plastic, half metal, 0.7 solid glass, plastic. Another shader must take the parameters of
shaders/surfaces/principled.osl; its picture may be another one. With --texture the base colour is a picture in both, times the
material's; with --varying the shader's base colour is `base + 0 * P[0]`, so that nobody can know that it is the same everywhere.
"""

import argparse
import base64
import json
import math
import pathlib
import re
import resource
import statistics
import struct
import subprocess
import tempfile
import zlib

OWN = pathlib.Path(__file__).resolve().parents[2] / "shaders/surfaces/principled.osl"

# glTF's numbers, and the same for the shader.
MATERIALS = [
    (
        dict(baseColorFactor=[0.6, 0.1, 0.08, 1], metallicFactor=0, roughnessFactor=0.4),
        dict(
            KHR_materials_clearcoat=dict(clearcoatFactor=1, clearcoatRoughnessFactor=0.1),
            KHR_materials_sheen=dict(sheenColorFactor=[0.1, 0.1, 0.2], sheenRoughnessFactor=0.5),
        ),
        "base=.6,.1,.08:roughness=.4:coat=1:coat_roughness=.1:sheen=.1,.1,.2:sheen_roughness=.5",
    ),
    (
        dict(baseColorFactor=[0.8, 0.6, 0.3, 1], metallicFactor=0.5, roughnessFactor=0.3),
        {},
        "base=.8,.6,.3:metallic=.5:roughness=.3",
    ),
    (
        dict(baseColorFactor=[0.7, 0.9, 0.8, 1], metallicFactor=0, roughnessFactor=0.2),
        dict(
            KHR_materials_transmission=dict(transmissionFactor=0.7),
            KHR_materials_volume=dict(thicknessFactor=1),
        ),
        "base=.7,.9,.8:roughness=.2:transmission=.7",
    ),
    (dict(baseColorFactor=[0.5, 0.5, 0.5, 1], metallicFactor=0, roughnessFactor=0.6), {}, "base=.5,.5,.5:roughness=.6"),
]


def ball(x, columns=48, rows=24, radius=0.5):
    """Positions, normals, texture coordinates, indices."""
    positions, normals, uv, indices = [], [], [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            theta, phi = math.pi * j / rows, 2 * math.pi * i / columns
            n = (math.sin(theta) * math.cos(phi), math.cos(theta), -math.sin(theta) * math.sin(phi))
            positions.append((x + radius * n[0], radius + radius * n[1], radius * n[2]))
            normals.append(n)
            uv.append((i / columns, j / rows))
            if j < rows and i < columns:
                a = j * (columns + 1) + i
                b = a + columns + 1
                indices += [a, b, a + 1, a + 1, b, b + 1]
    return positions, normals, uv, indices


def picture(side=256):
    """A colourful PNG, sRGB-encoded."""
    rows = bytearray()
    for y in range(side):
        rows.append(0)
        for x in range(side):
            check = 40 if (x // 16 + y // 16) % 2 else 0
            rows += bytes((255 - check - x // 4, 255 - check - y // 4, 160 + (x ^ y) % 96))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    parts = [chunk(b"IHDR", head), chunk(b"IDAT", zlib.compress(bytes(rows))), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def with_base(text, value):
    """The shader's text with another value in place of its parameter `base`."""
    head, body = text.split("\n{\n", 1)
    return head + "\n{\n    color body = " + value + ";\n" + re.sub(r"\bbase\b", "body", body)


def scene(is_textured):
    """The scene as glTF."""
    corners = [(-6, 0, -6), (-6, 0, 6), (6, 0, 6), (6, 0, -6)]
    floor = (corners, [(0, 1, 0)] * 4, [(0, 0), (0, 1), (1, 1), (1, 0)], [0, 1, 2, 0, 2, 3])
    data, views, accessors, meshes = b"", [], [], []

    def add(values, kind, code, word):
        nonlocal data
        flat = [x for value in values for x in (value if isinstance(value, tuple) else (value,))]
        packed = struct.pack(f"<{len(flat)}{word}", *flat)
        views.append(dict(buffer=0, byteOffset=len(data), byteLength=len(packed)))
        data += packed
        accessors.append(dict(bufferView=len(views) - 1, componentType=code, count=len(values), type=kind))
        if kind == "VEC3":
            accessors[-1].update(min=list(map(min, zip(*values))), max=list(map(max, zip(*values))))
        return len(accessors) - 1

    for number, (positions, normals, uv, indices) in enumerate([ball(-1.1), ball(0), ball(1.1), floor]):
        attributes = dict(
            POSITION=add(positions, "VEC3", 5126, "f"),
            NORMAL=add(normals, "VEC3", 5126, "f"),
            TEXCOORD_0=add(uv, "VEC2", 5126, "f"),
        )
        primitive = dict(attributes=attributes, indices=add(indices, "SCALAR", 5125, "I"), material=number)
        meshes.append(dict(primitives=[primitive]))
    materials = [
        dict(name=f"m{i}", pbrMetallicRoughness=plain, extensions=more) for i, (plain, more, _) in enumerate(MATERIALS)
    ]
    more = {}
    if is_textured:
        # What lies beyond the border is not the same in both.
        more = dict(images=[dict(uri="base.png")], samplers=[dict(wrapS=33071, wrapT=33071)], textures=[dict(source=0, sampler=0)])
        for material in materials:
            material["pbrMetallicRoughness"] = dict(material["pbrMetallicRoughness"], baseColorTexture=dict(index=0))
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return dict(
        **more,
        asset=dict(version="2.0"),
        extensionsUsed=sorted({name for _, more, _ in MATERIALS for name in more}),
        scene=0,
        scenes=[dict(nodes=[0, 1, 2, 3])],
        nodes=[dict(mesh=i) for i in range(4)],
        meshes=meshes,
        materials=materials,
        accessors=accessors,
        bufferViews=views,
        buffers=[dict(byteLength=len(data), uri=uri)],
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("gnurt")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--shader", default=str(OWN))
    parser.add_argument("--keep", help="folder that the scene and the last pictures are kept in")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--texture", action="store_true")
    kind.add_argument("--varying", action="store_true")
    given = parser.parse_args()
    view = "--eye 0,1.6,4 --target 0,0.45,0 --fov 34 --environment builtin:day -r 240x135 --denoise=none --max-depth 8 -t 1"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(given.keep or folder)
        folder.mkdir(exist_ok=True)
        (folder / "balls.gltf").write_text(json.dumps(scene(given.texture)))
        shader = given.shader
        if given.texture or given.varying:
            value = 'base * texture ("base.png", u, 1 - v)' if given.texture else "base + 0 * P[0]"
            shader = folder / "principled.osl"
            shader.write_text(with_base(pathlib.Path(given.shader).read_text(), value))
            (folder / "base.png").write_bytes(picture())
        kinds = {"built in": [], "the language": []}
        for i, (_, _, values) in enumerate(MATERIALS):
            kinds["the language"] += ["--shader", f"m{i}={shader}:{values}"]
        times, pictures = {kind: [] for kind in kinds}, {}
        for _ in range(given.turns):
            for kind, shaders in kinds.items():
                before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                out = folder / f"{kind.replace(' ', '-')}.png"
                command = [given.gnurt, "render", folder / "balls.gltf", *view.split(), "--spp", str(given.spp), "-o", out]
                subprocess.run(command + shaders, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                times[kind].append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
                pictures[kind] = out.read_bytes()
    for kind, list_of in times.items():
        print(f"{kind:13}", " ".join(f"{t:.2f}" for t in list_of), f"median {statistics.median(list_of):.2f} user s")
    medians = [statistics.median(times[kind]) for kind in ("the language", "built in")]
    least = [min(times[kind]) for kind in ("the language", "built in")]
    print(f"ratio of medians {medians[0] / medians[1]:.2f}, of the least {least[0] / least[1]:.2f}")
    print("the same picture" if pictures["built in"] == pictures["the language"] else "another picture")


if __name__ == "__main__":
    main()
