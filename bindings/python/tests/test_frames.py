# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of animations, beside those of the program."""

import subprocess
import sys

import numpy as np
import pytest

import gnurt

SIZE = (40, 30)


def program(folder, *words):
    """Colours of the files that the program writes, by number."""
    command = [sys.executable, "-m", "gnurt", "render", "-q", "builtin:wind", "-r", "40x30", *words]
    subprocess.run([*command, "--bits", "32", "-o", str(folder / "f.####.exr")], check=True)
    return [gnurt.Picture(file) for file in sorted(folder.glob("f.*.exr"))]


@pytest.fixture(scope="module")
def wind():
    return gnurt.load("builtin:wind")


def test_frames_are_those_of_the_program(wind, tmp_path):
    for window, words in ((None, []), (1, ["--denoise-window", "1"]), (0, ["--denoise-window", "0"])):
        folder = tmp_path / str(window)
        folder.mkdir()
        theirs = program(folder, "--frames", "0..8:2", "--spp", "4", "--seed", "11", "--denoise=built-in", *words)
        options = {"spp": 4, "seed": 11, "denoise": "built-in", "filter": "box", "layers": True}
        ours = list(wind.frames(range(0, 9, 2), *SIZE, denoise_window=window, **options))
        assert len(ours) == len(theirs) == 5
        for number, (frame, b) in enumerate(zip(ours, theirs)):
            # Files have channels by name and colours times opacity.
            frame.save(folder / "own.exr", exact=True)
            a = gnurt.Picture(folder / "own.exr")
            assert np.array_equal(np.asarray(a), np.asarray(b)), f"window {window}, frame {2 * number}"
            assert np.array_equal(a["motion"], b["motion"]), "the layer of motion"
            assert frame.metadata["seed"] == str(11 + 2 * number) and "denoiser" in frame.metadata
        assert np.abs(np.asarray(ours[2]["motion"])).max() > 0.1, "something moves"


def test_the_window_borrows(wind):
    """Noise against many samples is less with neighbours."""
    fine = [np.asarray(p) for p in wind.frames(range(3, 6), *SIZE, spp=256)]

    def error(window):
        found = wind.frames(range(8), *SIZE, spp=4, denoise="built-in", denoise_window=window)
        return np.mean([np.abs(np.asarray(p) - q)[..., :3].mean() for p, q in zip(list(found)[3:6], fine)])

    assert error(3) < 0.95 * error(0)


def test_frames_without_a_filter(wind):
    frames = list(wind.frames(range(5, 8), *SIZE, spp=4, seed=3, fps=10, shutter=0.05))
    for number, picture in zip(range(5, 8), frames):
        single = wind.render(*SIZE, spp=4, seed=3 + number, at=number / 10, shutter=0.05)
        assert np.array_equal(np.asarray(picture), np.asarray(single)), f"frame {number}"
        assert not picture.layers
    assert list(wind.frames(range(0), *SIZE)) == []


def test_one_exposure(wind, tmp_path):
    """Bytes of PNGs are those of the program's frames, whose exposure is measured once."""
    command = [sys.executable, "-m", "gnurt", "render", "-q", "builtin:wind", "-r", "40x30", "--frames", "10..11"]
    subprocess.run([*command, "--spp", "4", "--denoise=built-in", "-o", str(tmp_path / "f.##.png")], check=True)
    for number, picture in zip((10, 11), wind.frames(range(10, 12), *SIZE, spp=4, denoise="built-in", filter="box")):
        picture.save(tmp_path / "own.png")
        own, theirs = (np.asarray(gnurt.Picture(tmp_path / name)) for name in ("own.png", f"f.{number}.png"))
        assert np.array_equal(own, theirs), f"frame {number}"


def test_frames_come_one_by_one(wind):
    shares = []
    frames = wind.frames(range(6), *SIZE, spp=1, denoise="built-in", denoise_window=1, progress=shares.append)
    assert shares == [], "nothing is rendered before it is needed"
    next(frames)
    assert shares and max(shares) <= 1
    assert len(list(frames)) == 5


@pytest.mark.parametrize(
    "arguments, kind, message",
    [
        (dict(numbers=[1, 2]), ValueError, "numbers: expected a range from 0 on"),
        (dict(numbers=range(-1, 4)), ValueError, "numbers: expected a range from 0 on"),
        (dict(numbers=range(4, 0, -1)), ValueError, "numbers: .*positive step"),
        (dict(numbers=range(2**32, 2**32 + 2)), ValueError, "first: expected a whole number"),
        (dict(numbers=range(2), fps=0), ValueError, "fps: expected a number from 0.001"),
        (dict(numbers=range(2), denoise_window=17), ValueError, "denoise_window: .*from 0 to 16"),
        (dict(numbers=range(2), animation="waltz"), ValueError, "animation: unknown clip 'waltz'"),
        (dict(numbers=range(2), at=1.0), TypeError, "at: conflicts with frames"),
        (dict(numbers=range(2), spp=0), ValueError, "spp"),
        (dict(numbers=range(2), motion={}), ValueError, "motion: conflicts"),
    ],
)
def test_wrong(wind, arguments, kind, message):
    with pytest.raises(kind, match=message):
        wind.frames(**arguments)


def test_no_animation():
    with pytest.raises(ValueError, match="frames: the scene has no animation"):
        gnurt.load("builtin:cornell").frames(range(2))
