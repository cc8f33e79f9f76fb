# SPDX-License-Identifier: GPL-3.0-or-later
"""Times path tracing by Mitsuba 3 and by gnurt on the same diffuse interiors, and says how they compare at equal error.

    python3 mitsuba_path.py SCENES REFERENCES GNURT [--variant llvm_ad_rgb] [--spp 64] [--threads 2] [SCENE ...]

SCENES is the folder of unpacked scenes, REFERENCES that of the reference pictures, GNURT the program. Needs `pip install
mitsuba numpy`, and for llvm variants a libLLVM (DRJIT_LIBLLVM_PATH). Neither reading, nor building trees, nor compiling kernels
counts (Mitsuba renders once before it is timed; of gnurt, the time of a run with one sample is taken off); equal_error.py says
the rest. 
"""
import os
import time

import mitsuba as mi
import numpy as np

import equal_error


def load_scene(parts, camera, folder, bsdfs={}, max_depth=9):
    """The parts as a Mitsuba scene; `bsdfs` by name of the part replace the matte one."""
    eye, target, up, fov, width, height = camera
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": max_depth},
        "sensor": {
            "type": "perspective",
            "fov": fov,
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(origin=list(eye), target=list(target), up=list(up)),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        },
    }
    for i, part in enumerate(parts):
        path = os.path.join(folder, f"part{i}.ply")
        write_ply(path, part)
        if part.texture:
            # Kd times the texture: decoded texels are scaled.
            bitmap = mi.Bitmap(part.texture).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
            data = np.array(bitmap) * np.array(part.reflectance, np.float32)
            texel = {"type": "bitmap", "data": mi.TensorXf(data.astype(np.float32)), "raw": True}
            reflectance = texel | {"filter_type": "bilinear", "wrap_mode": "repeat"}
        else:
            reflectance = {"type": "rgb", "value": list(part.reflectance)}
        shape = {
            "type": "ply",
            "filename": path,
            "face_normals": True,
            "bsdf": bsdfs.get(part.name)
            or {"type": "twosided", "nested": {"type": "diffuse", "reflectance": reflectance}},
        }
        if any(part.emission):
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": list(part.emission)}}
        scene[f"part{i}"] = shape
    return mi.load_dict(scene)


def write_ply(path, part):
    n = len(part.corners)
    corners = part.corners.reshape(-1, 3)
    names = ["x", "y", "z"]
    if part.texcoords is not None:
        corners = np.concatenate([corners, part.texcoords.reshape(-1, 2)], axis=1)
        names += ["u", "v"]
    faces = np.zeros(n, dtype=[("count", "u1"), ("index", "<i4", 3)])
    faces["count"], faces["index"] = 3, np.arange(3 * n).reshape(-1, 3)
    with open(path, "wb") as file:
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {3 * n}"]
        header += [f"property float {name}" for name in names]
        header += [f"element face {n}", "property list uchar int vertex_indices", "end_header", ""]
        file.write("\n".join(header).encode())
        file.write(corners.astype("<f4").tobytes())
        file.write(faces.tobytes())


def read_exr(path):
    bitmap = mi.Bitmap(path)
    names = [field.name for field in bitmap.struct_()]
    return np.array(bitmap).astype(np.float64)[..., [names.index(c) for c in "RGB"]]


def run_mitsuba(parts, camera, spp, threads, folder):
    scene = load_scene(parts, camera, folder)
    mi.render(scene, spp=spp, seed=1).numpy()  # compiles
    start = time.process_time()
    picture = mi.render(scene, spp=spp, seed=2).numpy().astype(np.float64)
    return picture, time.process_time() - start


def main():
    parser = equal_error.parser()
    parser.add_argument("--variant", default="llvm_ad_rgb")
    arguments = parser.parse_intermixed_args()
    mi.set_variant(arguments.variant)
    equal_error.compare(arguments, f"Mitsuba {mi.__version__} {arguments.variant}", read_exr, run_mitsuba)


if __name__ == "__main__":
    main()
