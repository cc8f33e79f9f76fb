# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders documents in FreeCAD with the Render workbench and checks the pictures: freecadcmd judge.py

GNURT_WORKBENCH is the workbench's folder with the plug-in installed, GNURT_OUT a folder for pictures, GNURT the program.
Pictures are EXR files, read by `gnurt` itself: `gnurt info` has no pixels, so means come from PFM files.
"""

import os
import struct
import sys
import traceback

sys.path.insert(0, os.environ["GNURT_WORKBENCH"])

import FreeCAD as App  # noqa: E402

OUT = os.environ["GNURT_OUT"]
SETTINGS = App.ParamGet("User parameter:BaseApp/Preferences/Mod/Render")
SETTINGS.SetString("GnurtPath", os.environ["GNURT"])
import Render  # noqa: E402


def pixels(path):
    """Width, height and rows of a PFM picture, top row first."""
    with open(path, "rb") as file:
        kind = file.readline().strip()
        width, height = map(int, file.readline().split())
        order = "<" if float(file.readline()) < 0 else ">"
        channels = 3 if kind == b"PF" else 1
        values = struct.unpack(f"{order}{width * height * channels}f", file.read())
    rows = [values[row * width * channels : (row + 1) * width * channels] for row in range(height)]
    return width, height, rows[::-1]


class Scene:
    """A document with a project, a camera and objects."""

    def __init__(self, name, template="gnurt_dark.usda", size=(96, 64)):
        self.name, self.doc = name, App.newDocument(name)
        self.project, self.fpo, _ = Render.Project.create(self.doc, renderer="Gnurt", template=template)
        self.fpo.RenderWidth, self.fpo.RenderHeight = size
        self.fpo.SamplesPerPixel, self.fpo.BatchMode, self.fpo.OpenAfterRender = 64, True, False
        self.fpo.DelayedBuild = True
        self.fpo.OutputImage = os.path.join(OUT, name + ".pfm")

    def box(self, name, size, place=(0, 0, 0), material=None):
        box = self.doc.addObject("Part::Box", name)
        box.Length, box.Width, box.Height = size
        box.Placement.Base = App.Vector(*place)
        return self.show(box, material)

    def sphere(self, name, radius, place, material=None):
        ball = self.doc.addObject("Part::Sphere", name)
        ball.Radius = radius
        ball.Placement.Base = App.Vector(*place)
        return self.show(ball, material)

    def show(self, thing, material=None):
        self.doc.recompute()
        self.project.add_view(thing)
        if material:
            view = next(v for v in self.project.all_views() if v.Source is thing or v.Source.Name == thing.Name)
            view.Material = material
        return thing

    def material(self, kind, **values):
        made = Render.make_material(f"{kind}{len(self.doc.Objects)}", doc=self.doc)
        card = {"Render.Type": kind, "Name": made.Label}
        card.update({f"Render.{kind}.{key.replace('__', '.')}": str(value) for key, value in values.items()})
        made.Material = card
        return made

    def camera(self, place, rotation, angle=45):
        _, camera, _ = Render.Camera.create(self.doc)
        camera.Placement = App.Placement(App.Vector(*place), rotation)
        camera.HeightAngle = angle
        return self.show(camera)

    def light(self, kind, **values):
        _, light, _ = getattr(Render, kind).create(self.doc)
        for key, value in values.items():
            setattr(light, key, value)
        return self.show(light)

    def render(self):
        self.doc.recompute()
        path = self.project.render(wait_for_completion=True)
        return pixels(path)


def mean(picture, box):
    """The mean colour of the box (left, top, right, bottom), in parts of the picture."""
    width, height, rows = picture
    left, right = int(box[0] * width), int(box[2] * width)
    top, bottom = int(box[1] * height), int(box[3] * height)
    total = [0.0] * 3
    for row in rows[top:bottom]:
        for x in range(left, right):
            for c in range(3):
                total[c] += row[3 * x + c]
    return [t / ((right - left) * (bottom - top)) for t in total]


def near(found, expected, tolerance, what):
    for one, other in zip(found, expected):
        if abs(one - other) > tolerance * max(abs(other), 1e-3):
            raise AssertionError(f"{what}: {found}, expected {expected}")
    print(f"{what}: {', '.join(f'{x:.4f}' for x in found)}")


DOWN = App.Rotation()


def diffuse_under_dome():
    """A white furnace: grey under the template's even sky shows the sky's radiance times its colour."""
    scene = Scene("diffuse", "gnurt_standard.usda")
    scene.box("Floor", (4000, 4000, 10), (-2000, -2000, -10), scene.material("Diffuse", Color="(0.5,0.5,0.5)"))
    scene.camera((0, 0, 1000), DOWN)
    albedo = ((0.5 + 0.055) / 1.055) ** 2.4
    near(mean(scene.render(), (0.2, 0.2, 0.8, 0.8)), [0.4 * albedo] * 3, 0.01, "diffuse floor")


CHECKS = [diffuse_under_dome]


def main():
    failed = 0
    for check in CHECKS:
        try:
            check()
        except Exception:
            failed += 1
            print(f"FAILED: {check.__name__}")
            traceback.print_exc(file=sys.stdout)
    print(f"{len(CHECKS) - failed} of {len(CHECKS)} passed", flush=True)
    os._exit(1 if failed else 0)


main()
