# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes and their pictures."""

import errno
import logging
import math
import os
import sys
import time
import warnings

from ._gnurt import Scene as _Scene, _read_volume

__all__ = ["Camera", "Scene", "load", "read_volume"]

#: Reading and rendering, at the level INFO. Warnings are Python's: `logging.captureWarnings(True)` logs them, too.
_log = logging.getLogger("gnurt")
_log.addHandler(logging.NullHandler())


class Camera:
    """A camera: where it is, what it looks at, what is up, and its vertical angle of view in degrees.

    `projection` is "perspective", "orthographic" (which shows `view_height` world units), "fisheye" or "panorama". `aperture` is the
    diameter of its lens in world units, 0 for a pinhole; what is in `focus` is that far away, or as far as the target.

    `lens` is a focal length in place of the angle, for a sensor that is `sensor` high: both in millimetres. `shift` is from the view to
    the middle of the picture, to the right and up, in heights of the picture: of perspective and orthographic cameras.
    """

    __slots__ = ("aperture", "eye", "focus", "fov", "name", "projection", "shift", "target", "up", "view_height")

    def __init__(
        self,
        eye,
        target,
        up=(0.0, 1.0, 0.0),
        fov=None,
        name="",
        *,
        projection="perspective",
        view_height=None,
        aperture=0.0,
        focus=None,
        shift=(0.0, 0.0),
        lens=None,
        sensor=24.0,
    ):
        if lens is not None:
            if fov is not None:
                raise ValueError("lens: conflicts with fov; give one of them")
            if not (lens > 0 and sensor > 0):
                raise ValueError(f"lens: expected a focal length and a sensor above 0, not {lens!r} and {sensor!r}")
            fov = math.degrees(2 * math.atan(sensor / (2 * lens)))
        fov = 40.0 if fov is None else fov
        self.eye, self.target, self.up, self.fov, self.name = tuple(eye), tuple(target), tuple(up), fov, name
        self.projection, self.view_height, self.aperture, self.focus = projection, view_height, aperture, focus
        self.shift = tuple(shift)

    def _arguments(self):
        return {name: getattr(self, name) for name in self.__slots__}

    def __eq__(self, other):
        return isinstance(other, Camera) and self._arguments() == other._arguments()

    __hash__ = None

    def __repr__(self):
        more = {"projection": "perspective", "view_height": None, "aperture": 0.0, "focus": None, "shift": (0.0, 0.0)}
        more = [f", {name}={getattr(self, name)!r}" for name, usual in more.items() if getattr(self, name) != usual]
        first = f"eye={self.eye}, target={self.target}, up={self.up}, fov={self.fov}, name={self.name!r}"
        return f"Camera({first}{''.join(more)})"


