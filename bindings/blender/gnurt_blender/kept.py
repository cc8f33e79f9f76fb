# SPDX-License-Identifier: GPL-3.0-or-later
"""Persistent data: the package's scene of the last frame, changed where this frame differs.

An export calls the same methods in the same order for the same scene. Each call is compared with that of the last frame by a hash of its
contents: equal ones are skipped, others replace what the last frame put there. A scene that is built differently is built anew.
"""

import hashlib

import gnurt
import numpy as np
from gnurt._gnurt import _hash_array

_last = {}


class Rebuild(Exception):
    """The scene of the last frame cannot be changed into this one."""


def digest(*values):
    """A hash of arrays, texts, numbers, and lists and dicts of them."""
    made = hashlib.blake2b(digest_size=16)

    def add(value):
        if isinstance(value, np.ndarray):
            made.update(repr((value.shape, value.dtype.str)).encode())
            made.update(_hash_array(np.ascontiguousarray(value).reshape(-1).view(np.uint8)))
        elif isinstance(value, dict):
            for name in value:
                add(name)
                add(value[name])
        elif isinstance(value, (list, tuple)):
            made.update(b"(")
            for each in value:
                add(each)
            made.update(b")")
        else:
            made.update(repr(value).encode())

    for value in values:
        add(value)
    return made.digest()


