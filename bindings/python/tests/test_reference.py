# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/python-calls.md is made from the docstrings."""

import sys
from pathlib import Path

FOLDER = Path(__file__).parents[1]


def test_page():
    sys.path.insert(0, str(FOLDER))
    import reference

    known = FOLDER.parents[1] / "docs/reference/python-calls.md"
    message = "run python bindings/python/reference.py > docs/reference/python-calls.md"
    assert known.read_text() == reference.page(), message