class Scene(_Scene):
    """Meshes, materials, lights and cameras, of which pictures are made. Each has a number."""

    __slots__ = ()

    def __reduce__(self):
        return _restored, (type(self), self.__getstate__()), getattr(self, "__dict__", None) or None, None, None, _add_attributes

    def __copy__(self):
        return self._copied(getattr(self, "__dict__", {}))

    def __deepcopy__(self, memo):
        import copy

        return self._copied(copy.deepcopy(getattr(self, "__dict__", {}), memo))

    def _copied(self, attributes):
        # Arrays are shared until one of both changes them, and shaders are not compiled again.
        scene = Scene.__new__(type(self))
        scene._take(self)
        _add_attributes(scene, attributes)
        return scene

    def add_material(self, name="", **properties):
        """The number of a new material.

        kind="principled" (metallic, roughness, ior, specular, clearcoat, sheen_color, transmission, thin, anisotropy, iridescence,
        diffuse_transmission, attenuation_color, attenuation_distance, dispersion, scatter_color, scatter_anisotropy,
        subsurface, subsurface_radius, subsurface_anisotropy, ...), "matte", "mirror" or "glass"; all have color, emission and opacity. Colours are linear light, three numbers or one.

        medium=NUMBER of `add_medium` fills closed meshes of the material; kind="boundary" with it is a surface that is not seen.

        Textures are numbers of `add_texture`, or (number, (a, b, c, d, e, f)) for u' = a u + c v + e, v' = b u + d v + f. They are color_texture,
        metallic_roughness_texture, normal_texture (normal_scale), emission_texture, opacity_texture (opacity_channel, opacity_cutoff),
        bump_texture (bump_height), anisotropy_texture; of layers specular, specular_color, clearcoat, clearcoat_roughness, clearcoat_normal,
        sheen_color, sheen_roughness, transmission, iridescence, iridescence_thickness, diffuse_transmission and
        diffuse_transmission_color, each with _texture behind.

        Or shader=FILE or source text in the shading language, parameters={name: number, text or several of them}, and
        textures={name: number} for pictures that it calls by names. "FILE.mtlx", "FILE.mtlx:NODE" and the text of a document are
        materials of MaterialX, whose inputs are the parameters.

        Surfaces are displaced along their normals by displacement=NUMBER, displacement_texture=NUMBER (displacement_channel 0 to 3; with
        displacement_vector="object" or "tangent" its colours are vectors), each minus displacement_midlevel, times
        displacement_scale; or by displacement_shader=FILE or source text (displacement_parameters, displacement_textures).
        A shader with an output vector displacement displaces, too. displacement_edge=LENGTH cuts triangles until no edge is longer,
        displacement_levels=N cuts each triangle into 4^N. Lengths are in the space of the mesh.
        """
        number = self._add_material({"name": name, **properties})
        _warn(self._progress())
        return number

    def set_material(self, material, name="", **properties):
        """Puts another material in the place of one."""
        self._set_material(material, {"name": name, **properties})
        _warn(self._progress())

    def shade(self, material, shader, *, parameters=None, textures=None):
        """Shades the materials of a name, or all ("*"), as the program's --shader does. Returns their numbers.

        shader is a FILE or source text in the shading language, or a document of MaterialX, "FILE.mtlx:NODE". A document with
        several materials gives each of the scene's materials the one of its name. Emission and opacity of the materials stay.
        parameters={name: number, text or several of them}, textures={name: number} as in `add_material`.
        Raises ValueError for an unknown name or a shader that does not compile.
        """
        numbers = self._shade(material, {"shader": shader, "parameters": parameters, "textures": textures})
        _warn(self._progress())
        return numbers

    def add_medium(self, name="", **properties):
        """The number of a new medium: fog, smoke, milk.

        absorption and scattering are coefficients, 1 over world units, emission is the radiance of infinitely much of it that only absorbs:
        three numbers or one each. Directions of scattered light: anisotropy, second_anisotropy, second_share, after Henyey and Greenstein.

        extent="bodies" is within closed meshes whose materials have medium=NUMBER; where they overlap, the highest priority is there,
        and all those with adds=True in addition.
        "around" is outside of these, in a ball of centre and radius, which is infinite without them.

        density (x, y, z) multiplies the coefficients in the cells of the unit cube, emission_grid (x, y, z) or (x, y, z, 3) the emission;
        transform takes the cube to the world. Or file=FILE of OpenVDB or NanoVDB, with the names grid="density" and emission_grid; transform takes its world
        to that of the scene. temperature_grid names a grid of temperatures, of kelvin=1 each: the emission of black bodies, 1 at 2000 K. Such media have extent="free": the box of their grid, in addition to others.
        """
        return self._add_medium({"name": name, **properties})

    def set_medium(self, medium, name="", **properties):
        """Puts another medium in the place of one."""
        self._set_medium(medium, {"name": name, **properties})

    def add_texture(self, source, *, name=None, colorspace="srgb", wrap="repeat", filter="linear"):
        """The number of a new texture. `source` is a file, or an array (height, width) or (height, width, 1 to 4), upper row first: bytes
        in the colour space "srgb" or "linear", or floats in linear light. `wrap` is "repeat", "mirror" or "clamp", or one for u and one
        for v; `filter` is "linear" or "nearest".
        """
        return self._add_texture(_texture(source, name, colorspace, wrap, filter))

    def set_texture(self, texture, source, *, name=None, colorspace="srgb", wrap="repeat", filter="linear"):
        """Puts another texture in the place of one. Shaders that were made before keep the old one."""
        self._set_texture(texture, _texture(source, name, colorspace, wrap, filter))

    def add_mesh(
        self,
        vertices,
        faces=None,
        *,
        name=None,
        normals=None,
        texcoords=None,
        tangents=None,
        colors=None,
        attributes=None,
        face_attributes=None,
        material=None,
        face_materials=None,
        transform=None,
        rays=None,
        moments=None,
    ):
        """The number of a new mesh, put in its place. Takes meshes of trimesh and of Open3D, too: shapes and vertex colours.

        normals, texcoords, tangents, colors and the arrays in attributes={name: array} have a row for each vertex, (n, width), or for each
        corner, (m, 3, width); those in face_attributes have one for each triangle. material is a number, or several, of which
        face_materials (m,) gives each triangle one. rays lists the kinds that see it: "camera", "shadow", "other". transform, name.

        moments={"vertices": arrays, "normals": arrays} are its shapes at times evenly spaced while the shutter is open, for motion={"meshes": ...}.
        """
        given = {
            "name": name,
            "normals": normals,
            "texcoords": texcoords,
            "tangents": tangents,
            "colors": colors,
            "attributes": attributes,
            "face_attributes": face_attributes,
            "material": material,
            "face_materials": face_materials,
            "transform": transform,
            "rays": rays,
        }
        return self._add_mesh(_mesh(vertices, faces, given, moments))

    def add_curves(
        self,
        vertices,
        radii,
        *,
        counts=None,
        basis="bspline",
        form="round",
        normals=None,
        texcoords=None,
        colors=None,
        attributes=None,
        name=None,
        material=None,
        transform=None,
        rays=None,
    ):
        """The number of new curves with a width, put in their place: hair, grass, wires.

        vertices (n, 3) and radii, (n,) or one number, go strand by strand; counts says how many each strand has, and its absence that all
        are one. basis: "linear", "bezier", "bspline", "catmull-rom". form: "flat" ribbons face each ray, "round" ones are tubes,
        "oriented" ones lie across normals (n, 3). texcoords (n, 2), colors (n, 4); attributes have a row for each vertex. Other arguments as of `add_mesh`.
        """
        given = {
            "vertices": vertices,
            "radii": radii,
            "counts": counts,
            "basis": basis,
            "form": form,
            "normals": normals,
            "texcoords": texcoords,
            "colors": colors,
            "attributes": attributes,
            "name": name,
            "material": material,
            "transform": transform,
            "rays": rays,
        }
        return self._add_strands(True, given)

    def add_points(
        self,
        vertices,
        radii,
        *,
        texcoords=None,
        colors=None,
        attributes=None,
        name=None,
        material=None,
        transform=None,
        rays=None,
    ):
        """The number of new spheres around vertices (n, 3) of these radii, (n,) or one number. Other arguments as of `add_curves`."""
        given = {
            "vertices": vertices,
            "radii": radii,
            "texcoords": texcoords,
            "colors": colors,
            "attributes": attributes,
            "name": name,
            "material": material,
            "transform": transform,
            "rays": rays,
        }
        return self._add_strands(False, given)

    def set_mesh(
        self,
        instance,
        vertices,
        faces=None,
        *,
        name=None,
        normals=None,
        texcoords=None,
        tangents=None,
        colors=None,
        attributes=None,
        face_attributes=None,
        material=None,
        face_materials=None,
        moments=None,
    ):
        """Replaces the mesh of an instance, and so of all its instances. Arguments as of `add_mesh`, without
        transform and rays, which `update` changes."""
        given = {
            "name": name,
            "normals": normals,
            "texcoords": texcoords,
            "tangents": tangents,
            "colors": colors,
            "attributes": attributes,
            "face_attributes": face_attributes,
            "material": material,
            "face_materials": face_materials,
        }
        self._set_mesh(instance, _mesh(vertices, faces, given, moments))

    def add_instance(self, instance, transform):
        """The number of a new instance of the mesh of `instance`."""
        return self._add_instance(instance, transform)

    def update(self, instance, *, transform=None, visible=None, vertices=None, material=None, rays=None):
        """Changes the given properties. Vertices and material are those of all instances of its mesh."""
        self._update(instance, transform, visible, vertices, material, rays)

    def add_light(self, kind, **properties):
        """The number of a new light.

        "point" (position, intensity, radius), "spot" (and direction, inner_angle, outer_angle, edge="squared" or "smooth"),
        "directional" (direction, irradiance, angle of its disc).
        With a radius, light comes from a disc that faces the lit point.
        "environment" (radiance, or picture=FILE, texture=NUMBER, sky="day", "evening", "overcast", or shader=, parameters=, textures=;
        turn, up). Angles are in degrees.
        """
        return self._add_light(kind, properties)

    def set_light(self, light, kind, **properties):
        """Puts another light in the place of one."""
        self._set_light(light, kind, properties)

    def add_light_shader(self, shader, *, parameters=None, textures=None):
        """The number of a new light in the shading language, among lights of that kind."""
        number = self._put_light_shader(None, {"shader": shader, "parameters": parameters, "textures": textures})
        _warn(self._progress())
        return number

    def set_light_shader(self, light, shader, *, parameters=None, textures=None):
        """Puts another light in the shading language in the place of one."""
        self._put_light_shader(light, {"shader": shader, "parameters": parameters, "textures": textures})
        _warn(self._progress())

    def set(self, change):
        """Changes a value by text, as the program's --set does: "lights.0.group=key", "materials.gold.roughness=0.3"."""
        self._set(change)

    def add_camera(self, camera):
        """The number of a new camera."""
        return self._add_camera(camera._arguments())

    @property
    def cameras(self):
        """All cameras."""
        return [Camera(**camera) for camera in self._cameras()]

    def save(self, path):
        """Writes it: .glb, .gltf, .obj or .ply. Warns of the losses of the format."""
        for warning in self._save(os.fspath(path)):
            warnings.warn(warning, stacklevel=2)

    def render(self, width=640, height=480, *, progress=None, **options):
        """A picture. Options are those of the program: spp, integrator, camera, at, animation, seed, max_depth, vpls, clamp, guide, caustics,
        noise, pixel_noise, crop, filter, time, denoise, layers, light_groups, crypto_depth, force_diffuse, threads. The shutter opens at `at` for `shutter` seconds.
        layers=True adds the layers of surfaces; a list such as ["normal", "direct", "key=C.*<L.'key'>", "shader.mask", "cryptomatte"] chooses, as --layers does.
        working_space="acescg" computes light in ACEScg; the picture's numbers are linear Rec. 709 all the same.
        light_groups=True adds a layer for each light group, which `Picture.relight` mixes.
        camera_shader=FILE or source text in the shading language, with camera_parameters={name: value}, makes the rays where the
        camera stands; pixel_shader and pixel_parameters compute pixels.
        motion={"instances": {number: matrices}, "cameras": [Camera, ...]} moves them while the shutter is open, at times evenly spaced;
        "meshes": [number, ...] moves the vertices of instances whose meshes have moments.
        `progress` is True, or called with the share that is done."""
        begun = time.monotonic()
        with _told(progress) as tell:
            picture = self._render({"width": width, "height": height, **options}, tell)
        _log.info("rendered %d x %d in %.3f s", picture.width, picture.height, time.monotonic() - begun)
        _warn(self._progress())
        return picture

    def accumulate(self, width=640, height=480, *, progress=None, **options):
        """Pictures, each with more samples than the one before, until there are `spp` of them. Options as of `render`, but for time."""
        if options.pop("time", None) is not None:
            raise TypeError("time: leave the loop when it is over")
        growing = self._grow({"width": width, "height": height, **options})
        samples, complete = 0, False
        while not complete:
            with _told(progress) as tell:
                complete = growing.grow(max(1, min(samples, 16)), tell)
            samples = growing.samples
            _warn(self._progress())
            yield growing.picture()

    def frames(
        self, numbers, width=640, height=480, *, fps=24.0, animation=None, denoise_window=None, progress=None, **options
    ):
        """Pictures of the frames of an animation, one after the other, as the program's --frames renders them.

        `numbers` is a range from 0 on with a positive step, such as range(48). Frame f shows the scene at f / `fps` seconds of
        `animation`, by name, or of the first one, under the seed `seed` + f. `options` are those of `render`, but for at, motion and
        `progress`, which counts each frame. With denoise=True a frame borrows light from `denoise_window` frames on each side, 0 to 16, by
        default 3 or the number that fits into memory; 0 filters each by itself. So a frame comes when those after it have been rendered.
        filter="box" is the program's. With layers=True frames have the layer `motion`. All frames are saved with one exposure, measured at the
        animation's first time. Later changes of the scene do not show. A scene without animation and wrong arguments are a ValueError.
        """
        if not isinstance(numbers, range) or numbers.step < 1 or (numbers and numbers[0] < 0):
            raise ValueError(f"numbers: expected a range from 0 on with a positive step, such as range(48), not {numbers!r}")
        times = {"first": numbers[0] if numbers else 0, "step": numbers.step, "count": len(numbers), "fps": fps}
        times |= {"animation": animation, "denoise_window": denoise_window}
        return _each(self._frames(times, {"width": width, "height": height, **options}), progress)


