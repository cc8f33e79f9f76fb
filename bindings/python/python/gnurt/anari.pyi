# SPDX-License-Identifier: GPL-3.0-or-later
from typing import Any

__all__ = ["LIBRARY", "folder", "library", "newDevice"]

LIBRARY: str

def folder() -> str: ...
def library() -> Any: ...
def newDevice(name: str = "default") -> Any: ...
