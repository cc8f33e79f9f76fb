# SPDX-License-Identifier: GPL-3.0-or-later
import subprocess
import sys

import pytest


def test_stubs_say_what_is_there():
    pytest.importorskip("mypy")
    checked = subprocess.run([sys.executable, "-m", "mypy.stubtest", "gnurt"], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout + checked.stderr
