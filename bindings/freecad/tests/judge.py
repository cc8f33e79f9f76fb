# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders documents in FreeCAD with the Render workbench and checks the pictures: freecadcmd judge.py

GNURT_WORKBENCH is the workbench's folder with the plug-in installed, GNURT_OUT a folder for pictures, GNURT the program.
Pictures are EXR files, read by `gnurt` itself: `gnurt info` has no pixels, so means come from PFM files.
"""

import math
import os
import struct
import sys
import traceback
import zlib

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
#: Looks along +x, +y with z up.
AHEAD_X = App.Rotation(App.Vector(0, -1, 0), App.Vector(0, 0, 1), App.Vector(-1, 0, 0))
AHEAD_Y = App.Rotation(App.Vector(1, 0, 0), App.Vector(0, 0, 1), App.Vector(0, -1, 0))


def linear(x):
    return ((x + 0.055) / 1.055) ** 2.4


GREY = linear(0.5)


def floor(name, template="gnurt_dark.usda", height=1000, **kept):
    """A grey floor of 4 m, seen from above."""
    scene = Scene(name, template, **kept)
    scene.box("Floor", (4000, 4000, 10), (-2000, -2000, -10), scene.material("Diffuse", Color="(0.5,0.5,0.5)"))
    scene.camera((0, 0, height), DOWN)
    return scene


MIDDLE = (0.46, 0.46, 0.54, 0.54)


def write_png(path, rows):
    """An 8-bit RGB picture; rows from the top."""
    raw = b"".join(b"\0" + bytes(value for texel in row for value in texel) for row in rows)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))
    return path


def textured(scene, path, kind, parameter, after="", **values):
    """A material with a texture at one parameter."""
    material = scene.material(kind)
    _, feature, _ = material.Proxy.add_texture(path)
    for key, value in values.items():
        setattr(feature, key, value)
    card = dict(material.Material)
    card[f"Render.{kind}.{parameter}"] = f"Texture;('{feature.Name}','Image'{after})"
    material.Material = card
    return material


def diffuse_under_dome():
    """Grey under an even sky shows the sky's radiance times its colour."""
    near(mean(floor("diffuse", "gnurt_standard.usda").render(), (0.2, 0.2, 0.8, 0.8)), [0.4 * GREY] * 3, 0.01, "diffuse")


def point_light():
    """The irradiance below a point is power / (4 pi height^2)."""
    scene = floor("point")
    scene.light("PointLight", Location=App.Vector(0, 0, 2000), Power=60.0, Color=(1.0, 0.5, 0.0))
    light = 60 / (4 * math.pi * 4) * GREY / math.pi
    near(mean(scene.render(), MIDDLE), [light, light * linear(0.5), 0], 0.02, "point light")


def area_light():
    """The irradiance before a small rectangle is power / (pi distance^2)."""
    scene = floor("area")
    turned = App.Placement(App.Vector(0, 0, 2000), App.Rotation(App.Vector(1, 0, 0), 180))
    scene.light("AreaLight", Placement=turned, SizeU=100, SizeV=50, Power=20.0, Color=(1.0, 1.0, 1.0))
    light = 20 / (math.pi * 4) * GREY / math.pi
    near(mean(scene.render(), MIDDLE), [light] * 3, 0.03, "area light")


def distant_light():
    """Irradiance times the cosine; and the shadow of a box is on the far side."""
    scene = floor("distant", height=4000)
    scene.light("DistantLight", Direction=App.Vector(-1, 0, -1), Power=3.0, Color=(1.0, 1.0, 1.0), Angle=2)
    scene.box("Post", (100, 2000, 800), (200, -1000, 0), scene.material("Diffuse", Color="(0,0,0)"))
    picture = scene.render()
    light = 3 / math.sqrt(2) * GREY / math.pi
    near(mean(picture, (0.75, 0.4, 0.8, 0.6)), [light] * 3, 0.02, "distant light")
    near(mean(picture, (0.46, 0.4, 0.49, 0.6)), [0] * 3, 0.02, "its shadow")


