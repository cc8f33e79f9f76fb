# SPDX-License-Identifier: GPL-3.0-or-later
"""The names of embreex 4."""

from . import mesh_construction, rtcore, rtcore_scene

__all__ = ["mesh_construction", "rtcore", "rtcore_scene"]
__version__ = "4.4.0"
