# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes animated glTF files by chance, and what pose.py says of them: the other half of animated_scenes.rs.

    python3 chance.py FOLDER     (numpy; writes FOLDER/chance-N.gltf and FOLDER/chance.json; FOLDER = this one)

Each has what exporters seldom write and the specification allows: two or three sets of joints, weights that do not sum to 1 or are
all 0, as floats and as normalised integers; mirrored and uneven scales; splines, steps and jumps between equal times; turns as
normalised shorts of any length; morph targets as sparse accessors; weights of nodes and of meshes; KHR_animation_pointer; clips
that drive different things; skinned meshes on nodes that move by themselves."""
import base64, json, sys
from pathlib import Path
import numpy as np
import pose

class Maker:
    def __init__(self, seed):
        self.r = np.random.default_rng(seed)
        self.bytes, self.views, self.accessors = b"", [], []

    def view(self, data):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": data.nbytes})
        self.bytes += data.tobytes()
        return len(self.views) - 1

    def accessor(self, data, shape, normalized=False):
        kinds = {np.dtype(v): k for k, v in pose.TYPES.items()}
        a = {"bufferView": self.view(data), "componentType": kinds[data.dtype], "count": len(data), "type": shape}
        if normalized: a["normalized"] = True
        self.accessors.append(a)
        return len(self.accessors) - 1

    def floats(self, data, shape):
        return self.accessor(np.asarray(data, np.float32), shape)

    def sparse(self, count, at, values):
        """Zero but at some places."""
        s = {"count": len(at), "indices": {"bufferView": self.view(np.asarray(at, np.uint16)), "componentType": 5123},
             "values": {"bufferView": self.view(np.asarray(values, np.float32))}}
        self.accessors.append({"componentType": 5126, "count": count, "type": "VEC3", "sparse": s})
        return len(self.accessors) - 1

    def trs(self, scales):
        r = self.r
        node = {"translation": r.uniform(-1, 1, 3).round(3).tolist(), "rotation": r.normal(size=4).round(3).tolist()}
        # Of length 1, as nodes have to be.
        node["rotation"] = (np.array(node["rotation"]) / np.linalg.norm(node["rotation"])).tolist()
        if scales: node["scale"] = (r.uniform(0.5, 1.5, 3) * r.choice([1, 1, -1], 3)).round(3).tolist()
        return node

    def influences(self, count, joints, sets):
        """Attributes; a few vertices have no weight at all."""
        weights = self.r.uniform(0, 1.3, (count, sets, 4)) * (self.r.uniform(size=(count, sets, 4)) < 0.5)
        weights[::7] = 0
        attributes = {}
        for k in range(sets):
            dtype = np.uint8 if k % 2 else np.uint16
            attributes[f"JOINTS_{k}"] = self.accessor(self.r.integers(0, joints, (count, 4)).astype(dtype), "VEC4")
            if k == 0: w = self.floats(weights[:, k], "VEC4")
            else: w = self.accessor((weights[:, k] / 1.3 * np.iinfo(dtype).max).astype(dtype), "VEC4", True)
            attributes[f"WEIGHTS_{k}"] = w
        return attributes

    def primitive(self, targets, more={}):
        count = 24
        attributes = {"POSITION": self.floats(self.r.uniform(-1, 1, (count, 3)), "VEC3"), **more}
        p = {"attributes": attributes,
             "indices": self.accessor(self.r.permuted(np.arange(count)).astype(np.uint16)[:, None], "SCALAR")}
        if targets:
            at = np.sort(self.r.choice(count, 9, replace=False))
            p["targets"] = [{"POSITION": self.floats(self.r.normal(size=(count, 3)), "VEC3")},
                            {"POSITION": self.sparse(count, at, self.r.normal(size=(9, 3)))}]
        return p

    def sampler(self, path, width):
        r, n = self.r, int(self.r.integers(2, 6))
        how = str(r.choice(["STEP", "LINEAR", "CUBICSPLINE"]))
        # From 0 to 2, so that all of a clip's moments are among its keys.
        times = np.sort(np.r_[0, r.uniform(0.1, 1.9, n - 1), 2]).round(2)
        if n > 3 and how != "CUBICSPLINE": times[2] = times[1]
        values = r.normal(size=(n + 1, 3 if how == "CUBICSPLINE" else 1, width))
        if path == "scale": values = 1 + 0.3 * np.tanh(values)
        values = values.reshape(-1, 1 if path == "weights" else width)
        if path == "rotation" and how != "CUBICSPLINE" and r.uniform() < 0.5:
            shorts = (np.clip(values / 4, -1, 1) * 32767).astype(np.int16)
            out = self.accessor(shorts, "VEC4", True)
        else:
            out = self.floats(values, {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[values.shape[1]])
        return {"input": self.floats(times[:, None], "SCALAR"), "output": out, "interpolation": how}

    def clip(self, name, targets):
        samplers = [self.sampler(path, width) for _, path, width in targets]
        return {"name": name, "samplers": samplers, "channels": [{"sampler": i, "target": t} for i, (t, _, _) in enumerate(targets)]}

def pointer(path):
    return {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": path}}}

def made(seed):
    m = Maker(seed)
    # 0: above all; 1 to 5: joints in a random tree; 6: skinned, below 0; 7: morphed, below a joint; 8: at rest, beside.
    nodes = [m.trs(True)] + [m.trs(m.r.uniform() < 0.7) for _ in range(5)] + [m.trs(True), m.trs(True), m.trs(False)]
    for joint in range(1, 6):
        nodes[int(m.r.integers(0, joint))].setdefault("children", []).append(joint)
    nodes[0].setdefault("children", []).append(6)
    nodes[int(m.r.integers(1, 6))].setdefault("children", []).append(7)
    nodes[6] |= {"mesh": 0, "skin": 0}
    nodes[7] |= {"mesh": 1, "weights": [0.25, -0.5]}
    nodes[8] |= {"mesh": 2}
    joints = [int(j) for j in m.r.permutation(np.arange(1, 6))]
    bind = np.eye(4) + 0.3 * m.r.normal(size=(5, 4, 4)) * np.array([1, 1, 1, 0])[:, None]
    skin = {"joints": joints, "inverseBindMatrices": m.floats(bind.transpose(0, 2, 1).reshape(5, 16), "MAT4")}
    meshes = [{"primitives": [m.primitive(True, m.influences(24, 5, 2 + seed % 2))], "weights": [0.5, 0.1]},
              {"primitives": [m.primitive(True), m.primitive(True)]},
              {"primitives": [m.primitive(True)], "weights": [-0.2, 0.3]}]
    def node(i, path): return ({"node": i, "path": path}, path, {"translation": 3, "scale": 3, "rotation": 4, "weights": 2}[path])
    first = [node(0, "translation"), node(6, "rotation"), node(7, "weights")] + [
        node(j, str(m.r.choice(["translation", "rotation", "scale"]))) for j in range(1, 6)]
    second = [(pointer("/nodes/3/rotation"), "rotation", 4), (pointer("/nodes/7/weights/1"), "weights", 1),
              (pointer("/meshes/2/weights"), "weights", 2), node(0, "rotation"), node(2, "scale")]
    clips = [m.clip("first", first), m.clip("second", second)]
    data = "data:application/octet-stream;base64," + base64.b64encode(m.bytes).decode()
    return {"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_animation_pointer"], "scene": 0, "scenes": [{"nodes": [0, 8]}],
            "nodes": nodes, "meshes": meshes, "skins": [skin], "animations": clips, "accessors": m.accessors,
            "bufferViews": m.views, "buffers": [{"byteLength": len(m.bytes), "uri": data}]}

if __name__ == "__main__":
    folder, rows = Path(sys.argv[1]), []
    for seed in range(int(sys.argv[2]) if len(sys.argv) > 2 else 4):
        name = f"chance-{seed}.gltf"
        (folder / name).write_text(json.dumps(made(seed), separators=(",", ":")) + "\n")
        rows += pose.moments(pose.File(folder / name), name, (0.08, 0.31, 0.53, 0.77))
    (folder / "chance.json").write_text(pose.show(rows))
