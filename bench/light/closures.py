#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Means of builtin:cornell whose walls are closures of the shading language, by `path` and by integrators of virtual lights.

All of them are unbiased, so the means must agree but for noise:

    python3 bench/light/closures.py                                   # a table; 1 at the end if some mean is off by more than 3 %
    python3 bench/light/closures.py --only phong,ward --spp 1024      # closures whose names hold one of these words
    python3 bench/light/closures.py --program target/debug/gnurt --integrators path,ir,bir,mir

Errors are those of the mean over seeds; a mean that is off by less than three of them says nothing.
A quick version is in the test suite: crates/render/tests/agreement.rs.
"""

import argparse
import math
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

BENT = "normalize (N + 0.5 * Du)"
MORE_BENT = "normalize (N + 0.9 * Du)"
MATERIALX = '"ggx"'

# Walls by name: what is assigned to Ci; Du is a unit vector along the wall.
CLOSURES = {
    "diffuse": "0.6 * diffuse (N)",
    "oren_nayar": "0.7 * oren_nayar (N, 0.6)",
    "oren_nayar_diffuse": "oren_nayar_diffuse_bsdf (N, color (0.7, 0.5, 0.3), 0.6)",
    "oren_nayar_compensated": 'oren_nayar_diffuse_bsdf (N, color (0.6), 0.8, "energy_compensation", 1)',
    "burley": "burley_diffuse_bsdf (N, color (0.6, 0.5, 0.4), 0.8)",
    "subsurface": "subsurface_bssrdf (N, color (0.6), color (1), 0)",
    "translucent": "0.3 * translucent (N) + 0.4 * diffuse (N)",
    "phong": "0.8 * phong (N, 60)",
    "phong_wide": "0.8 * phong (N, 5)",
    "ward": "0.8 * ward (N, Du, 0.3, 0.3)",
    "ward_brushed": "0.8 * ward (N, Du, 0.15, 0.5)",
    "ggx_all": '0.7 * microfacet ("ggx", N, 0.3, 0, 0)',
    "ggx_reflect": 'microfacet ("ggx", N, 0.3, 1.5, 0) + 0.4 * diffuse (N)',
    "ggx_refract": 'microfacet ("ggx", N, 0.4, 1.5, 1)',
    "ggx_both": '0.9 * microfacet ("ggx", N, 0.4, 1.5, 2)',
    "ggx_brushed": '0.7 * microfacet ("ggx", N, Du, 0.2, 0.6, 0, 0)',
    "beckmann_all": '0.8 * microfacet ("beckmann", N, 0.4, 0, 0)',
    "beckmann_reflect": 'microfacet ("beckmann", N, 0.3, 1.5, 0)',
    "beckmann_refract": 'microfacet ("beckmann", N, 0.4, 1.5, 1)',
    "beckmann_both": '0.9 * microfacet ("beckmann", N, 0.4, 1.5, 2)',
    "beckmann_brushed": '0.8 * microfacet ("beckmann", N, Du, 0.2, 0.6, 0, 0)',
    "sheen": "sheen_bsdf (N, color (0.7), 0.4) + 0.3 * diffuse (N)",
    "sheen_fibres": 'sheen_bsdf (N, color (0.9), 0.5, "mode", 1)',
    "sheen_fibres_over": 'layer (sheen_bsdf (N, color (0.9), 0.3, "mode", 1), 0.6 * diffuse (N))',
    "dielectric_reflect": f"layer (dielectric_bsdf (N, Du, color (1), color (0), 0.2, 0.2, 1.5, {MATERIALX}), 0.6 * diffuse (N))",
    "dielectric_both": f"dielectric_bsdf (N, Du, color (0.9), color (0.8), 0.4, 0.4, 1.5, {MATERIALX})",
    "conductor": f"0.8 * conductor_bsdf (N, Du, 0.3, 0.3, color (0.2, 0.9, 1.2), color (3.9, 2.4, 2.2), {MATERIALX})",
    "conductor_film": f'0.8 * conductor_bsdf (N, Du, 0.3, 0.5, color (0.2), color (3), {MATERIALX}, "thinfilm_thickness", 400, "thinfilm_ior", 1.4)',
    "schlick_reflect": f"generalized_schlick_bsdf (N, Du, color (0.8), color (0), 0.3, 0.3, color (0.4), color (1), 3, {MATERIALX})",
    "schlick_both": f"generalized_schlick_bsdf (N, Du, color (0.8), color (0.9), 0.4, 0.4, color (0.1), color (1), 5, {MATERIALX})",
    "schlick_over": f"layer (generalized_schlick_bsdf (N, Du, color (0.8), color (0), 0.3, 0.3, color (0.2), color (1), 5, {MATERIALX}), 0.6 * diffuse (N))",
    "phong_over": "layer (0.5 * phong (N, 30), 0.6 * diffuse (N))",
    "mixture": '0.3 * phong (N, 20) + 0.3 * diffuse (N) + 0.2 * microfacet ("beckmann", N, 0.3, 0, 0)',
    "glass_and_paper": '0.5 * microfacet ("ggx", N, 0.4, 1.5, 2) + 0.3 * translucent (N)',
    "bent_diffuse": f"0.7 * diffuse ({BENT})",
    "bent_more": f"0.7 * diffuse ({MORE_BENT})",
    "bent_phong": f"0.8 * phong ({BENT}, 20)",
    "bent_ggx": f'0.7 * microfacet ("ggx", {BENT}, 0.4, 0, 0)',
    "bent_coat": f"layer (dielectric_bsdf ({BENT}, Du, color (1), color (0), 0.3, 0.3, 1.5, {MATERIALX}), 0.6 * diffuse (N))",
    "bent_beside": f"0.5 * diffuse (N) + 0.3 * diffuse ({BENT})",
    "bent_two_ways": f"0.3 * diffuse (normalize (N - 0.5 * Du)) + 0.4 * diffuse ({BENT})",
    "bent_facets_beside": f'0.4 * diffuse (N) + 0.4 * microfacet ("ggx", {BENT}, 0.3, 0, 0)',
    "bent_base": f"layer (dielectric_bsdf (N, Du, color (1), color (0), 0.1, 0.1, 1.5, {MATERIALX}), 0.6 * diffuse ({BENT}))",
    "bent_translucent": f"0.4 * diffuse (N) + 0.3 * translucent ({BENT})",
    "bent_fibres": f'0.4 * diffuse (N) + sheen_bsdf ({BENT}, color (0.4), 0.5, "mode", 1)',
}


def mean(path):
    """The mean of all numbers of a PFM picture."""
    data = path.read_bytes()
    kind, size, scale, pixels = data.split(b"\n", 3)
    width, height = map(int, size.split())
    count = width * height * (3 if kind == b"PF" else 1)
    order = "<" if float(scale) < 0 else ">"
    return sum(struct.unpack(f"{order}{count}f", pixels[: 4 * count])) / count


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="gnurt")
    parser.add_argument("--integrators", default="path,ir,bir", help="the first is what others are compared with")
    parser.add_argument("--only", default="", help="words, one of which the closure's name holds")
    parser.add_argument("--size", type=int, default=32)
    parser.add_argument("--spp", type=int, default=256, help="of path; virtual lights take a quarter")
    parser.add_argument("--vpls", type=int, default=128)
    parser.add_argument("--max-depth", type=int, default=6)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--bar", type=float, default=3.0, help="percent")
    options = parser.parse_args()
    words = [word for word in options.only.split(",") if word]
    names = [name for name in CLOSURES if not words or any(word in name for word in words)]
    integrators = options.integrators.split(",")
    off = []
    print(f"{'':24}" + "".join(f"{name:>24}" for name in integrators), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            shader = Path(folder) / f"{name}.osl"
            body = f"vector Du = normalize (dPdu);\n    Ci = {CLOSURES[name]};"
            shader.write_text(f"surface {name} ()\n{{\n    {body}\n}}\n")
            walls = [part for wall in ("white", "red", "green") for part in ("--shader", f"{wall}={shader}")]
            row, first = f"{name:24}", None
            for integrator in integrators:
                found = []
                for seed in range(1, options.seeds + 1):
                    picture = Path(folder) / "picture.pfm"
                    spp = options.spp if integrator == "path" else max(1, options.spp // 4)
                    command = [options.program, "render", "builtin:cornell", *walls, "-q", "--denoise=none"]
                    command += ["-r", f"{options.size}x{options.size}", "--spp", str(spp), "--seed", str(seed)]
                    command += ["--integrator", integrator, "--max-depth", str(options.max_depth), "-o", str(picture)]
                    if integrator != "path":
                        command += ["--vpls", str(options.vpls)]
                    subprocess.run(command, check=True)
                    found.append(mean(picture))
                average = sum(found) / len(found)
                variance = sum((x - average) ** 2 for x in found) / max(1, len(found) - 1)
                error = math.sqrt(variance / len(found))
                first = first or (average, error)
                apart = 100 * (average / first[0] - 1)
                doubt = 100 * math.hypot(error, first[1]) / first[0]
                row += f"{average:10.4f} {apart:+6.2f} % +-{doubt:4.2f}"
                if abs(apart) - 3 * doubt > options.bar:
                    off.append(f"{name} by {integrator}: {apart:+.2f} %")
            print(row, flush=True)
    print(f"{len(names)} closures, {len(off)} means off by more than {options.bar} %" + "".join(f"\n  {line}" for line in off))
    return int(bool(off))


if __name__ == "__main__":
    sys.exit(main())
