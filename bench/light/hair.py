# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair of 300 curves beside Mitsuba's: `python3 bench/light/hair.py PROGRAM`, with mitsuba and numpy installed.

Prints the means of both pictures and their ratio: a white furnace, brown hair under an even sky, light hair under a lamp.
"""

import random
import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

SKY = 'LightSource "infinite" "rgb L" [1 1 1]'
LAMP = 'LightSource "distant" "point3 from" [1 2 2] "point3 to" [0 0 0] "rgb L" [3 3 3]'
CASES = {
    "furnace": (SKY, {"sigma_a": [0, 0, 0]}, 0.3, 0.3, 2.0, 1.55),
    "brown, sky": (SKY, {"eumelanin": 1.3, "pheomelanin": 0.0}, 0.3, 0.3, 2.0, 1.55),
    "light, lamp": (LAMP, {"eumelanin": 0.3, "pheomelanin": 0.2}, 0.2, 0.5, 3.0, 1.5),
}


def curves():
    """Bezier points of 300 strands, the same each time."""
    draw = random.Random(3).uniform
    for _ in range(300):
        x, z, dx, dz = draw(-1, 1), draw(-1, 1), draw(-0.6, 0.6), draw(-0.6, 0.6)
        yield [(x, -0.5, z), (x + dx * 0.2, 0, z + dz * 0.1), (x + dx * 0.6, 0.6, z + dz * 0.5), (x + dx, 1, z + dz)]


def ours(program, folder, light, color, along, around, tilt, index, form):
    text = f"""LookAt 0 0.6 4  0 0.2 0  0 1 0
Camera "perspective" "float fov" 40
Film "rgb" "integer xresolution" 160 "integer yresolution" 120
WorldBegin
{light}
"""
    colors = " ".join(
        f'"rgb {name}" [{" ".join(map(str, value))}]' if isinstance(value, list) else f'"float {name}" {value}'
        for name, value in color.items()
    )
    text += f'Material "hair" {colors} "float beta_m" {along} "float beta_n" {around} "float alpha" {tilt} "float eta" {index}\n'
    for points in curves():
        numbers = " ".join(f"{x:.6f}" for point in points for x in point)
        text += f'Shape "curve" "string type" "{form}" "float width" 0.03 "point3 P" [ {numbers} ]\n'
    scene, picture = folder / "hair.pbrt", folder / "hair.pfm"
    scene.write_text(text)
    command = [program, "render", scene, "--spp", "64", "-r", "160x120", "--max-depth", "100", "--denoise=none", "-q"]
    if light == LAMP:
        command += ["--environment", "0,0,0"]
    subprocess.run([*command, "-o", picture], check=True)
    return np.array(mi.Bitmap(str(picture)))[..., :3]


def theirs(folder, light, color, along, around, tilt, index):
    to_spline = np.linalg.inv(np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6)
    lines = []
    for points in curves():
        lines += ["%f %f %f 0.015" % tuple(point) for point in to_spline @ np.array(points)] + [""]
    (folder / "hair.txt").write_text("\n".join(lines) + "\n")
    bsdf = {"type": "hair", "longitudinal_roughness": along, "azimuthal_roughness": around, "scale_tilt": tilt, "int_ior": index, "ext_ior": 1.0}
    bsdf |= {name: {"type": "rgb", "value": value} if isinstance(value, list) else value for name, value in color.items()}
    rgb = {"type": "rgb", "value": [3, 3, 3] if light == LAMP else [1, 1, 1]}
    lamp = {"type": "directional", "direction": [-1, -2, -2], "irradiance": rgb}
    return np.array(mi.render(mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 100, "rr_depth": 1000},
        "sensor": {
            "type": "perspective", "fov": 40, "fov_axis": "smaller",
            "to_world": mi.ScalarTransform4f().look_at([0, 0.6, 4], [0, 0.2, 0], [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 160, "height": 120, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": 64},
        },
        "light": lamp if light == LAMP else {"type": "constant", "radiance": rgb},
        "hair": {"type": "bsplinecurve", "filename": str(folder / "hair.txt"), "bsdf": bsdf},
    })))[..., :3]


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case, numbers in CASES.items():
            reference = theirs(folder, *numbers).mean(axis=(0, 1))
            for form in ["cylinder", "flat"]:
                mean = ours(program, folder, *numbers, form).mean(axis=(0, 1))
                ratios = " ".join(f"{x:.4f}" for x in mean / reference)
                print(f"{case}, {form}: ours {mean.round(5)}, Mitsuba {reference.round(5)}, ratio {ratios}")


main()
