# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of arrays and files, pickled pictures and hits, and logging."""

import copy
import io
import logging
import pickle

import numpy as np
import pytest

import gnurt
from conftest import cube


def rendered(**options):
    return gnurt.load("builtin:cornell").render(24, 16, spp=2, **options)


@pytest.mark.parametrize("options", [{}, {"layers": True}, {"layers": True, "crop": (6, 4, 18, 12)}])
def test_pictures_are_pickled(options):
    picture = rendered(**options)
    for other in (pickle.loads(pickle.dumps(picture)), copy.deepcopy(picture)):
        assert np.array_equal(np.asarray(other), np.asarray(picture)), "the colours"
        assert other.layers == picture.layers
        assert picture.metadata.items() <= other.metadata.items(), "the file adds its writer"
        for layer in picture.layers:
            assert np.array_equal(other[layer], picture[layer], equal_nan=layer != "id"), layer
        assert other.png() == picture.png(), "exposure and rendered part"


def test_damaged_pickles_are_errors():
    restore, (exr, color, *rest) = rendered().__reduce__()
    with pytest.raises(ValueError, match="colours"):
        restore(exr, color[:-4], *rest)
    with pytest.raises((ValueError, OSError)):
        restore(exr[:40], color, *rest)


def test_pictures_of_arrays():
    light = np.random.default_rng(1).random((5, 7, 3), np.float32)
    picture = gnurt.Picture(light)
    assert (picture.width, picture.height, picture.layers) == (7, 5, [])
    assert np.array_equal(np.asarray(picture)[..., :3], light) and (np.asarray(picture)[..., 3] == 1).all()
    grey = np.asarray(gnurt.Picture(np.array([[0, 128, 255]], np.uint8)))
    assert np.allclose(grey[0, :, 0], [0, ((128 / 255 + 0.055) / 1.055) ** 2.4, 1], atol=1e-6), "bytes are sRGB"
    for wrong in (np.zeros(3), np.zeros((2, 2, 5)), np.zeros((0, 2))):
        with pytest.raises(ValueError, match="source"):
            gnurt.Picture(wrong)


def test_pictures_of_files(tmp_path):
    picture = rendered(layers=True)
    picture.save(tmp_path / "a.exr", exact=True)
    again = gnurt.Picture(tmp_path / "a.exr")
    assert set(again.layers) == set(picture.layers) and np.array_equal(again["Z"], picture["Z"])
    with pytest.raises(OSError, match="absent"):
        gnurt.Picture(tmp_path / "absent.exr")


def test_pil():
    Image = pytest.importorskip("PIL.Image")
    picture = rendered()
    shown = Image.open(io.BytesIO(picture.png()))
    assert shown.size == (24, 16)
    assert gnurt.Picture(shown).width == 24


def test_torch():
    torch = pytest.importorskip("torch")
    tensor = torch.as_tensor(np.asarray(rendered()))
    assert np.array_equal(np.asarray(gnurt.Picture(tensor)), tensor.numpy())


def test_logging(caplog):
    with caplog.at_level(logging.INFO, "gnurt"):
        rendered()
    assert [record.name for record in caplog.records] == ["gnurt"] * 2
    assert caplog.messages[0].startswith("read builtin:cornell") and caplog.messages[1].startswith("rendered 24 x 16")


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_hits_are_pickled(scene, rays, dtype):
    both = gnurt.RayScene(dtype)
    inner = gnurt.RayScene(dtype)
    inner.add_triangles(*cube())
    both.add_instance(inner, np.diag([2.0, 1, 1, 1]))
    hits = both.intersect(*rays)
    names = ("t", "prim_id", "geom_id", "inst_id", "u", "v", "normal", "path")
    once = pickle.loads(pickle.dumps(hits))
    for other in (once, copy.deepcopy(hits), pickle.loads(pickle.dumps(once))):
        assert repr(other) == repr(hits) and len(other) == len(hits)
        for name in names:
            ours, theirs = getattr(other, name), getattr(hits, name)
            assert ours.dtype == theirs.dtype and np.array_equal(ours, theirs), name
    restore, arrays = hits.__reduce__()
    with pytest.raises(ValueError, match="damaged"):
        restore(arrays[0][:-1], *arrays[1:])
    every = both.all_hits(*rays)
    other = pickle.loads(pickle.dumps(every))
    assert repr(other) == repr(every) and np.array_equal(other.splits, every.splits) and np.array_equal(other.path, every.path)
