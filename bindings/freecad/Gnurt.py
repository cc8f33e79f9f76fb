# SPDX-License-Identifier: GPL-3.0-or-later
"""The renderer "Gnurt" of FreeCAD's Render workbench: the functions that the workbench documents for a renderer.

Each `write_` function returns a part of a stage in USD, in metres with z up. `render` completes the stage and returns
the command. Shaders travel in the stage as `info:osl:sourceCode`; `render` puts them into files.
Tests: `tests/test_plugin.py` with a stand-in of FreeCAD, `tests/judge.py` in FreeCAD.
"""

import os
import re
import shlex
import shutil

import FreeCAD as App

from .gnurt_parts import lights, looks, stage

TEMPLATE_FILTER = "GNU RT templates (gnurt_*.usda)"

#: A line of a template that becomes a sky and a sun: the direction to the sun.
SKY = re.compile(r"(?m)^# Sky, sun at (\S+) (\S+) (\S+)$")

#: Samples per pixel of a project that states none.
SAMPLES = 64


def _warn(text):
    App.Console.PrintWarning(f"[Render][Gnurt] {text}\n")


def write_mesh(name, mesh, material, **kwargs):
    """An object: its triangles in a file of their own, its place, and its material as a shader."""
    folder = kwargs.get("object_directory") or mesh.dirs.export_directory
    path = os.path.join(folder, stage.identifier(name) + ".usda")
    if getattr(mesh, "skip_meshing", False):
        if not os.path.exists(path):
            from Render.rendermesh import SkipMeshingError

            raise SkipMeshingError(path)
    else:
        stage.write_triangles(path, mesh)
    project = kwargs.get("project_directory") or mesh.dirs.project_directory
    relative = os.path.relpath(path, project).replace(os.sep, "/")
    look = looks.shader(stage.identifier(name), material, _warn)
    return stage.object_(name, relative, mesh.transformation.get_matrix_columns(), look)


def write_camera(name, pos, updir, target, fov, resolution=(16, 9), **_):
    """A camera with the vertical angle of view `fov` in degrees. Its placement has `updir` and `target` within."""
    return stage.camera(name, stage.columns(pos), fov, resolution)


def write_pointlight(name, pos, color, power, **_):
    """A point that sends `power` watts in all directions."""
    return lights.point(name, tuple(pos), color.to_linear(precise=True)[:3], power)


def write_arealight(name, pos, size_u, size_v, color, power, transparent=False, **_):
    """A rectangle that sends `power` watts to the side of its z axis."""
    if transparent:
        _warn(f"area light '{name}': shown, because invisible areas are unsupported")
    if size_u <= 0 or size_v <= 0:
        _warn(f"area light '{name}': ignored, because its size is {size_u:g} x {size_v:g} m")
        return ""
    return lights.area(name, stage.columns(pos), size_u, size_v, color.to_linear(precise=True)[:3], power)


def write_sunskylight(
    name, direction, distance, turbidity, albedo, sun_intensity=1.0, sky_intensity=1.0, **_
):
    """A clear sky and its sun."""
    if not 2 <= turbidity <= 10:
        _warn(f"sky '{name}': turbidity {turbidity:g} is out of range, 2 to 10; the nearest is shown")
    return lights.sky(name, tuple(direction), turbidity, albedo, sun_intensity, sky_intensity)


def write_imagelight(name, image, **_):
    """A latitude-longitude picture around the scene."""
    return lights.dome(name, image)


def write_distantlight(name, color, power, direction, angle, **_):
    """Light of `power` watts per square metre from far away, from a disk of `angle` degrees."""
    return lights.distant(name, color.to_linear(precise=True)[:3], power, tuple(direction), float(angle))


def test_cmdline(_):
    """The command that shows whether the program is found."""
    return [_program() or "gnurt", "--version"]


def _settings():
    return App.ParamGet("User parameter:BaseApp/Preferences/Mod/Render")


def _program():
    """The program's path: the preference `GnurtPath`, else the search path."""
    return _settings().GetString("GnurtPath", "").strip("'\"") or shutil.which("gnurt")


def _order(project, cameras):
    """The place of a camera among the project's views, whose text comes in any order. The default camera is first."""
    views = project.Proxy.all_views() if hasattr(project, "Proxy") else []
    names = [stage.identifier(view.Source.FullName) for view in views]
    return lambda name: (names.index(name) if name in names else -1, cameras.index(name))


def render(project, prefix, batch, input_file, output_file, width, height, spp, denoise):
    """Completes the stage and returns the command and the path of its picture.

    Without `batch` FreeCAD's window opens the viewer, which writes no picture.
    """
    program = _program()
    if not program:
        App.Console.PrintError(
            "[Render][Gnurt] gnurt is missing: install it, or set its path in the preference GnurtPath\n"
        )
        return None, None
    views = not batch and getattr(App, "GuiUp", False)
    with open(input_file, encoding="utf-8") as file:
        text = file.read()
    text = SKY.sub(lambda sun: lights.sky("TemplateSky", [float(x) for x in sun.groups()], 3, 0.3, 1, 1), text)
    folder = os.path.dirname(input_file)
    text, shaders = stage.complete(text)
    stage.write_whole(input_file, text)
    words = [program, "view" if views else "render", os.path.basename(input_file)]
    shaders_folder = os.path.splitext(os.path.basename(input_file))[0] + "_shaders"
    words += stage.shader_options(folder, shaders_folder, shaders)
    if cameras := stage.cameras(text):
        words += ["--camera", "/" + max(cameras, key=_order(project, cameras))]
    if not stage.has_surroundings(text):
        # Without it a scene whose materials alone shine gets lights of the program's.
        words += ["--environment", "0,0,0"]
    words += ["--resolution", f"{width}x{height}"]
    if not views:
        words += ["--spp", str(spp or SAMPLES), "--denoise=auto" if denoise else "--denoise=none"]
        words += ["--output", output_file]
    words += shlex.split(_settings().GetString("GnurtParameters", ""))
    return prefix + shlex.join(words), None if views else output_file