def sky():
    """The sun lights the floor, a post's shadow is opposite to the sun, and the sky is blue."""
    scene = floor("sky", height=4000, size=(192, 128))
    scene.light("SunskyLight", SunDirection=App.Vector(0, 1, 1), Turbidity=3.0)
    scene.box("Post", (2000, 100, 800), (-1000, 200, 0))
    picture = scene.render()
    sun, shade = mean(picture, (0.4, 0.1, 0.6, 0.3)), mean(picture, (0.45, 0.47, 0.55, 0.5))
    print("sun", sun, "shade", shade)
    assert sun[0] > 3 * shade[0] > 0 and shade[2] > shade[0], (sun, shade)


def image_light():
    """The upper half is up, and the picture's right is right of its middle, seen from inside."""
    white, red, green, blue = (255, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255)
    rows = [[white] * 128] * 16 + [[red] * 64 + [blue] * 64] * 16 + [[green] * 128] * 32
    path = write_png(os.path.join(OUT, "around.png"), rows)
    for name, rotation, expected in [
        ("up", App.Rotation(App.Vector(1, 0, 0), 180), (1, 1, 1)),
        ("down", DOWN, (0, 1, 0)),
    ]:
        scene = Scene("image_" + name)
        scene.light("ImageLight", ImageFile=path)
        scene.camera((0, 0, 0), rotation, 20)
        near(mean(scene.render(), (0, 0, 1, 1)), expected, 0.02, "image light, " + name)
    # Towards -y, the middle of the picture: red is left of blue.
    back = AHEAD_Y.multiply(App.Rotation(App.Vector(0, 1, 0), 180)).multiply(App.Rotation(App.Vector(1, 0, 0), 20))
    scene = Scene("image_back")
    scene.light("ImageLight", ImageFile=path)
    scene.camera((0, 0, 0), back, 20)
    picture = scene.render()
    near(mean(picture, (0, 0.3, 0.3, 0.7)), (1, 0, 0), 0.05, "image light, left")
    near(mean(picture, (0.7, 0.3, 1, 0.7)), (0, 0, 1), 0.05, "image light, right")


def emission():
    """A ball of some power has the radiance power / (pi area)."""
    scene = Scene("emission")
    scene.sphere("Ball", 100, (0, 0, 0), scene.material("Emission", Color="(1,1,0)", Power=10))
    scene.camera((0, 0, 500), DOWN)
    light = 10 / (math.pi * 4 * math.pi * 0.01)
    near(mean(scene.render(), MIDDLE), [light, light, 0], 0.02, "emission")


def furnace(kind, expected, tolerance=0.02, **values):
    scene = Scene(kind.lower() + str(len(App.listDocuments())), "gnurt_standard.usda")
    scene.box("Plate", (4000, 4000, 10), (-2000, -2000, -10), scene.material(kind, **values))
    scene.camera((0, 0, 1000), DOWN)
    near(mean(scene.render(), MIDDLE), expected, tolerance, f"{kind} {values}")


def materials():
    """Under an even sky the albedo is seen."""
    furnace("Glass", [0.4] * 3, Color="(1,1,1)", IOR=1.5)
    metal = [0.4 * linear(x) for x in (0.9, 0.6, 0.3)]
    furnace("Substance_PBR", metal, BaseColor="(0.9,0.6,0.3)", Metallic=1, Roughness=0.3, Specular=0.5)
    furnace("Disney", metal, BaseColor="(0.9,0.6,0.3)", Metallic=1, Roughness=0.2, Anisotropic=0.5, Specular=0.5)
    furnace("Disney", [0.4] * 3, BaseColor="(1,1,1)", Specular=0.5, Roughness=0.4, ClearCoat=1, ClearCoatGloss=0.9)
    furnace("Carpaint", [0.4] * 3, 0.03, BaseColor="(1,1,1)")
    furnace("Mixed", [0.4] * 3, 0.05, Diffuse__Color="(1,1,1)", Glass__Color="(1,1,1)", Transparency=0.5)


