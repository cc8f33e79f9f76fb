# SPDX-License-Identifier: GPL-3.0-or-later
"""GNU RT as a render engine of Blender: `register` and `unregister`. See docs/how-to/blender.md."""

from . import engine, panels, settings


def register():
    settings.register()
    engine.register()
    panels.register()


def unregister():
    panels.unregister()
    engine.unregister()
    settings.unregister()
