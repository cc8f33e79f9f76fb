# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses glTF files in double precision and prints figures of the posed triangles' corners: the oracle of animated_scenes.rs.

    python3 pose.py FOLDER > animated.json     (numpy; FOLDER = ../shared/scenes/animated, unpacked)

Written from the glTF 2.0 specification alone; knows nothing of GNU RT."""
import base64, json, struct, sys
from pathlib import Path
import numpy as np

FILES = ["CesiumMan.glb", "Fox.glb", "MorphStressTest.gltf", "Stag.gltf", "Rabbit.gltf", "Alien_Scolitex.gltf"]
TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
SHAPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

class File:
    def __init__(self, path):
        data, binary = path.read_bytes(), None
        if data[:4] == b"glTF":
            at, chunks = 12, []
            while at < len(data):
                n, = struct.unpack_from("<I", data, at)
                chunks.append(data[at + 8:at + 8 + n]); at += 8 + n
            data, binary = chunks[0], chunks[1]
        self.g = json.loads(data)
        def load(b):
            uri = b.get("uri")
            if uri is None: return binary
            return base64.b64decode(uri.split(",", 1)[1]) if uri.startswith("data:") else (path.parent / uri).read_bytes()
        self.buffers = [load(b) for b in self.g["buffers"]]

    def view(self, v, offset, dtype, n, width):
        v = self.g["bufferViews"][v]
        start, size = v.get("byteOffset", 0) + offset, np.dtype(dtype).itemsize * width
        stride = v.get("byteStride") or size
        b = self.buffers[v["buffer"]]
        return np.array([np.frombuffer(b, dtype, width, start + i * stride) for i in range(n)]).reshape(n, width)

    def accessor(self, i):
        a = self.g["accessors"][i]
        dtype, width, n = TYPES[a["componentType"]], SHAPES[a["type"]], a["count"]
        x = self.view(a["bufferView"], a.get("byteOffset", 0), dtype, n, width).copy() if "bufferView" in a else np.zeros((n, width), dtype)
        if "sparse" in a:
            s = a["sparse"]
            at = self.view(s["indices"]["bufferView"], s["indices"].get("byteOffset", 0), TYPES[s["indices"]["componentType"]], s["count"], 1)[:, 0]
            x[at] = self.view(s["values"]["bufferView"], s["values"].get("byteOffset", 0), dtype, s["count"], width)
        x = x.astype(np.float64) if dtype == np.float32 or not a.get("normalized") else x.astype(np.float64)
        if a.get("normalized"):
            x = np.maximum(x / np.iinfo(dtype).max, -1.0)
        return x

def quaternion_matrix(q):
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])

def value(times, out, how, t, turns):
    n, sets = len(times), 3 if how == "CUBICSPLINE" else 1
    out = out.reshape(n, sets, -1)
    keys = out[:, sets // 2]
    if t <= times[0]: v = keys[0]
    elif t >= times[-1]: v = keys[-1]
    else:
        k = int(np.searchsorted(times, t, side="right")) - 1
        d = times[k + 1] - times[k]
        u = (t - times[k]) / d
        if how == "STEP": v = keys[k]
        elif how == "CUBICSPLINE":
            v = ((2 * u**3 - 3 * u**2 + 1) * keys[k] + d * (u**3 - 2 * u**2 + u) * out[k, 2]
                 + (-2 * u**3 + 3 * u**2) * keys[k + 1] + d * (u**3 - u**2) * out[k + 1, 0])
        elif turns:
            a, b = (q / np.linalg.norm(q) for q in (keys[k], keys[k + 1]))
            c = a @ b
            if c < 0: b, c = -b, -c
            w = np.arccos(min(c, 1.0))
            v = a if w < 1e-9 else (np.sin((1 - u) * w) * a + np.sin(u * w) * b) / np.sin(w)
        else: v = (1 - u) * keys[k] + u * keys[k + 1]
    return v / np.linalg.norm(v) if turns else v

def pose(f, clip, t):
    g = f.g
    nodes = [dict(n) for n in g["nodes"]]
    meshes = [dict(m) for m in g["meshes"]]
    for c in clip["channels"]:
        s = clip["samplers"][c["sampler"]]
        times, out = f.accessor(s["input"])[:, 0], f.accessor(s["output"])
        path, things, i = c["target"]["path"], nodes, c["target"].get("node")
        element = None
        if path == "pointer":
            _, kind, i, path, *element = c["target"]["extensions"]["KHR_animation_pointer"]["pointer"].split("/")
            things, i = {"nodes": nodes, "meshes": meshes}[kind], int(i)
        v = value(times, out, s.get("interpolation", "LINEAR"), t, path == "rotation")
        if element:
            weights = list(things[i]["weights"])
            weights[int(element[0])] = v[0]
            v = weights
        things[i][path] = v
    def local(n):
        if "matrix" in n: return np.array(n["matrix"], float).reshape(4, 4).T
        m = np.eye(4)
        m[:3, :3] = quaternion_matrix(np.array(n.get("rotation", [0, 0, 0, 1]), float)) @ np.diag(np.array(n.get("scale", [1, 1, 1]), float))
        m[:3, 3] = n.get("translation", [0, 0, 0])
        return m
    world = {}
    def walk(i, parent):
        world[i] = parent @ local(nodes[i])
        for c in nodes[i].get("children", []): walk(c, world[i])
    for i in g["scenes"][g.get("scene", 0)]["nodes"]: walk(i, np.eye(4))
    corners = []
    for i, n in enumerate(nodes):
        if "mesh" not in n or i not in world: continue
        mesh = meshes[n["mesh"]]
        weights = n.get("weights", mesh.get("weights", []))
        for p in mesh["primitives"]:
            x = f.accessor(p["attributes"]["POSITION"])
            for target, w in zip(p.get("targets", []), weights):
                if "POSITION" in target: x = x + w * f.accessor(target["POSITION"])
            x = np.c_[x, np.ones(len(x))]
            if "skin" in n:
                skin = g["skins"][n["skin"]]
                bind = f.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
                joints = np.array([world[j] @ b for j, b in zip(skin["joints"], bind)])
                m, total, k = np.zeros((len(x), 4, 4)), np.zeros(len(x)), 0
                while f"JOINTS_{k}" in p["attributes"]:
                    js, ws = (f.accessor(p["attributes"][f"{name}_{k}"]) for name in ("JOINTS", "WEIGHTS"))
                    m += np.einsum("vk,vkij->vij", ws, joints[js.astype(int)]); total += ws.sum(1); k += 1
                # What no joint holds stays.
                m[total == 0], total[total == 0] = np.eye(4), 1
                x = np.einsum("vij,vj->vi", m / total[:, None, None], x)
            else: x = x @ world[i].T
            index = f.accessor(p["indices"])[:, 0].astype(int) if "indices" in p else np.arange(len(x))
            corners.append(x[index][:, :3])
    x = np.concatenate(corners)
    # Two waves over space tell where corners are, whatever their order.
    scale = np.abs(x).max()
    waves = [np.cos(x @ np.array(k) / scale).mean() for k in ([5, 3, 2], [-1, 4, 7])]
    return [*x.min(0), *x.max(0), *x.mean(0), *waves]

def moments(f, name, shares):
    """A row for each clip of a file before its first key, at these shares of its time, and after its last."""
    for i, clip in enumerate(f.g["animations"]):
        ends = np.concatenate([f.accessor(s["input"])[[0, -1], 0] for s in clip["samplers"]])
        first, last = ends.min(), ends.max()
        for t in [first - 1, *(first + share * (last - first) for share in shares), last + 1]:
            t = float(np.round(t, 4))
            yield {"file": name, "clip": i, "name": clip.get("name", ""), "range": [float(first), float(last)], "seconds": t,
                   "figures": [float(f"{v:.8g}") for v in pose(f, clip, t)]}

def show(rows):
    return "[\n" + ",\n".join(json.dumps(r) for r in rows) + "\n]\n"

if __name__ == "__main__":
    print(show(row for name in FILES for row in moments(File(Path(sys.argv[1]) / name), name, (0.31, 0.77))), end="")
