#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The plug-in with a stand-in of FreeCAD: calls the functions that the Render workbench documents, and renders.

test_plugin.py PROGRAM; the test of crates/cli runs it. Prints "passed" at the end.
"""

import collections
import importlib
import pathlib
import subprocess
import sys
import tempfile
import types

HERE = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = sys.argv[1]
WARNINGS = []


class Settings:
    values = {"GnurtPath": PROGRAM, "GnurtParameters": "--quiet"}

    def GetString(self, name, fallback=""):
        return self.values.get(name, fallback)


def stand_in():
    """A module FreeCAD with the console and the settings."""
    console = types.SimpleNamespace(PrintWarning=WARNINGS.append, PrintError=WARNINGS.append)
    module = types.ModuleType("FreeCAD")
    module.Console, module.GuiUp, module.ParamGet = console, False, lambda _: Settings()
    sys.modules["FreeCAD"] = module


class Color:
    def __init__(self, *rgb):
        self.rgb = rgb

    def to_linear(self, precise=False):
        assert precise
        return tuple(x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in self.rgb) + (1.0,)


class Placement:
    def __init__(self, x=0, y=0, z=0):
        self.moved = (x, y, z)

    def toMatrix(self):
        x, y, z = self.moved
        return types.SimpleNamespace(A=(1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1))


class Square:
    """Two triangles of a square of `size` metres around the origin, facing z, at a height."""

    def __init__(self, size, height):
        r = size / 2
        self.points = [(-r, -r, 0), (r, -r, 0), (r, r, 0), (-r, r, 0)]
        self.facets = [(0, 1, 2), (0, 2, 3)]
        self.uvmap = [0j, 1 + 0j, 1 + 1j, 1j]
        self.vnormals = [(0, 0, 1)] * 4
        columns = [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, height, 1)]
        self.transformation = types.SimpleNamespace(get_matrix_columns=lambda: columns)

    def has_vnormals(self):
        return True

    def has_uvmap(self):
        return True


Texture = collections.namedtuple(
    "Texture", "name subname file rotation scale translation_u translation_v fallback is_texture scalar"
)


def material(kind, **values):
    """A material of the workbench; a dotted name is written with two underscores."""
    shader = types.SimpleNamespace()
    for path, value in values.items():
        at = shader
        *folders, last = path.split("__")
        for folder in folders:
            if not hasattr(at, folder):
                setattr(at, folder, types.SimpleNamespace())
            at = getattr(at, folder)
        setattr(at, last, value)
    return types.SimpleNamespace(
        shadertype=kind, shader=shader, default_color=Color(0.5, 0.5, 0.5), passthrough_texture={}
    )


def load(root):
    """Installs the plug-in into a folder that looks like the workbench's, and imports it."""
    workbench = root / "Mod" / "Render"
    for folder in ("Render/renderers", "Render/resources/icons", "templates"):
        (workbench / folder).mkdir(parents=True)
    for package in ("Render", "Render/renderers"):
        (workbench / package / "__init__.py").touch()
    subprocess.run([sys.executable, HERE / "install.py", workbench], check=True, stdout=subprocess.DEVNULL)
    sys.path.insert(0, str(workbench))
    return importlib.import_module("Render.renderers.Gnurt"), workbench