def _each(frames, progress):
    """The frames, each once it is done."""
    while True:
        with _told(progress) as tell:
            picture = frames.next(tell)
        _warn(frames.progress())
        if picture is None:
            return
        yield picture


def load(source):
    """A scene of a file (.glb, .gltf, .obj, .ply) or "builtin:NAME". What is odd about the file is warned of."""
    begun = time.monotonic()
    try:
        found, told = _Scene._load(os.fspath(source))
    except OSError:
        if not os.path.exists(source):
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), os.fspath(source)) from None
        raise
    for warning in told:
        warnings.warn(warning, stacklevel=2)
    _log.info("read %s in %.3f s", os.fspath(source), time.monotonic() - begun)
    scene = Scene()
    scene._take(found)
    _warn(scene._progress())
    return scene


def read_volume(path, names=None):
    """The grids of a file of OpenVDB or NanoVDB by their names, or those of some names; grids without active voxels are left out.

    Each is an array (x, y, z), or (x, y, z, 3), of the active voxels with a rim of one voxel, and a matrix. The matrix takes the unit cube,
    which the array fills, to the world. `Scene.add_medium` takes both.
    """
    return _read_volume(os.fspath(path), names)


def _restored(cls, state):
    """The scene of a pickle."""
    scene = Scene.__new__(cls)
    scene.__setstate__(state)
    return scene


