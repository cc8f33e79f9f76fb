# SPDX-License-Identifier: GPL-3.0-or-later
"""GNU RT under the names of other packages, only when asked."""

import sys as _sys

__all__ = ["install_embreex"]


def install_embreex():
    """`import embreex` finds GNU RT from now on, in place of a package of that name."""
    from . import embreex

    loaded = _sys.modules.get("embreex")
    if loaded is not None and loaded is not embreex:
        raise RuntimeError("embreex: is imported already; call install_embreex() before that")
    _sys.modules["embreex"] = embreex
    for name in ("rtcore", "rtcore_scene", "mesh_construction"):
        _sys.modules[f"embreex.{name}"] = getattr(embreex, name)