def show(plugin, workbench, folder, template, parts, size=(32, 32)):
    """Renders a template with parts; returns the mean of the picture's middle."""
    folder.mkdir()
    text = (workbench / "templates" / template).read_text()
    camera = plugin.write_camera("D#Camera", Placement(0, 0, 1), (0, 0.001, 0), (0, 0, 0.999), 40, size)
    text = text.replace("# RaytracingCamera (do not remove)", camera)
    text = text.replace("# RaytracingContent (do not remove)", "\n".join(parts(folder)))
    scene = folder / "Project.usda"
    scene.write_text(text)
    command, picture = plugin.render(None, "", True, str(scene), str(folder / "out.pfm"), *size, 32, False)
    # As the workbench does: in the folder of the scene, without a shell.
    import shlex

    done = subprocess.run(shlex.split(command), cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, f"{template}: {command}\n{done.stdout}"
    data = pathlib.Path(picture).read_bytes().split(b"\n", 3)[3]
    import struct

    width, height = size
    values = struct.unpack(f"<{3 * width * height}f", data)
    row = height // 2 * width + width // 2
    picked = [values[3 * (row + i * width + j) : 3 * (row + i * width + j) + 3] for i in (-2, 0, 2) for j in (-2, 0, 2)]
    return [sum(texel[c] for texel in picked) / len(picked) for c in range(3)]


def main():
    stand_in()
    with tempfile.TemporaryDirectory() as root:
        root = pathlib.Path(root)
        plugin, workbench = load(root)
        dirs = lambda folder: {"project_directory": str(folder), "object_directory": str(folder)}  # noqa: E731
        black = root / "black texture.ppm.png"
        # A picture of one black texel, 8 bits of grey.
        black.write_bytes(
            bytes.fromhex(
                "89504e470d0a1a0a0000000d4948445200000001000000010800000000"
                "3a7e9b550000000a49444154789c63600000000200014898593e0000000049454e44ae426082"
            )
        )
        texture = Texture("T", "Image", str(black), 30.0, 0.5, 0.1, 0.2, None, None, 1.0)
        white = Color(1, 1, 1)
        looks = {
            "Diffuse": (material("Diffuse", color=white), [0.4] * 3),
            "Glass": (material("Glass", color=white, ior=1.5), [0.4] * 3),
            "Mixed": (
                material("Mixed", diffuse__color=white, glass__color=white, glass__ior=1.5, transparency=0.0),
                [0.4] * 3,
            ),
            "Carpaint": (material("Carpaint", basecolor=white), [0.4] * 3),
            "Substance_PBR": (material("Substance_PBR", basecolor=white, roughness=0.5, metallic=1.0, specular=0.5), [0.4] * 3),
            "Disney": (material("Disney", basecolor=white, metallic=1.0, roughness=0.3, anisotropic=0.4, bump=texture), [0.4] * 3),
            "Textured": (material("Diffuse", color=texture), [0.0] * 3),
            "Passthrough": (
                material("Passthrough", string="surface {n}_s () {{ Ci = color ({c[0]}, 0.5, 1) * emission (); }}"),
                [0.2140, 0.5, 1.0],
            ),
            "Unknown": (material("Velvet"), [0.4 * 0.2140] * 3),
        }
        for name, (look, expected) in looks.items():
            write = lambda folder, look=look: [plugin.write_mesh("D#Sheet", Square(4, 0.1), look, **dirs(folder))]  # noqa: E731
            found = show(plugin, workbench, root / name, "gnurt_standard.usda", write)
            assert all(abs(a - b) < 0.02 for a, b in zip(found, expected)), f"{name}: {found}, expected {expected}"
        assert any("Velvet" in line for line in WARNINGS), WARNINGS
        grey = material("Diffuse", color=white)
        sheet = lambda folder: plugin.write_mesh("D#Sheet", Square(4, 0), grey, **dirs(folder))  # noqa: E731
        watts = 3.14159265
        lights = {
            "point": (lambda: plugin.write_pointlight("D#Point", (0, 0, 2), white, 16 * watts), 1 / 3.14159265),
            "distant": (lambda: plugin.write_distantlight("D#Far", white, watts, (0, 0, -1), 0.5), 1.0),
        }
        for name, (light, expected) in lights.items():
            found = show(plugin, workbench, root / name, "gnurt_dark.usda", lambda folder: [sheet(folder), light()])
            assert abs(found[0] - expected) < 0.02 * expected, f"{name}: {found}, expected {expected}"
        both = show(
            plugin, workbench, root / "twice", "gnurt_sunlight.usda", lambda folder: [sheet(folder), sheet(folder)]
        )
        assert both[0] > 0.5, f"sunlight: {both}"
        dark = show(plugin, workbench, root / "dark", "gnurt_dark.usda", lambda folder: [sheet(folder)])
        assert dark == [0, 0, 0], f"without light: {dark}"
        Settings.values["GnurtPath"] = ""
        import os

        os.environ["PATH"] = ""
        assert plugin.render(None, "", True, "", "", 1, 1, 1, False) == (None, None)
        assert "gnurt is missing" in WARNINGS[-1], WARNINGS
    print("passed")


main()