def _add_attributes(scene, attributes):
    """Those of classes that are derived from `Scene`."""
    for name, value in (attributes or {}).items():
        setattr(scene, name, value)


def _texture(source, name, colorspace, wrap, filter):
    return {"source": source, "name": name, "colorspace": colorspace, "wrap": wrap, "filter": filter}


def _mesh(vertices, faces, properties, moments=None):
    """Arguments of a mesh, others' meshes taken apart; shapes at moments are attributes of it."""
    if moments:
        keys = {f"gnurt:{name}:{k}": array for name in ("vertices", "normals") for k, array in enumerate(moments.get(name) or ())}
        properties = {**properties, "attributes": {**(properties.get("attributes") or {}), **keys}}
    if faces is None:
        vertices, faces, found = _arrays(vertices)
        if properties.get("colors") is None:
            properties = {**properties, "colors": found}
    return {**properties, "vertices": vertices, "faces": faces}


def _warn(lines):
    for line in lines:
        warnings.warn(line, stacklevel=3)


def _arrays(mesh):
    """Vertices, faces and vertex colours of others' meshes."""
    import numpy as np

    if hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):  # Open3D's tensor kind
        colors = mesh.vertex.colors.numpy() if "colors" in mesh.vertex else None
        return mesh.vertex.positions.numpy(), mesh.triangle.indices.numpy(), _linear(colors)
    if hasattr(mesh, "triangles") and hasattr(mesh, "vertices") and not hasattr(mesh, "faces"):  # and its legacy kind
        colors = np.asarray(mesh.vertex_colors) if mesh.has_vertex_colors() else None
        return np.asarray(mesh.vertices), np.asarray(mesh.triangles), _linear(colors)
    if hasattr(mesh, "faces") and hasattr(mesh, "vertices"):  # trimesh
        visual = getattr(mesh, "visual", None)
        colors = visual.vertex_colors if getattr(visual, "kind", None) == "vertex" else None
        return mesh.vertices, mesh.faces, _linear(colors)
    raise TypeError("faces: are missing; give vertices and faces, or a mesh of trimesh or Open3D")


def _linear(colors):
    """Linear light and opacity of colours of screens: bytes, or floats up to 1."""
    import numpy as np

    if colors is None:
        return None
    colors = np.asarray(colors)
    colors = colors / 255 if colors.dtype == np.uint8 else colors.astype(float)
    rgb = colors[:, :3]
    light = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    opacity = colors[:, 3:4] if colors.shape[1] > 3 else np.ones((len(colors), 1))
    return np.concatenate([light, opacity], axis=1)


class _told:
    """What is called with the share that is done; a line on stderr if that is asked for by True."""

    def __init__(self, progress):
        self._is_own = progress is True
        self._progress = self._show if self._is_own else progress or None
        self._shown = None

    def _show(self, done):
        line = f"\rrendering [{'=' * round(32 * done):32}] {done:4.0%}"
        if line != self._shown:
            self._shown = line
            sys.stderr.write(line)
            sys.stderr.flush()

    def __enter__(self):
        return self._progress

    def __exit__(self, *_):
        if self._is_own:
            sys.stderr.write("\r" + " " * 52 + "\r")
            sys.stderr.flush()
