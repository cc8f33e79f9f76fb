# SPDX-License-Identifier: GPL-3.0-or-later
import ctypes
import os

import pytest

import gnurt.anari


def test_the_folder_has_the_library(monkeypatch, tmp_path):
    try:
        folder = gnurt.anari.folder()
    except FileNotFoundError:
        pytest.skip("the ANARI device was not built beside the package")
    library = ctypes.CDLL(os.path.join(folder, gnurt.anari.LIBRARY))
    assert library.anari_library_gnurt_new_library


def test_a_missing_library_is_told(monkeypatch, tmp_path):
    monkeypatch.setattr(gnurt.anari, "__file__", str(tmp_path / "anari.py"))
    monkeypatch.delenv("GNURT_ANARI", raising=False)
    with pytest.raises(FileNotFoundError, match="cargo build --release -p gnurt-anari"):
        gnurt.anari.folder()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / gnurt.anari.LIBRARY).write_bytes(b"")
    monkeypatch.setenv("GNURT_ANARI", str(tmp_path / "elsewhere"))
    assert gnurt.anari.folder() == str(tmp_path / "elsewhere")
