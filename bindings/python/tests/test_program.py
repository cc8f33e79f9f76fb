# SPDX-License-Identifier: GPL-3.0-or-later
"""The program in the package, run as its users run it."""

import signal
import subprocess
import sys
import time

PROGRAM = [sys.executable, "-m", "gnurt"]


def run(*words):
    return subprocess.run([*PROGRAM, *words], capture_output=True, text=True)


def test_a_picture(tmp_path):
    picture = tmp_path / "a.png"
    done = run("render", "-q", "builtin:cornell", "-r", "32x24", "--spp", "2", "-o", str(picture))
    assert (done.returncode, done.stderr) == (0, "")
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_statuses_and_names():
    done = run("--version")
    assert done.returncode == 0 and done.stdout.startswith("gnurt "), "what is printed arrives, though no program of Rust ends"
    done = run("render", "builtin:cornell", "--spq", "2")
    assert done.returncode == 2 and done.stderr.count("error: ") == 1 and "--spp" in done.stderr
    assert run("render", "missing.glb").returncode == 1
    assert run("oslinfo", "--help").returncode == 0


def test_ctrl_c_saves(tmp_path):
    picture = tmp_path / "a.png"
    words = ["render", "builtin:cornell", "-r", "640x480", "--spp", "65536", "-o", str(picture)]
    child = subprocess.Popen([*PROGRAM, *words], stderr=subprocess.DEVNULL)
    time.sleep(2)
    child.send_signal(signal.SIGINT)
    assert child.wait(60) in (0, 130)
    assert picture.read_bytes().startswith(b"\x89PNG"), "the picture so far"
