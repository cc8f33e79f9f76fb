#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the renderer Gnurt into FreeCAD's Render workbench: install.py [FOLDER OF THE WORKBENCH]"""

import os
import pathlib
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
SKY = HERE.parent / "blender" / "gnurt_blender" / "nodes" / "osl" / "sky.h"


def workbenches():
    """Folders in which FreeCAD's add-on manager installs the workbench."""
    home = pathlib.Path.home()
    roots = [
        home / ".local/share/FreeCAD",
        home / ".FreeCAD",
        home / "Library/Application Support/FreeCAD",
        pathlib.Path(os.environ.get("APPDATA", home)) / "FreeCAD",
    ]
    for root in roots:
        yield root / "Mod" / "Render"
        yield from sorted(root.glob("v*/Mod/Render"))


def install(workbench):
    """Copies the plug-in, its templates and its icon."""
    renderers = workbench / "Render" / "renderers"
    if not renderers.is_dir():
        raise SystemExit(f"error: {workbench}: the folder Render/renderers of FreeCAD's Render workbench is missing")
    parts = renderers / "gnurt_parts"
    shutil.rmtree(parts, ignore_errors=True)
    shutil.copytree(HERE / "gnurt_parts", parts, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(SKY, parts)
    shutil.copy(HERE / "Gnurt.py", renderers)
    shutil.copy(HERE / "Gnurt.svg", workbench / "Render" / "resources" / "icons")
    for template in (HERE / "templates").glob("*.usda"):
        shutil.copy(template, workbench / "templates")


def main(arguments):
    places = [pathlib.Path(a) for a in arguments] or [place for place in workbenches() if place.is_dir()]
    if not places:
        raise SystemExit("error: FreeCAD's Render workbench is missing; install it, or name its folder")
    for place in places:
        install(place)
        print(f"installed into {place}")


if __name__ == "__main__":
    main(sys.argv[1:])
