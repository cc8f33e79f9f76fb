# SPDX-License-Identifier: GPL-3.0-or-later
"""Times path tracing by Mitsuba 3 and by gnurt on the same diffuse interiors, and says how they compare at equal error.

    python3 mitsuba_path.py SCENES REFERENCES GNURT [--variant llvm_ad_rgb] [--spp 64] [--threads 2] [SCENE ...]

SCENES is the folder of unpacked scenes, REFERENCES that of the reference pictures, GNURT the program. Needs `pip install
mitsuba numpy`, and for llvm variants a libLLVM (DRJIT_LIBLLVM_PATH). Times are seconds of processors, over all threads, so
that a busy machine may be used, and those of rendering alone: neither reading, nor building trees, nor compiling kernels
counts (Mitsuba renders once before it is timed; of gnurt, the time of a run with one sample is taken off). Both errors fall as one over
the samples, so error times seconds is what a renderer is worth, whatever the number of samples.
Source: original.
"""
import argparse
import os
import resource
import subprocess
import tempfile
import time

import mitsuba as mi
import numpy as np

import interiors


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


def run_mitsuba(scene, spp):
    mi.render(scene, spp=spp, seed=1).numpy()  # compiles
    start = time.process_time()
    picture = mi.render(scene, spp=spp, seed=2).numpy().astype(np.float64)
    return picture, time.process_time() - start


def run_gnurt(program, path, scene, spp, threads, folder):
    output = os.path.join(folder, "own.pfm")

    def run(spp):
        words = [program, "render", path, *interiors.gnurt_arguments(scene), "--force-diffuse", "--integrator=path"]
        words += ["--max-depth=9", f"--spp={spp}", f"-t={threads}", "-q", "-o", output]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(words, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    # What one sample costs holds all that is done once.
    once, all_of_it = run(1), run(spp + 1)
    picture = np.array(mi.Bitmap(output)).astype(np.float64)[..., :3]
    return picture, (all_of_it - once) * (spp + 1) / spp


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes")
    parser.add_argument("references")
    parser.add_argument("gnurt")
    parser.add_argument("only", nargs="*")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_intermixed_args()
    mi.set_variant(arguments.variant)
    print("| scene | renderer | spp | CPU seconds | relMSE | trimmed | mean error % | relMSE x s | trimmed x s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for scene in arguments.only or interiors.CAMERAS:
        reference = read_exr(os.path.join(arguments.references, f"{scene}-path9.exr"))
        variance = read_exr(os.path.join(arguments.references, f"{scene}-path9-var.exr"))
        with tempfile.TemporaryDirectory() as folder:
            own_path = os.path.join(arguments.scenes, scene, scene + ".obj")
            own = run_gnurt(arguments.gnurt, own_path, scene, arguments.spp, arguments.threads, folder)
            theirs = load_scene(interiors.read(arguments.scenes, scene), interiors.CAMERAS[scene], folder)
            other = run_mitsuba(theirs, arguments.spp)
        worth = []
        for name, (picture, seconds) in [("gnurt", own), (f"Mitsuba {mi.__version__} {arguments.variant}", other)]:
            errors = interiors.rel_mse(picture, reference, variance)
            off = (picture.mean() / reference.mean() - 1) * 100
            worth.append([error * seconds for error in errors])
            row = [scene, name, arguments.spp, f"{seconds:.2f}", *(f"{e:.5f}" for e in errors), f"{off:+.2f}"]
            print("| " + " | ".join(map(str, row + [f"{w:.5f}" for w in worth[-1]])) + " |", flush=True)
        ratios = [theirs / own for own, theirs in zip(*worth)]
        print(f"| {scene} | **times faster at equal error** | | | | | | {ratios[0]:.2f} | {ratios[1]:.2f} |", flush=True)


if __name__ == "__main__":
    main()