def textures():
    """Quarters of a picture on the top of a box, straight and turned by 90 degrees."""
    red, green, blue, white = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
    path = write_png(os.path.join(OUT, "quarters.png"), [[red] * 8 + [green] * 8] * 8 + [[blue] * 8 + [white] * 8] * 8)
    for turn, corners in [(0, (red, green, blue, white)), (90, (blue, red, white, green))]:
        scene = Scene(f"texture{turn}", "gnurt_standard.usda", (64, 64))
        material = textured(scene, path, "Diffuse", "Color", Scale=1.0, Rotation=turn)
        scene.box("Box", (1000, 1000, 1000), (-500, -500, -1000), material)
        scene.camera((0, 0, 1000), DOWN, 45)
        picture = scene.render()
        for box, color in zip(
            [(0.2, 0.2, 0.4, 0.4), (0.6, 0.2, 0.8, 0.4), (0.2, 0.6, 0.4, 0.8), (0.6, 0.6, 0.8, 0.8)], corners
        ):
            near(mean(picture, box), [0.4 * c / 255 for c in color], 0.02, f"texture at {turn} degrees, {box}")


def normals():
    """A tilted normal map faces the light; a ramp of heights turns away from it."""
    tilted = write_png(os.path.join(OUT, "tilted.png"), [[(218, 128, 218)] * 4] * 4)
    ramp = write_png(os.path.join(OUT, "ramp.png"), [[(x, x, x) for x in range(256)]] * 4)
    grey = linear(0.8) / math.pi * 3
    for parameter, path, after, cosine in [("Normal", tilted, ", 1.0", 1.0), ("Bump", ramp, ", 0.5", 0.5 / math.sqrt(2.5))]:
        scene = Scene(parameter.lower(), size=(64, 64))
        material = textured(scene, path, "Diffuse", parameter, after, Scale=1.0)
        card = dict(material.Material)
        card["Render.Diffuse.Color"] = "(0.8,0.8,0.8)"
        material.Material = card
        scene.box("Box", (1000, 1000, 1000), (-500, -500, -1000), material)
        scene.light("DistantLight", Direction=App.Vector(-1, 0, -1), Power=3.0, Color=(1.0, 1.0, 1.0), Angle=0)
        scene.camera((0, 0, 1000), DOWN, 45)
        near(mean(scene.render(), (0.3, 0.3, 0.7, 0.7)), [grey * cosine] * 3, 0.05, parameter)


def cameras_and_copies():
    """The last camera counts, and an object that is shown twice is one object."""
    scene = floor("copies", "gnurt_standard.usda")
    scene.camera((0, 0, 500), App.Rotation(App.Vector(1, 0, 0), 180))
    scene.show(scene.doc.getObject("Floor"))
    near(mean(scene.render(), (0, 0, 1, 1)), [0.4] * 3, 0.01, "second camera, towards the sky")


def workbench_materials():
    """The cards that come with the workbench are shown, one ball each."""
    folder = os.path.join(os.environ["GNURT_WORKBENCH"], "materials")
    scene = Scene("cards", "gnurt_sunlight.usda", (480, 200))
    names = sorted(card for card in os.listdir(folder) if card.endswith(".FCMat"))
    import importFCMat

    for i, name in enumerate(names):
        made = Render.make_material(name[:-6], doc=scene.doc)
        card = dict(importFCMat.read(os.path.join(folder, name)))
        made.Material = made.Proxy.import_textures(card, folder)
        scene.sphere("Ball", 100, (300 * (i % 8) - 1050, 300 * (i // 8), 100), made)
    scene.box("Floor", (6000, 6000, 10), (-3000, -3000, -10), scene.material("Diffuse", Color="(0.6,0.6,0.6)"))
    scene.camera((0, -2200, 1500), App.Rotation(App.Vector(1, 0, 0), 58), 25)
    picture = scene.render()
    assert mean(picture, (0, 0, 1, 1))[0] > 0.01, "nothing is seen"


CHECKS = [diffuse_under_dome, point_light, area_light, distant_light, sky, image_light, emission, materials, textures]
CHECKS += [normals, cameras_and_copies, workbench_materials]


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