class Recorder:
    """A scene of the package that remembers its calls; `log` is that of the frame whose scene is changed, `read` its `meshes`."""

    def __init__(self, scene=None, log=(), read=None):
        self.scene, self.log, self.calls = scene or gnurt.Scene(), log, []
        # By object: the slots that its mesh uses, a hash of how its material reads it, and its number.
        self.read, self.meshes = read or {}, {}

    def _next(self, kind, *keys):
        """The last frame's call at this place: its number and what of it is equal; None in a new scene."""
        place = len(self.calls)
        if not self.log:
            return None, [False] * len(keys)
        if place >= len(self.log) or self.log[place][0] != kind:
            raise Rebuild
        _, number, known = self.log[place]
        return number, [a == b for a, b in zip(known, keys)]

    def _put(self, kind, number, *keys):
        self.calls.append((kind, number, keys))
        return number

    def end(self):
        """Whether nothing of the last frame is left over."""
        if self.log and len(self.calls) != len(self.log):
            raise Rebuild

    def add_material(self, name="", **properties):
        key = digest(properties)
        number, (same,) = self._next("material", key)
        if number is None:
            number = self.scene.add_material(name, **properties)
        elif not same:
            self.scene.set_material(number, name, **properties)
        return self._put("material", number, key)

    def add_medium(self, name="", **properties):
        key = digest(properties)
        number, (same,) = self._next("medium", key)
        if number is None:
            number = self.scene.add_medium(name, **properties)
        elif not same:
            self.scene.set_medium(number, name, **properties)
        return self._put("medium", number, key)

    def add_texture(self, source, **properties):
        key = digest(source, properties)
        number, (same,) = self._next("texture", key)
        if number is None:
            number = self.scene.add_texture(source, **properties)
        elif not same:
            # Shaders keep the pictures that they were made with.
            raise Rebuild
        return self._put("texture", number, key)

    def add_mesh(self, vertices, faces, *, transform=None, rays=None, **properties):
        keys = digest(vertices, faces, properties), digest(transform), digest(rays)
        number, (same, still, seen) = self._next("mesh", *keys)
        if number is None:
            place = {} if transform is None else {"transform": transform}
            number = self.scene.add_mesh(vertices, faces, rays=rays, **place, **properties)
        else:
            if not same:
                self.scene.set_mesh(number, vertices, faces, **properties)
            self._move(number, still, seen, transform, rays)
        return self._put("mesh", number, *keys)

    def repeat_mesh(self, name, how, transform, rays):
        """Shows the mesh of an object as it was in the last frame; None if it must be read for `how`."""
        used, known, number = self.read[name]
        if known != how or len(self.calls) >= len(self.log):
            return None
        keys = self.log[len(self.calls)][2][0], digest(transform), digest(rays)
        found, (_, still, seen) = self._next("mesh", *keys)
        if found != number:
            raise Rebuild
        self._move(number, still, seen, transform, rays)
        self.meshes[name] = used, how, number
        return self._put("mesh", number, *keys)

    def add_curves(self, vertices, radii, **properties):
        return self._add_strands("curves", vertices, radii, properties)

    def add_points(self, vertices, radii, **properties):
        return self._add_strands("points", vertices, radii, properties)

    def _add_strands(self, kind, vertices, radii, properties):
        """Curves or spheres, which are moved but not changed."""
        transform, rays = properties.pop("transform"), properties.pop("rays")
        keys = digest(vertices, radii, properties), digest(transform), digest(rays)
        number, (same, still, seen) = self._next(kind, *keys)
        if number is None:
            add = self.scene.add_curves if kind == "curves" else self.scene.add_points
            number = add(vertices, radii, transform=transform, rays=rays, **properties)
        elif not same:
            raise Rebuild
        else:
            self._move(number, still, seen, transform, rays)
        return self._put(kind, number, *keys)

    def _move(self, number, still, seen, transform, rays):
        change = {} if still or transform is None else {"transform": transform}
        change |= {} if seen else {"rays": rays}
        if change:
            self.scene.update(number, **change)

    def add_instance(self, shown, transform, rays):
        keys = digest(shown), digest(transform), digest(rays)
        number, (same, still, seen) = self._next("instance", *keys)
        if number is None:
            number = self.scene.add_instance(shown, transform)
            self.scene.update(number, rays=rays)
        elif not same:
            raise Rebuild
        else:
            self._move(number, still, seen, transform, rays)
        return self._put("instance", number, *keys)

    def add_light(self, kind, **properties):
        key = digest(kind, properties)
        number, (same,) = self._next("light", key)
        if number is None:
            number = self.scene.add_light(kind, **properties)
        elif not same:
            self.scene.set_light(number, kind, **properties)
        return self._put("light", number, key)

    def add_light_shader(self, shader, *, parameters):
        key = digest(shader, parameters)
        number, (same,) = self._next("light shader", key)
        if number is None:
            number = self.scene.add_light_shader(shader, parameters=parameters)
        elif not same:
            self.scene.set_light_shader(number, shader, parameters=parameters)
        return self._put("light shader", number, key)

    def set(self, change):
        keys = digest(change.rpartition("=")[0]), digest(change)
        number, (is_one, same) = self._next("set", *keys)
        if number is not None and not is_one:
            raise Rebuild
        if not same:
            self.scene.set(change)
        self._put("set", 0, *keys)

    def render(self, *arguments, **options):
        return self.scene.render(*arguments, **options)

    def accumulate(self, *arguments, **options):
        return self.scene.accumulate(*arguments, **options)


class Changing:
    """A scene of the package that becomes other exports of the same objects, and again the first, by changes."""

    def __init__(self, recorder):
        self.scene, self.log = recorder.scene, recorder.calls

    def changed(self, make):
        """The export that `make(recorder)` makes: in this scene where that is possible, else in a new one."""
        recorder = Recorder(self.scene, self.log)
        try:
            return make(recorder)
        except Rebuild:
            return make(Recorder())
        finally:
            # What is there now, also where an export was broken off.
            self.log = [*recorder.calls, *self.log[len(recorder.calls) :]]


def exported(name, make, is_kept):
    """The export that `make(recorder)` makes and its result: in the scene of the last frame of this name where that is possible."""
    if not is_kept:
        _last.pop(name, None)
        return make(Recorder())
    before = _last.pop(name, None)
    export = None
    if before is not None:
        try:
            export = make(Recorder(*before))
        except Rebuild:
            export = None
    if export is None:
        export = make(Recorder())
    if export is not None:
        _last.clear()
        _last[name] = (export.scene.scene, export.scene.calls, export.scene.meshes)
    return export


def holds(name, scene):
    """Whether the last frame of this name is in `scene`."""
    return scene is not None and name in _last and _last[name][0] is scene


def clear():
    """Forgets all scenes."""
    _last.clear()
