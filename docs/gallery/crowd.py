# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a crowd that walks in columns, a glTF of one skinned body in many skins: crowd.py OUT.glb

Each walker has joints of its own, which move in its column's rhythm; in a loop of one second it comes to where the next one was.
All bodies have the same triangles, so that their trees share what poses do not change (docs/explanation/moving.md). 
"""
import json
import math
import struct
import sys

COLUMNS, ROWS, SPACE, KEYS = 13, 15, 1.35, 16
COLORS = [(0.62, 0.16, 0.10), (0.10, 0.30, 0.46), (0.70, 0.48, 0.12), (0.16, 0.36, 0.20), (0.36, 0.20, 0.42)]
# Name, parent, place.
JOINTS = [
    ("hips", None, (0, 0.95, 0)), ("chest", 0, (0, 1.15, 0)), ("head", 1, (0, 1.52, 0)),
    ("arm left", 1, (0.22, 1.44, 0)), ("forearm left", 3, (0.25, 1.16, 0)),
    ("arm right", 1, (-0.22, 1.44, 0)), ("forearm right", 5, (-0.25, 1.16, 0)),
    ("thigh left", 0, (0.10, 0.93, 0)), ("shin left", 7, (0.10, 0.50, 0)),
    ("thigh right", 0, (-0.10, 0.93, 0)), ("shin right", 9, (-0.10, 0.50, 0)),
]


class Body:
    """Positions, normals, joints and weights, and triangles."""

    def __init__(self):
        self.positions, self.normals, self.joints, self.weights, self.indices = [], [], [], [], []

    def tube(self, rings, sides, at, two, share):
        """A closed tube: `at(along)` is its middle and two radii, `share(along)` how much it goes with the second of `two` joints."""
        first = len(self.positions)
        for ring in range(rings + 1):
            along = ring / rings
            (x, y, z), rx, rz = at(along)
            (_, above, _), ax, az = at(max(along - 1e-3, 0))
            (_, below, _), bx, bz = at(min(along + 1e-3, 1))
            slope = ((bx + bz) - (ax + az)) / 2 / ((below - above) or 1e-6)
            for side in range(sides):
                turn = math.tau * side / sides
                sin, cos = math.sin(turn), math.cos(turn)
                self.positions.append((x + rx * cos, y, z + rz * sin))
                normal = (cos / max(rx, 1e-3), -slope / max(rx, rz, 1e-3), sin / max(rz, 1e-3))
                size = math.sqrt(sum(c * c for c in normal))
                self.normals.append(tuple(c / size for c in normal))
                self.joints.append((two[0], two[1], 0, 0))
                self.weights.append((1 - share(along), share(along), 0, 0))
        for ring in range(rings):
            for side in range(sides):
                a, b = first + ring * sides + side, first + ring * sides + (side + 1) % sides
                c, d = a + sides, b + sides
                down = self.positions[c][1] < self.positions[a][1]
                self.indices += [a, b, d, a, d, c] if down else [a, d, b, a, c, d]


def smooth(low, high, x):
    t = min(max((x - low) / (high - low), 0), 1)
    return t * t * (3 - 2 * t)


def rounded(along, end=0.12):
    """1 in the middle, and little at both ends."""
    near = min(along, 1 - along) / end
    return max(math.sqrt(max(1 - (1 - near) ** 2, 0)), 0.04) if near < 1 else 1


def ball(along):
    return max(math.sqrt(max(1 - (2 * along - 1) ** 2, 0)), 0.04)


def body():
    made = Body()

    def limb(x, top, bottom, thick, thin, two, joint, depth=1.0):
        middle = (top - joint) / (top - bottom)
        at = lambda t: ((x, top + (bottom - top) * t, 0), *[rounded(t) * (thick + (thin - thick) * t) * k for k in (1, depth)])
        made.tube(16, 14, at, two, lambda t: smooth(middle - 0.1, middle + 0.1, t))

    torso = lambda t: ((0, 1.53 - 0.68 * t, 0), rounded(t, 0.2) * (0.21 - 0.05 * math.sin(math.pi * t)), rounded(t, 0.2) * 0.12)
    made.tube(16, 18, torso, (1, 0), lambda t: smooth(0.4, 0.9, t))
    head = lambda t: ((0, 1.86 - 0.30 * t, 0.01), 0.115 * ball(t), 0.13 * ball(t))
    made.tube(14, 16, head, (2, 2), lambda t: 0)
    made.tube(4, 12, lambda t: ((0, 1.62 - 0.14 * t, 0), 0.055, 0.055), (2, 1), lambda t: t)
    for sign, arm, leg in ((1, 3, 7), (-1, 5, 9)):
        limb(0.235 * sign, 1.50, 0.82, 0.062, 0.04, (arm, arm + 1), 1.16)
        limb(0.10 * sign, 1.00, 0.03, 0.095, 0.055, (leg, leg + 1), 0.50)
        foot = lambda t: ((0.10 * sign, 0.085 - 0.08 * t, 0.07), rounded(t, 0.5) * 0.05, rounded(t, 0.5) * 0.13)
        made.tube(6, 14, foot, (leg + 1, leg + 1), lambda t: 0)
    return made


def gait(phase):
    """Angles about the axis across, by joint, and how high the hips are."""
    turn = math.tau * phase
    swing = math.sin(turn)
    bent = lambda p: 0.15 + 0.95 * max(math.sin(math.tau * p), 0) ** 2
    angles = {
        3: 0.6 * swing, 4: -0.35 - 0.25 * swing, 5: -0.6 * swing, 6: -0.35 + 0.25 * swing,
        7: -0.52 * swing, 8: bent(phase + 0.25), 9: 0.52 * swing, 10: bent(phase + 0.75), 1: 0.06, 2: -0.04,
    }
    return angles, 0.93 + 0.022 * math.cos(2 * turn)


class File:
    def __init__(self):
        self.data, self.views, self.accessors = bytearray(), [], []

    def add(self, rows, kind, code="f", target=None, bounds=False):
        """An accessor over rows of numbers."""
        while len(self.data) % 4:
            self.data.append(0)
        flat = [x for row in rows for x in row]
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(flat) * struct.calcsize(code)}
        if target:
            view["target"] = target
        self.data += struct.pack(f"<{len(flat)}{code}", *flat)
        self.views.append(view)
        accessor = {"bufferView": len(self.views) - 1, "count": len(rows), "type": kind}
        accessor["componentType"] = {"f": 5126, "I": 5125, "B": 5121}[code]
        if bounds:
            single = [struct.unpack("<f", struct.pack("<f", x))[0] for x in flat]
            width = len(rows[0])
            accessor["min"] = [min(single[i::width]) for i in range(width)]
            accessor["max"] = [max(single[i::width]) for i in range(width)]
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def main(out):
    made, file = body(), File()
    attributes = {
        "POSITION": file.add(made.positions, "VEC3", target=34962, bounds=True),
        "NORMAL": file.add(made.normals, "VEC3", target=34962),
        "JOINTS_0": file.add(made.joints, "VEC4", "B", 34962),
        "WEIGHTS_0": file.add(made.weights, "VEC4", target=34962),
    }
    indices = file.add([(i,) for i in made.indices], "SCALAR", "I", 34963)
    unbound = [(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1) for _, _, (x, y, z) in JOINTS]
    unbound = file.add(unbound, "MAT4")
    times = file.add([(k / KEYS,) for k in range(KEYS + 1)], "SCALAR", bounds=True)
    materials, meshes = [], []
    for color in COLORS:
        materials.append({"pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0, "roughnessFactor": 0.55}})
        meshes.append({"primitives": [{"attributes": attributes, "indices": indices, "material": len(materials) - 1}]})
    reach = 60
    floor = [(-reach, 0, -reach), (-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach)]
    floor = {"POSITION": file.add(floor, "VEC3", bounds=True), "NORMAL": file.add([(0, 1, 0)] * 4, "VEC3")}
    materials.append({"pbrMetallicRoughness": {"baseColorFactor": [0.42, 0.40, 0.37, 1], "metallicFactor": 0, "roughnessFactor": 0.9}})
    square = file.add([(i,) for i in (0, 1, 2, 0, 2, 3)], "SCALAR", "I")
    meshes.append({"primitives": [{"attributes": floor, "indices": square, "material": len(materials) - 1}]})

    tilt = math.radians(-20)
    nodes = [
        {"name": "floor", "mesh": len(meshes) - 1},
        {"name": "camera", "camera": 0, "translation": [1.2, 5.0, 11.5], "rotation": [math.sin(tilt / 2), 0, 0, math.cos(tilt / 2)]},
        {"name": "sun", "rotation": [-0.38, 0.33, 0.15, 0.85], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]
    skins, samplers, channels = [], [], []

    def sampler(rows, kind):
        samplers.append({"input": times, "output": file.add(rows, kind), "interpolation": "LINEAR"})
        return len(samplers) - 1

    for column in range(COLUMNS):
        phase = (column * 0.381966) % 1
        poses = [gait(phase + k / KEYS) for k in range(KEYS + 1)]
        turns = {}
        for joint in range(1, len(JOINTS)):
            halves = [angles[joint] / 2 for angles, _ in poses]
            turns[joint] = sampler([(math.sin(half), 0, 0, math.cos(half)) for half in halves], "VEC4")
        for row in range(ROWS):
            x, z = (column - (COLUMNS - 1) / 2) * 1.05, (row + phase) * SPACE - 13
            first = len(nodes)
            for joint, (name, parent, place) in enumerate(JOINTS):
                at = [a - b for a, b in zip(place, JOINTS[parent][2])] if parent is not None else [x, place[1], z]
                children = [first + i for i, (_, other, _) in enumerate(JOINTS) if other == joint]
                nodes.append({"name": name, "translation": at} | ({"children": children} if children else {}))
                if joint:
                    channels.append({"sampler": turns[joint], "target": {"node": first + joint, "path": "rotation"}})
            way = sampler([(x, high, z + SPACE * k / KEYS) for k, (_, high) in enumerate(poses)], "VEC3")
            channels.append({"sampler": way, "target": {"node": first, "path": "translation"}})
            skins.append({"inverseBindMatrices": unbound, "joints": list(range(first, first + len(JOINTS))), "skeleton": first})
            nodes.append({"mesh": column % len(COLORS), "skin": len(skins) - 1})
    inner = {child for node in nodes for child in node.get("children", [])}
    text = json.dumps({
        "asset": {"version": "2.0", "generator": "crowd.py"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 4, "color": [1, 0.93, 0.82]}]}},
        "scene": 0, "scenes": [{"nodes": [i for i in range(len(nodes)) if i not in inner]}],
        "nodes": nodes, "meshes": meshes, "materials": materials, "skins": skins,
        "cameras": [{"type": "perspective", "perspective": {"yfov": math.radians(30), "znear": 0.1}}],
        "animations": [{"name": "walk", "samplers": samplers, "channels": channels}],
        "accessors": file.accessors, "bufferViews": file.views, "buffers": [{"byteLength": len(file.data)}],
    }, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    file.data += b"\0" * (-len(file.data) % 4)
    with open(out, "wb") as glb:
        glb.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(file.data)))
        glb.write(struct.pack("<I4s", len(text), b"JSON") + text)
        glb.write(struct.pack("<I4s", len(file.data), b"BIN\0") + file.data)


if __name__ == "__main__":
    main(sys.argv[1])
