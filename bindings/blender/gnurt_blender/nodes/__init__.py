# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees as shaders of the shading language. One file per group of nodes; `tree` walks, `osl/` has the functions.

The meaning of each node is that of Blender's manual and of pictures that Cycles renders of it.
Tests: `bindings/blender/tests`.
"""

from . import colors, converters, inputs, patterns, profiles, rays, scripts, surfaces, textures, vectors  # noqa: F401  they fill the table
from .tree import Code, compile_tree

__all__ = ["Code", "compile_tree"]
