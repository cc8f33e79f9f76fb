# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures by views of OpenColorIO."""

import numpy as np
import pytest

import gnurt

CG = "ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1"


def shown(path):
    """Values of the display: a file is sRGB, and is read as linear light."""
    linear = np.asarray(gnurt.Picture(path))[..., :3]
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def test_a_view_has_the_numbers_of_open_color_io(tmp_path):
    picture = gnurt.Picture(np.array([[[0.18, 0.18, 0.18], [1, 1, 1], [4, 0.2, 0.05]]], np.float32))
    path = tmp_path / "a.png"
    picture.save(path, ocio=CG, exposure=0.0)
    # By the package opencolorio 2.6.0.
    expected = np.array([[0.35595] * 3, [0.81197, 0.81198, 0.81197], [1.0, 0.61211, 0.30502]])
    assert np.abs(shown(path)[0] - expected).max() < 0.003
    picture.save(path, ocio=CG, view="Un-tone-mapped", exposure=0.0)
    plain = tmp_path / "b.png"
    picture.save(plain, tone="clamp", exposure=0.0)
    assert np.abs(shown(path) - shown(plain)).max() < 0.005


@pytest.mark.parametrize(
    "name, options, part",
    [
        ("a.png", {"ocio": "none.ocio"}, "none.ocio"),
        ("a.png", {"ocio": CG, "view": "nice"}, "Un-tone-mapped"),
        ("a.png", {"ocio": CG, "tone": "agx"}, "tone"),
        ("a.exr", {"ocio": CG}, "keeps the light"),
        ("a.png", {"view": "nice"}, "ocio"),
    ],
)
def test_mistakes_are_named(tmp_path, name, options, part):
    picture = gnurt.Picture(np.ones((2, 2, 3), np.float32))
    with pytest.raises(ValueError, match=part):
        picture.save(tmp_path / name, **options)
    assert not (tmp_path / name).exists()
