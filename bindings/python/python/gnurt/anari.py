# SPDX-License-Identifier: GPL-3.0-or-later
"""The ANARI device of GNU RT: where its library is, and a device of it for the package `anari`.

Programs find `libanari_library_gnurt.so` where `LD_LIBRARY_PATH` looks, or by `"gnurt," + folder() + "/"` as the name of the library.
"""

import os

#: The file that ANARI's loader opens as "gnurt".
LIBRARY = "libanari_library_gnurt.so"

__all__ = ["LIBRARY", "folder", "library", "newDevice"]


def folder():
    """The folder of the device's library: this package's, or that of the environment variable `GNURT_ANARI`.

    Raises `FileNotFoundError` where neither has it.
    """
    own = os.path.dirname(os.path.abspath(__file__))
    places = [own, os.environ.get("GNURT_ANARI", "")]
    for place in filter(None, places):
        if os.path.exists(os.path.join(place, LIBRARY)):
            return place
    raise FileNotFoundError(
        f"{LIBRARY} is not in {own}; `cargo build --release -p gnurt-anari` builds it in target/release: "
        "copy it there, or name its folder in GNURT_ANARI"
    )


_library = None


def library():
    """The library as the package `anari` (the ANARI SDK's Python package) has loaded it."""
    global _library
    if _library is None:
        import anari

        _library = anari.loadLibrary(f"gnurt,{folder()}/", anari.error_status_handle)
    return _library


def newDevice(name="default"):
    """A device of it for the package `anari`, as the SDK's packages of devices have this function."""
    return library().newDevice(name)
