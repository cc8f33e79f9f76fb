# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows one thing in a room, of several materials, by Mitsuba 3 and by gnurt, and compares the pictures.

    python3 mitsuba_materials.py GNURT [--spp 64] [--batches 16] [--variant llvm_ad_rgb] [MATERIAL ...]

The thing is a ball of flat triangles. Materials whose name ends in "(Mitsuba's)" are Mitsuba's own models, which differ from
ours as the table says, as does "(glTF's example)"; "(ours)" are our definitions in Mitsuba: mitsuba_models.py. Standard errors are those of the batches;
tiles of 8 x 8 pixels are off by the rule of tests/references.rs: more than three standard errors and 0.5 %.
Needs `pip install mitsuba numpy`. 
"""
import argparse
import os
import subprocess
import tempfile

import mitsuba as mi
import numpy as np

import ball_room

DEPTH = 12
TILE = 8
NOTHING, RIM = "nothing", "light between facets; shadowing"
rgb = lambda *value: {"type": "rgb", "value": list(value) if len(value) > 1 else value[0]}
twosided = lambda bsdf: {"type": "twosided", "nested": bsdf}
metal = lambda alpha: twosided({"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": alpha})
glass = lambda alpha: {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "int_ior": 1.5, "ext_ior": 1.0}
principled = lambda colour, alpha, **more: {"type": "principled", "base_color": rgb(*colour), "roughness": alpha**0.5, **more}
WHITE, GOLD, CLAY = (1.0, 1.0, 1.0), (0.95, 0.7, 0.3), (0.7, 0.4, 0.15)


def gltf(base=WHITE, metallic=0.0, alpha=0.0, ior=1.5, coat=0.0, coat_alpha=0.0, transmission=0.0, thin=False, sheen=None, sheen_roughness=0.0):
    """A glTF material."""
    extensions = {"KHR_materials_ior": {"ior": ior}}
    if coat:
        extensions["KHR_materials_clearcoat"] = {"clearcoatFactor": coat, "clearcoatRoughnessFactor": coat_alpha**0.5}
    if transmission:
        extensions["KHR_materials_transmission"] = {"transmissionFactor": transmission}
        if not thin:
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
    if sheen:
        extensions["KHR_materials_sheen"] = {"sheenColorFactor": list(sheen), "sheenRoughnessFactor": sheen_roughness}
    pbr = {"baseColorFactor": [*base, 1.0], "metallicFactor": metallic, "roughnessFactor": alpha**0.5}
    return {"pbrMetallicRoughness": pbr, "extensions": extensions}


def materials():
    """Name: lines of MTL or a glTF material, what makes Mitsuba's BSDF, what differs."""
    from mitsuba_models import Glass, Layered, Mixed, Pane

    table = {
        "matte": ("Kd 0.7 0.5 0.3\n", lambda: twosided({"type": "diffuse", "reflectance": rgb(0.7, 0.5, 0.3)}), NOTHING),
        "mirror": ("Kd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\n", lambda: twosided({"type": "conductor", "material": "none", "specular_reflectance": rgb(0.9)}), NOTHING),
        "glass": ("Kd 0 0 0\nillum 7\nNi 1.5\n", lambda: {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}, NOTHING),
    }

    def add(name, made, theirs, differs, own):
        if theirs:
            table[f"{name} (Mitsuba's)"] = (made, lambda: theirs, differs)
        if own:
            table[f"{name} (ours)"] = (made, own, NOTHING)

    for alpha in (0.02, 0.1, 0.3):
        white = gltf(metallic=1.0, alpha=alpha)
        add(f"metal {alpha}", white, metal(alpha), RIM, lambda a=alpha: Layered(WHITE, 1.0, a))
    add("gold 0.25", gltf(GOLD, 1.0, 0.25), principled(GOLD, 0.25, metallic=1.0), RIM, lambda: Layered(GOLD, 1.0, 0.25))
    add("gold 0.02", gltf(GOLD, 1.0, 0.02), principled(GOLD, 0.02, metallic=1.0), RIM, None)
    for alpha in (0.01, 0.04, 0.1, 0.3, 0.6):
        own = (lambda a=alpha: Glass(a, 1.5)) if alpha >= 0.04 else None
        made = gltf(alpha=alpha, transmission=1.0)
        add(f"rough glass {alpha}", made, glass(alpha), RIM, own)
    add("rough glass 0.15 of 2.2, green", gltf((0.3, 0.9, 0.4), alpha=0.15, ior=2.2, transmission=1.0), None, "", lambda: Glass(0.15, 2.2, (0.3, 0.9, 0.4)))
    through = principled(WHITE, 0.01, eta=1.5, spec_trans=1.0)
    add("principled glass 0.01", gltf(alpha=0.01, transmission=1.0), through, RIM, None)
    plastic = lambda kind, **more: {"type": kind, "diffuse_reflectance": rgb(*CLAY), "int_ior": 1.5, "ext_ior": 1.0, "nonlinear": False, **more}
    add("plastic", gltf(CLAY), plastic("plastic"), "Schlick's approximation", lambda: Layered(CLAY, 0.0, 0.001))
    for alpha in (0.1, 0.4):
        theirs = plastic("roughplastic", distribution="ggx", alpha=alpha)
        add(f"rough plastic {alpha}", gltf(CLAY, alpha=alpha), theirs, "Schlick; " + RIM, lambda a=alpha: Layered(CLAY, 0.0, a))
    add("plastic 0.15 of 1.9", gltf(CLAY, alpha=0.15, ior=1.9), None, "", lambda: Layered(CLAY, 0.0, 0.15, 1.9))
    disney = principled(CLAY, 0.1, eta=1.5)
    add("principled plastic 0.1", gltf(CLAY, alpha=0.1), disney, "body by Disney's formula", None)
    add("half a metal 0.2", gltf(GOLD, 0.5, 0.2), principled(GOLD, 0.2, metallic=0.5), "body by Disney's formula; " + RIM, lambda: Layered(GOLD, 0.5, 0.2))
    coat = dict(coat=1.0, coat_alpha=0.04)
    disney = principled(CLAY, 0.3, eta=1.5, clearcoat=1.0, clearcoat_gloss=0.6)
    add("coated plastic 0.3", gltf(CLAY, alpha=0.3, **coat), disney, "body and coat by Disney's formulas", lambda: Layered(CLAY, 0.0, 0.3, **coat))
    add("coated metal 0.3", gltf(GOLD, 1.0, 0.3, **coat), None, "", lambda: Layered(GOLD, 1.0, 0.3, **coat))
    for colour, roughness in ((WHITE, 0.0), (WHITE, 0.15), (WHITE, 0.3), (GOLD, 0.6), (WHITE, 1.0)):
        cloth = dict(sheen=colour, sheen_roughness=roughness)
        add(f"cloth {roughness}", gltf(CLAY, alpha=0.5, **cloth), None, "", lambda c=cloth: Layered(CLAY, 0.0, 0.5, **c))
    cloth = dict(sheen=(0.3, 0.5, 0.9), sheen_roughness=0.5)
    add("blue sheen on gold 0.25", gltf(GOLD, 1.0, 0.25, **cloth), None, "", lambda: Layered(GOLD, 1.0, 0.25, **cloth))
    add("coated cloth 0.5", gltf(CLAY, alpha=0.5, **coat, **cloth), None, "", lambda: Layered(CLAY, 0.0, 0.5, **coat, **cloth))
    for alpha in (0.0025, 0.1, 0.3, 0.6):
        theirs = {"type": "thindielectric", "int_ior": 1.5, "ext_ior": 1.0} if alpha < 0.01 else None
        differs = "roughness of 0.05 (alpha 0.0025)"
        add(f"pane {alpha}", gltf(alpha=alpha, transmission=1.0, thin=True), theirs, differs, lambda a=alpha: Pane(a, 1.5))
    table["pane 0.1 (glTF's example)"] = (gltf(alpha=0.1, transmission=1.0, thin=True), lambda: Pane(0.1, 1.5, by_formula=True), "Schlick's share of one face")
    green = (0.3, 0.9, 0.4)
    add("pane 0.15 of 2.2, green", gltf(green, alpha=0.15, ior=2.2, transmission=1.0, thin=True), None, "", lambda: Pane(0.15, 2.2, green))
    for share in (0.3, 0.7):
        for thin, kind, glass_of in ((True, "pane", Pane), (False, "glass", Glass)):
            made = gltf(CLAY, alpha=0.2, transmission=share, thin=thin)
            own = lambda s=share, g=glass_of: Mixed(Layered(CLAY, 0.0, 0.2), g(0.2, 1.5, CLAY), s)
            add(f"{share} of {kind} 0.2", made, None, "", own)
    return table


