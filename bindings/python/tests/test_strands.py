# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves and spheres of scenes."""

import numpy as np
import pytest

import gnurt


def lit(add):
    """The radiance of a white thing in the middle under an even sky, and of the sky beside it."""
    scene = gnurt.Scene()
    add(scene, scene.add_material("white", color=(0.8, 0.8, 0.8), kind="matte"))
    scene.add_light("environment", radiance=(1, 1, 1))
    camera = gnurt.Camera(eye=(0, 0, 5), target=(0, 0, 0), fov=40)
    picture = scene.render(9, 9, camera=camera, spp=64, integrator="path", denoise=False)
    color = np.asarray(picture)
    return color[4, 4, :3].mean(), color[0, 0, :3].mean()


ALONG = np.array([[x, 0, 0] for x in (-1, -0.5, 0, 0.5, 1)], dtype=np.float32)


@pytest.mark.parametrize("basis", ["linear", "bspline", "catmull-rom"])
@pytest.mark.parametrize("form", ["flat", "round", "oriented"])
def test_curves_are_shown(basis, form):
    normals = np.tile([0.0, 0, 1], (5, 1)) if form == "oriented" else None
    middle, beside = lit(lambda scene, m: scene.add_curves(ALONG, 0.4, basis=basis, form=form, normals=normals, material=m))
    assert 0.7 < middle < 0.9 and abs(beside - 1) < 1e-3


def test_points_are_shown():
    middle, beside = lit(lambda scene, m: scene.add_points(ALONG, np.full(5, 0.4), material=m))
    assert 0.7 < middle < 0.9 and abs(beside - 1) < 1e-3


def test_mistakes_are_named():
    scene = gnurt.Scene()
    with pytest.raises(ValueError, match=r"radii: expected one number or shape \(5,\)"):
        scene.add_curves(ALONG, [1.0, 2.0])
    with pytest.raises(ValueError, match="counts: expected numbers from 0 on whose sum is 5"):
        scene.add_curves(ALONG, 0.1, counts=[4])
    with pytest.raises(ValueError, match="basis: expected"):
        scene.add_curves(ALONG, 0.1, basis="nurbs")
    with pytest.raises(ValueError, match='normals: go with form="oriented"'):
        scene.add_curves(ALONG, 0.1, form="oriented")
    with pytest.raises(ValueError, match="radii: expected finite numbers from 0 on, not -1"):
        scene.add_points(ALONG, -1)


def test_attributes_change_along_strands():
    scene = gnurt.Scene()
    text = "surface share(float share = 0 [[ int interpolated = 1 ]]) { Ci = share * emission(); }"
    material = scene.add_material("share", shader=text)
    ends = np.array([[-1, 0, 0], [1, 0, 0]], dtype=np.float32)
    scene.add_curves(ends, 0.5, basis="linear", form="flat", material=material, attributes={"share": [0.0, 1.0]})
    camera = gnurt.Camera(eye=(0, 0, 5), target=(0, 0, 0), fov=20)
    color = np.asarray(scene.render(9, 9, camera=camera, spp=64, integrator="path", denoise=False))[4, :, 0]
    across = 5 * np.tan(np.radians(10)) * (np.arange(9) - 4) / 4.5
    assert np.allclose(color, (across + 1) / 2, atol=0.01)
    with pytest.raises(ValueError, match=r"attributes: 'share': expected shape \(2, 1 to 16\)"):
        scene.add_curves(ends, 0.5, basis="linear", attributes={"share": [0.0, 1.0, 2.0]})
