# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray queries on meshes, points and curves: closest hits, all hits, crossings, inside or outside, distances. And pictures of scenes."""

from ._gnurt import AllHits, Hits, Picture, RayScene as _RayScene, __version__
from ._scene import Camera, Scene, load, read_volume

__all__ = ["AllHits", "Camera", "Hits", "Picture", "RayScene", "Scene", "__version__", "load", "read_volume"]

#: First bytes of a saved scene: of one by itself, and of one with others in it.
_MAGIC = [b"GNURT ray scene 1\n", b"GNURT ray scene 2\n"]

#: What there may be of a geometry that is not of triangles.
_NAMES = (
    ["kind", "vertices", "faces", "grids", "radii", "segments", "basis", "form"]
    + ["normals", "tangents", "normal_tangents", "transform"]
)


class RayScene(_RayScene):
    """Triangles, quads, grids, points and curves to be asked with rays and points.

    Arrays are numpy arrays, or whatever numpy makes one of; float32 or float64, with gaps or not. `(1, 3)` goes with any
    number of rays. `threads=0` is one for each core; answers do not depend on it. `dtype="float64"` keeps vertices as they are
    given and answers in float64: docs/reference/doubles.md.
    """

    __slots__ = ()

    def __reduce__(self):
        return _restored, (type(self), self.__getstate__())

    def __copy__(self):
        return _restored(type(self), self.__getstate__())

    def __deepcopy__(self, memo):
        import copy

        state = self.__getstate__()
        shown = state["instances"]
        state["instances"] = [_showing(placed, lambda it: copy.deepcopy(it, memo)) for placed in shown]
        return _restored(type(self), state)

    def save(self, path):
        """Writes geometries and instances to a file that `load` reads, with the scenes that instances show; a file that is
        there is replaced at once."""
        import os
        import tempfile

        import numpy as np

        states = _states(self)
        is_alone = len(states) == 1
        arrays = {} if is_alone else {"scenes": np.array(len(states))}
        for number, state in enumerate(states):
            _pack(state, "" if is_alone else f"{number}.", arrays)
        folder = os.path.dirname(os.path.abspath(path))
        try:
            handle, unfinished = tempfile.mkstemp(dir=folder, prefix=".gnurt-")
        except OSError as error:
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_MAGIC[not is_alone])
                np.savez(file, **arrays)
            os.replace(unfinished, path)
        except BaseException:
            os.unlink(unfinished)
            raise

    @classmethod
    def load(cls, path):
        """A scene that `save` wrote. Nothing in the file is run; a damaged file is a ValueError."""
        import io
        import zipfile

        import numpy as np

        with open(path, "rb") as file:
            magic = file.read(len(_MAGIC[0]))
            if magic not in _MAGIC:
                raise ValueError(f"{path}: is not a ray scene that save() wrote")
            rest = io.BytesIO(file.read())
        try:
            with np.load(rest, allow_pickle=False) as arrays:
                if magic == _MAGIC[0]:
                    return _restored(cls, _unpacked(arrays, "", []))
                scenes, count = [], int(arrays["scenes"])
                for number in range(count):
                    kind = cls if number == count - 1 else RayScene
                    scenes.append(_restored(kind, _unpacked(arrays, f"{number}.", scenes)))
                return scenes[-1]
        except (KeyError, IndexError, TypeError, ValueError, OSError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(f"{path}: is damaged ({error})") from None


def _showing(placed, other):
    """An instance of a scene, with another in the place of that; instances of geometries as they are."""
    return (other(placed[0]), placed[1]) if placed and isinstance(placed[0], _RayScene) else placed


def _states(scene):
    """What there is of a scene and of all in it: those within others first, which know them by numbers from -2 down."""
    states, numbers = [], {}

    def number(scene):
        if id(scene) not in numbers:
            state = scene.__getstate__()
            state["instances"] = [_showing(placed, number) for placed in state["instances"]]
            states.append(state)
            numbers[id(scene)] = -1 - len(states)
        return numbers[id(scene)]

    number(scene)
    return states


def _pack(state, prefix, arrays):
    """Puts a state into arrays for a file. Instances show geometries, or by numbers from -2 down scenes; -1 is none."""
    import numpy as np

    if "dtype" in state:
        arrays[prefix + "dtype"] = np.array(state["dtype"])
    arrays[prefix + "meshes"] = np.array([mesh is not None for mesh in state["meshes"]], bool)
    for i, mesh in enumerate(state["meshes"]):
        if isinstance(mesh, dict):
            arrays |= {f"{prefix}{name}{i}": np.asarray(value) for name, value in mesh.items()}
        elif mesh is not None:
            arrays[f"{prefix}vertices{i}"], arrays[f"{prefix}faces{i}"] = mesh[0], mesh[1]
            if mesh[2] is not None:
                arrays[f"{prefix}transform{i}"] = np.array(mesh[2])
    shown = state["instances"]
    arrays[prefix + "instances"] = np.array([-1 if placed is None else placed[0] for placed in shown], np.int64)
    identity = np.eye(4)
    places = np.array([identity if placed is None else placed[1] for placed in shown], float)
    arrays[prefix + "places"] = places.reshape(-1, 4, 4)


def _unpacked(arrays, prefix, scenes):
    """What `_pack` made arrays of, where `scenes` are those that instances may show."""
    meshes, instances = [], []
    for i, is_there in enumerate(arrays[prefix + "meshes"]):
        place = arrays.get(f"{prefix}transform{i}")
        if is_there and f"{prefix}kind{i}" in arrays:
            found = {name: arrays[f"{prefix}{name}{i}"] for name in _NAMES if f"{prefix}{name}{i}" in arrays}
            meshes.append({name: value.item() if value.dtype.kind == "U" else value for name, value in found.items()})
            continue
        meshes.append((arrays[f"{prefix}vertices{i}"], arrays[f"{prefix}faces{i}"], place) if is_there else None)
    ids, places = arrays[prefix + "instances"], arrays[prefix + "places"]
    for i, place in zip(ids, places, strict=True):
        shown = int(i) if i >= 0 else None if i == -1 else scenes[-2 - i]
        instances.append(None if shown is None else (shown, place))
    state = {"meshes": meshes, "instances": instances}
    return {**state, "dtype": str(arrays[prefix + "dtype"])} if prefix + "dtype" in arrays else state


def _restored(cls, state):
    scene = cls()
    scene.__setstate__(state)
    return scene