def both(arguments, made, bsdf):
    """Batches of pictures by gnurt and by Mitsuba: two arrays (batch, row, column, channel)."""
    from mitsuba_path import load_scene

    with tempfile.TemporaryDirectory() as folder:
        path = ball_room.write_obj(folder, made) if isinstance(made, str) else ball_room.write_gltf(folder, made)
        scene = load_scene(ball_room.parts(), ball_room.CAMERA, folder, {"thing": bsdf}, DEPTH)
        own, theirs = [], []
        for seed in range(arguments.batches):
            output = os.path.join(folder, "own.pfm")
            words = [arguments.gnurt, "render", path, *ball_room.gnurt_arguments(), f"--integrator={arguments.integrator}", f"--max-depth={DEPTH}"]
            words += [f"--spp={arguments.spp}", f"--seed={seed}", "-q", "-o", output]
            subprocess.run(words, check=True)
            own.append(np.array(mi.Bitmap(output)).astype(float)[..., :3])
            theirs.append(mi.render(scene, spp=arguments.spp, seed=seed).numpy().astype(float))
    return np.array(own), np.array(theirs)


def difference(own, theirs):
    """Relative difference of two means over batches, and its standard error."""
    error = np.hypot(*(v.std(ddof=1) / len(v) ** 0.5 / v.mean() for v in (own, theirs)))
    return own.mean() / theirs.mean() - 1, error


