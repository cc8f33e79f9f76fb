# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray queries on triangle meshes: closest hits, all hits, crossings, inside or outside, distances. And pictures of scenes."""

from ._gnurt import AllHits, Hits, Picture, RayScene as _RayScene, __version__
from ._scene import Camera, Scene, load

__all__ = ["AllHits", "Camera", "Hits", "Picture", "RayScene", "Scene", "__version__", "load"]

#: First bytes of a saved scene.
_MAGIC = b"GNURT ray scene 1\n"


class RayScene(_RayScene):
    """Triangle meshes to be asked with rays and points.

    Arrays are numpy arrays, or whatever numpy makes one of; float32 or float64, with gaps or not. `(1, 3)` goes with any
    number of rays. `threads=0` is one for each core; answers do not depend on it.
    """

    __slots__ = ()

    def __reduce__(self):
        return _restored, (type(self), self.__getstate__())

    def __copy__(self):
        return _restored(type(self), self.__getstate__())

    def __deepcopy__(self, memo):
        return _restored(type(self), self.__getstate__())

    def save(self, path):
        """Writes geometries and instances to a file that `load` reads; a file that is there is replaced at once."""
        import os
        import tempfile

        import numpy as np

        state, arrays = self.__getstate__(), {}
        arrays["meshes"] = np.array([mesh is not None for mesh in state["meshes"]], bool)
        for i, mesh in enumerate(state["meshes"]):
            if mesh is not None:
                arrays[f"vertices{i}"], arrays[f"faces{i}"] = mesh[0], mesh[1]
                if mesh[2] is not None:
                    arrays[f"transform{i}"] = np.array(mesh[2])
        shown = state["instances"]
        arrays["instances"] = np.array([-1 if placed is None else placed[0] for placed in shown], np.int64)
        identity = np.eye(4)
        arrays["places"] = np.array([identity if p is None else p[1] for p in shown], float).reshape(-1, 4, 4)
        folder = os.path.dirname(os.path.abspath(path))
        handle, unfinished = tempfile.mkstemp(dir=folder, prefix=".gnurt-")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_MAGIC)
                np.savez(file, **arrays)
            os.replace(unfinished, path)
        except BaseException:
            os.unlink(unfinished)
            raise

    @classmethod
    def load(cls, path):
        """A scene that `save` wrote. Nothing in the file is run; what is wrong with it is a ValueError."""
        import io
        import zipfile

        import numpy as np

        with open(path, "rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise ValueError(f"{path}: is not a ray scene that save() wrote")
            rest = io.BytesIO(file.read())
        try:
            with np.load(rest, allow_pickle=False) as arrays:
                meshes = []
                for i, is_there in enumerate(arrays["meshes"]):
                    place = arrays.get(f"transform{i}")
                    meshes.append((arrays[f"vertices{i}"], arrays[f"faces{i}"], place) if is_there else None)
                ids, places = arrays["instances"], arrays["places"]
                instances = [None if i < 0 else (int(i), place) for i, place in zip(ids, places, strict=True)]
            return _restored(cls, {"meshes": meshes, "instances": instances})
        except (KeyError, IndexError, TypeError, ValueError, OSError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(f"{path}: is damaged ({error})") from None


def _restored(cls, state):
    scene = cls()
    scene.__setstate__(state)
    return scene
