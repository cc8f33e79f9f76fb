#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Six scenes in OVITO by the device gnurt, whose outlines must be those of OVITO's OSPRay renderer within a pixel.

OVITO's Tachyon renderer shows everything half a pixel farther to the lower left.

    OVITO_ANARI_DEVICE=gnurt LD_LIBRARY_PATH=target/release python3 bindings/anari/tests/ovito_scenes.py [--out FOLDER]

Needs ovito (3.17 or later), numpy, pillow and a Vulkan driver; without them it says so and ends well. With Mesa's software driver:
VK_ICD_FILENAMES=/usr/share/vulkan/icd.d/lvp_icd.x86_64.json, and QT_QPA_PLATFORM unset.
"""

import argparse
import os
import sys
import tempfile

if os.environ.get("OVITO_ANARI_DEVICE") != "gnurt":
    print("SKIPPED: OVITO_ANARI_DEVICE=gnurt is to be set before OVITO starts")
    sys.exit(0)
try:
    import numpy as np
    from PIL import Image
    from ovito.data import DataCollection, Particles, SimulationCell
    from ovito.pipeline import Pipeline, StaticSource
    from ovito.modifiers import ConstructSurfaceModifier, CreateBondsModifier
    from ovito.vis import OSPRayRenderer, ParticlesVis, VectorVis, Viewport, VisRTXRenderer
except ImportError as missing:
    print(f"SKIPPED: {missing}; pip install ovito numpy pillow")
    sys.exit(0)

SIZE = (240, 180)


def particles(count=40, seed=1, shape=None):
    rng = np.random.default_rng(seed)
    data = DataCollection()
    atoms = Particles()
    atoms.create_property("Position", data=rng.uniform(-3, 3, (count, 3)))
    atoms.create_property("Radius", data=rng.uniform(0.2, 0.6, count))
    atoms.create_property("Color", data=rng.uniform(0, 1, (count, 3)))
    if shape is not None:
        atoms.vis.shape = shape
    data.objects.append(atoms)
    return data, atoms


def spheres():
    return Pipeline(source=StaticSource(data=particles()[0]))


def bonds():
    pipeline = Pipeline(source=StaticSource(data=particles()[0]))
    pipeline.modifiers.append(CreateBondsModifier(cutoff=2.0))
    return pipeline


def arrows():
    data, atoms = particles(20, 3)
    rng = np.random.default_rng(4)
    vectors = atoms.create_property("Force", data=rng.uniform(-2, 2, (20, 3)))
    vectors.vis = VectorVis(width=0.2, color=(1, 0.4, 0.2), enabled=True)
    return Pipeline(source=StaticSource(data=data))


def surface():
    data, _ = particles(300, 5)
    cell = SimulationCell(pbc=(False, False, False))
    cell[...] = [[8, 0, 0, -4], [0, 8, 0, -4], [0, 0, 8, -4]]
    data.objects.append(cell)
    pipeline = Pipeline(source=StaticSource(data=data))
    pipeline.modifiers.append(ConstructSurfaceModifier(radius=1.5))
    pipeline.compute().particles.vis.enabled = False
    return pipeline


def boxes():
    return Pipeline(source=StaticSource(data=particles(30, 6, ParticlesVis.Shape.Box)[0]))


def cell():
    data, _ = particles(5, 7)
    box = SimulationCell(pbc=(True, True, True))
    box[...] = [[8, 0, 0, -4], [0, 8, 0, -4], [0, 0, 8, -4]]
    box.vis.line_width = 0.3
    data.objects.append(box)
    return Pipeline(source=StaticSource(data=data))


SCENES = [spheres, bonds, arrows, surface, boxes, cell]


def mask(viewport, renderer, path):
    viewport.render_image(filename=path, size=SIZE, renderer=renderer, alpha=True)
    return np.array(Image.open(path).convert("RGBA"))[..., 3] > 127


def widened(mask):
    """The mask and all neighbours of its pixels."""
    wide = mask.copy()
    for axis in (0, 1):
        wide |= np.roll(wide, 1, axis) | np.roll(wide, -1, axis)
    return wide


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--out", help="save pictures in this folder")
    out = arguments.parse_args().out or tempfile.mkdtemp()
    os.makedirs(out, exist_ok=True)
    failed = 0
    for scene in SCENES:
        pipeline = scene()
        pipeline.add_to_scene()
        viewport = Viewport(type=Viewport.Type.Perspective, camera_dir=(0.3, 1, -0.4))
        viewport.zoom_all(SIZE)
        name = scene.__name__
        ours = mask(viewport, VisRTXRenderer(), os.path.join(out, f"{name}-gnurt.png"))
        theirs = mask(viewport, OSPRayRenderer(), os.path.join(out, f"{name}-ospray.png"))
        pipeline.remove_from_scene()
        far = (ours & ~widened(theirs)) | (theirs & ~widened(ours))
        area, expected = int(ours.sum()), int(theirs.sum())
        good = expected > 0 and not far.any() and abs(area - expected) <= 0.02 * expected
        failed += not good
        print(f"{'ok     ' if good else 'FAILED '} {name}: {area} of {expected} pixels, {int(far.sum())} are off by more than one")
    print(f"{len(SCENES) - failed} of {len(SCENES)} scenes")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