def tiles(own, theirs):
    """How many tiles are off, of how many, and mean and deviation of what differs in standard errors."""
    n = ball_room.SIZE // TILE
    fold = lambda pictures: pictures.reshape(-1, n, TILE, n, TILE, 3).mean(axis=(2, 4))
    a, b = fold(own), fold(theirs)
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    gap = a.mean(axis=0) - b.mean(axis=0)
    off = (np.abs(gap) > 3 * error + 0.005 * b.mean(axis=0)).any(axis=-1)
    z = gap[error > 0] / error[error > 0]
    return off.sum(), off.size, z.mean(), z.std()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("gnurt")
    parser.add_argument("only", nargs="*")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--batches", type=int, default=16)
    parser.add_argument("--keep", help="folder for the pictures' means, as EXR")
    arguments = parser.parse_intermixed_args()
    mi.set_variant(arguments.variant)
    thing = ball_room.sees_ball()
    print("| material | what differs | whole picture, % | standard error | the thing alone, % | standard error | tiles off | z: mean, deviation |")
    print("|---|---|---|---|---|---|---|---|")
    table = materials()
    for name in arguments.only or table:
        made, bsdf, differs = table[name]
        own, theirs = both(arguments, made, bsdf())
        row = [name, differs]
        for mask in (np.ones_like(thing), thing):
            relative, error = difference(*(np.array([picture[mask].mean() for picture in batch]) for batch in (own, theirs)))
            row += [f"{relative * 100:+.3f}", f"{error * 100:.3f}"]
        off, of, mean, deviation = tiles(own, theirs)
        row += [f"{off} of {of}", f"{mean:+.2f}, {deviation:.2f}"]
        print("| " + " | ".join(row) + " |", flush=True)
        if arguments.keep:
            for who, pictures in (("gnurt", own), ("mitsuba", theirs)):
                path = os.path.join(arguments.keep, f"{name.replace(' ', '-')}-{who}.exr")
                mi.Bitmap(pictures.mean(axis=0).astype(np.float32)).write(path)


main()
