# SPDX-License-Identifier: GPL-3.0-or-later
"""An evaluated dependency graph as a scene of the package: objects, instances, materials, lights, world.

Meshes go over as arrays once; other places of the same mesh are instances of it.
"""

import re

import numpy as np

from . import aovs, cameras, catchers, dicing, hashes, images, links, meshes, motion, particles, picture_files, skies, strands, suns, volumes
from .kept import Recorder, digest
from .lamps import Lamp, put_points
from .nodes import Code, compile_tree
from .nodes.surfaces import bump_of_displacement, displacement
from .nodes.tree import fed_by
from .warned import Warned

# From the middle of our latitude-longitude pictures, which is y, to that of Blender's, which is x; degrees.
TURN = -90.0
# Objects that are in all parts of a picture.
PARTS = {"MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES", "POINTCLOUD"}
NOTHING = "surface blender_volume () { Ci = transparent(); }"
# Where there is no material Cycles shows an untouched Principled BSDF: gloss of an index of 1.5 and a roughness of 0.5 on grey.
GREY = 'surface blender_default () { Ci = layer(0.975 * microfacet("ggx", N, vector(0), 0.25, 0.25, 1.5, 0), 0.8 * diffuse(N)); }'


class Surroundings:
    """What the shader of one material of one object reads: the host of `nodes.Code`."""

    def __init__(self, export, material, lit_object, mesh, slot=0, instance=None):
        self.export, self.material, self.object, self.mesh, self.slot, self.instance = export, material, lit_object, mesh, slot, instance
        self.warn = export.warn
        self.holdout = False
        self.masks = export.masks
        self.random_id = 0
        # Whether its vertices are moved; textures stay where they were before.
        self.moves = False

    @property
    def owner(self):
        return f"'{self.material.name}'"

    def image(self, image, user=None):
        return self.export.image(image, user)

    def tiles(self, image):
        return self.export.tiles(image)

    def made_image(self, key, make):
        return self.export.made_image(key, make)

    def generated(self, code):
        if code.kind == "environment":
            return "vector(normalize(I))"
        low, scale = code.attribute("vector", "box_low"), code.attribute("vector", "box_scale")
        at = 'vector(transform("object", P))'
        if self.moves and not code.relief:
            at = code.attribute("vector", "rest")
        return code.var("vector", f"({at} - {low}) * {scale}")

    def world_from_object(self):
        return np.array((self.instance if self.instance is not None else self.object).matrix_world)

    def scale(self):
        """How much longer lengths are in the world than in the object."""
        return float(abs(np.linalg.det(self.world_from_object()[:3, :3])) ** (1 / 3)) or 1.0

    def inverse_of(self, other):
        return np.linalg.inv(np.array(other.matrix_world))

    def camera_from_world(self):
        return np.linalg.inv(self.export.view.world_from_camera)

    def world_from_camera(self):
        return self.export.view.world_from_camera

    def window_from_world(self):
        return self.export.view.window_from_camera @ self.camera_from_world()

    def is_orthographic(self):
        return self.export.view.parameters.get("kind", 0) == 1

    def near(self):
        return self.export.view.parameters.get("near", 0.0)

    def active_uv(self):
        layers = getattr(self.mesh, "uv_layers", None) or ()
        return next((layer.name for layer in layers if layer.active_render), "")

    def is_active_uv(self, name):
        return name == self.active_uv()

    def material_index(self):
        return getattr(self.material, "pass_index", 0)

    def object_values(self):
        """Colour, opacity, index and random number of the object."""
        if self.object is None:
            return (1, 1, 1), 1, 0, 0
        color = self.object.color
        return tuple(color[:3]), color[3], self.object.pass_index, (self.random_id % (1 << 32)) / float((1 << 32) - 1)

    def particle(self):
        """What the node Particle Info gives, if particles show the object."""
        return particles.values(self.instance, self.export.scene_data.frame_current_final)

    def own_set(self, code):
        """The name of the object, to which rays can be restricted."""
        code.uses_object = True
        name = own_name(self.object, self.instance)
        self.export.own_names.add(name)
        return name

    def property_of(self, kind, name):
        """The value of a custom property and its opacity."""
        holders = [self.export.view_layer, self.export.scene_data, self.export.scene_data.world] if kind == "VIEW_LAYER" else [self.object, getattr(self.object, "data", None)]
        for holder in holders:
            if holder is None:
                continue
            try:
                value = holder[name] if not name.startswith("[") and name in holder else holder.path_resolve(name)
            except (ValueError, TypeError, KeyError, AttributeError):
                continue
            if isinstance(value, (int, float, bool)):
                return (float(value),) * 3, 1.0
            if hasattr(value, "__len__") and len(value) >= 3:
                value = [float(x) for x in value]
                return tuple(value[:3]), value[3] if len(value) > 3 else 1.0
        self.warn(f"material {self.owner}: there is no property '{name}' of kind {kind}")
        return (0.0, 0.0, 0.0), 0.0


class Export:
    """A scene of the package in the making. `overrides` replaces materials: a function of an object that returns shader text or None."""

    def __init__(self, depsgraph, size, camera=None, view=None, warned=None, override=None, recorder=None, shapes=None, masks=False, part=None, still=None):
        self.depsgraph, self.size = depsgraph, size
        self.scene_data, self.view_layer = depsgraph.scene, depsgraph.view_layer
        self.warn = warned or Warned()
        # In a mask only Holdout nodes shine.
        self.override, self.masks, self.holds = override, masks, False
        # With shadow catchers the picture has parts.
        self.part = part
        self.scene = recorder or Recorder()
        self.still = still
        self.images, self.materials, self.shaders, self.shown = {}, {}, {}, {}
        # Pictures by their numbers in the package.
        self.pictures = {}
        # By instances of the package: the object and material that they show, for passes.
        self.objects, self.material_indices, self.reads_uv = {}, {}, {}
        # Names in the package's scene by numbers; those to which rays are restricted.
        self.names, self.own_names = {}, set()
        # Names of passes that materials write.
        self.aovs = set()
        # By the object and the path of an instance: the numbers in the package's scene.
        self.numbers = {}
        # Shapes at moments of the shutter by object and instance, and instances whose meshes have such.
        self.shapes, self.bent = shapes or {}, []
        # Numbers of points and spots, which go over together; lights of the package's scene by the names of lights with links.
        self.points, self.linked_lights = [], {}
        self.lamps = sum(found.type == "LIGHT" and found.data.type != "SUN" for found in depsgraph.objects)
        # Objects that are lights for some objects only.
        self.linked = [] if self.is_dark else [found for found in depsgraph.objects if links.are_there(found)]
        self.has_media = volumes.has_media(depsgraph)
        self.view = view or cameras.of_scene(self.scene_data, camera, size, self.warn)

    @property
    def is_dark(self):
        """Whether only surfaces shine."""
        return self.override is not None or self.masks

    def put_all(self, cancelled=lambda: False):
        for instance in self.depsgraph.object_instances:
            if cancelled():
                return False
            found = instance.object
            if found.type == "LIGHT":
                if not self.is_dark:
                    Lamp(self, found, instance.matrix_world, found.data).put()
                continue
            self.put(instance, found)
        put_points(self.scene, self.points)
        self.world()
        links.put(self)
        if self.part is not None:
            catchers.hold_out(self, self.part == "others")
        self.scene.end()
        return True

    # Objects

    def put(self, instance, found):
        """Shows an object at the place of an instance."""
        self.particle_hair(instance, found)
        if not instance.show_self:
            return
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        rays = self.rays_of(found)
        # Parts of a picture have the same instances, so that one becomes the other by changes.
        if not rays and (self.part is None or found.type not in PARTS):
            return
        if found.type in {"MESH", "CURVE", "SURFACE", "FONT", "META"}:
            self.place(instance, found, matrix, rays, self.mesh_of)
        elif found.type == "CURVES":
            self.place(instance, found, matrix, rays, self.curves_of)
        elif found.type == "POINTCLOUD":
            self.place(instance, found, matrix, rays, self.points_of)
        elif found.type == "VOLUME":
            self.volume(found, matrix)
        elif found.type in {"GREASEPENCIL", "GPENCIL"}:
            self.warn(f"object '{found.name}': objects of type {found.type} are not shown")

    def rays_of(self, found):
        """The kinds of rays that meet an object."""
        others = (found.visible_diffuse, found.visible_glossy, found.visible_transmission)
        if len(set(others)) > 1:
            self.warn(f"object '{found.name}': visibility to diffuse, glossy and transmitted rays is the same here")
        rays = ["camera"] if found.visible_camera else []
        rays += ["shadow"] if found.visible_shadow else []
        return catchers.rays_of(found, rays + (["other"] if any(others) else []), self.part)

    def lamp_shows(self, found):
        return found.visible_camera and not self.is_dark and self.part in {None, "others"}

    def key_of(self, instance, found):
        """What tells instances apart that a shader sees as different."""
        persistent = tuple(instance.persistent_id) if instance.is_instance else ()
        return (found.name, persistent)

    def place(self, instance, found, matrix, rays, arrays_of):
        """Adds the mesh of an object, or another place of it."""
        slots = [slot.material for slot in found.material_slots] or [None]
        key = (found.type, found.data.as_pointer() if found.data else 0, tuple(m.as_pointer() if m else 0 for m in slots))
        if found.type not in {"MESH", "CURVES", "POINTCLOUD"} or self.linked:
            key = (*key, found.name)
        own = self.shown.get(key)
        if own is None and key not in self.shown:
            number = arrays_of(instance, found, slots, matrix, rays)
            if number is None:
                self.shown[key] = None
                return
            number, is_own = number
            if not is_own:
                self.shown[key] = number
        elif own is None:
            return
        else:
            number = self.scene.add_instance(own, matrix, rays)
        self.objects[number] = (found, slots)
        self.numbers[self.key_of(instance, found)] = number

    def name_of(self, found, instance):
        """The name of an object, or one that no other place of it has, if rays are restricted to it."""
        name = own_name(found, instance)
        return name if name in self.own_names else found.name

    def volume(self, found, matrix):
        """Shows a volume object at a place."""
        if self.is_dark:
            return
        material = found.material_slots[0].material if found.material_slots else None
        tree = getattr(material, "node_tree", None)
        output = tree.get_output_node("CYCLES") if tree else None
        code = Code("surface", Surroundings(self, material or found, found, None))
        volumes.put_object(self, code, tree, output, found, matrix)

    def mesh_of(self, instance, found, slots, matrix, rays):
        if self.still and found.name_full in self.scene.read and self.still.has(instance, found):
            used = self.scene.read[found.name_full][0]
            numbers, wanted, uses_object = self.materials_of(instance, found, slots, used, found.data)
            number = self.scene.repeat_mesh(found.name_full, self.how(numbers, wanted), matrix, rays)
            if number is not None:
                self.names[number] = self.name_of(found, instance)
                return number, uses_object
        mesh = found.data if found.type == "MESH" else found.to_mesh()
        if mesh is None:
            return None
        try:
            arrays = meshes.MeshArrays(mesh)
            if len(arrays.faces) == 0:
                return None
            return self.add(instance, found, slots, matrix, rays, arrays, mesh)
        finally:
            if found.type != "MESH":
                found.to_mesh_clear()

    def add(self, instance, found, slots, matrix, rays, arrays, mesh):
        """Adds arrays with the materials that they use; the number, and whether it is for this instance alone."""
        of_faces = np.zeros(1, np.int32) if arrays.slots is None else np.clip(arrays.slots, 0, len(slots) - 1)
        used = np.flatnonzero(np.bincount(of_faces))
        numbers, wanted, uses_object = self.materials_of(instance, found, slots, used, mesh)
        name = self.name_of(found, instance)
        properties = {"material": numbers, "transform": matrix, "rays": rays, "name": name}
        if len(numbers) > 1:
            places = np.zeros(len(slots), np.int32)
            places[used] = np.arange(len(used))
            properties["face_materials"] = places[of_faces]
        if arrays.normals is not None:
            properties["normals"] = arrays.normals
        # Coordinates per corner cost time: only what is read goes over.
        coordinates = arrays.uv("") if self.read_coordinates(numbers) and hasattr(mesh, "uv_layers") else None
        if coordinates is not None:
            properties["texcoords"] = coordinates
        made = {}
        for known, (_, name) in wanted.items():
            values = meshes.attribute(arrays, name, self.warn)
            if values is not None:
                made[known] = np.ascontiguousarray(values)
        if made:
            properties["attributes"] = made
        bent = motion.moments(self.shapes.get(self.key_of(instance, found), ()), arrays)
        if bent:
            properties["moments"] = bent
        number = self.scene.add_mesh(arrays.vertices, arrays.faces, **properties)
        self.names[number] = name
        if bent:
            self.bent.append(number)
        elif not instance.is_instance:
            self.scene.meshes[found.name_full] = used, self.how(numbers, wanted), number
        return number, uses_object

    def materials_of(self, instance, found, slots, used, mesh):
        """The numbers of the materials of these slots, the attributes that they read, and whether they are for this object alone."""
        numbers, wanted, uses_object = [], {}, False
        for slot in used:
            number, attributes, is_own = self.material(slots[slot], found, mesh, instance, int(slot))
            numbers.append(number)
            uses_object |= is_own
            for (kind, name), known in attributes.items():
                wanted[known] = (kind, name)
        return numbers, wanted, uses_object

    def read_coordinates(self, numbers):
        return self.override is not None or any(self.reads_uv[number] for number in numbers)

    def how(self, numbers, wanted):
        """A hash of what materials ask of a mesh."""
        return digest(numbers, sorted(wanted.items()), self.read_coordinates(numbers))

    def particle_hair(self, instance, found):
        """Hair of particle systems, which belongs to an emitter."""
        if found.type != "MESH" or instance.is_instance:
            return
        for system in found.particle_systems:
            settings = system.settings
            if settings.type != "HAIR" or settings.render_type != "PATH":
                continue
            matrix = np.array(instance.matrix_world)
            made = strands.of_particles(found, system, matrix)
            slots = [slot.material for slot in found.material_slots] or [None]
            slot = min(max(settings.material - 1, 0), len(slots) - 1)
            if made:
                self.add_strands(instance, found, slots[slot], matrix, self.rays_of(found), made)

    def add_strands(self, instance, found, material, matrix, rays, made):
        """Adds curves; the number, and whether it is for this instance alone."""
        shape = getattr(getattr(self.scene_data, "cycles_curves", None), "shape", "RIBBONS")
        number, attributes, is_own = self.material(material, found, None, instance)
        values = {known: made.value(name.removeprefix("hair:")) for (_, name), known in attributes.items() if name.startswith("hair:")}
        name = self.name_of(found, instance)
        number = self.scene.add_curves(
            made.vertices, made.radii, counts=made.counts, basis="linear" if shape == "THICK_LINEAR" else "catmull-rom",
            form="flat" if shape == "RIBBONS" else "round", material=number, transform=matrix, rays=rays, name=name,
            attributes={known: value for known, value in values.items() if value is not None},
        )
        self.names[number] = name
        return number, is_own

    def curves_of(self, instance, found, slots, matrix, rays):
        made = strands.of_curves(found.data)
        return self.add_strands(instance, found, slots[0], matrix, rays, made) if made else None

    def points_of(self, instance, found, slots, matrix, rays):
        if len(found.data.points) == 0:
            return None
        points = meshes.flat(found.data.points, "co", np.float32, 3)
        radii = meshes.flat(found.data.points, "radius", np.float32)
        number, attributes, is_own = self.material(slots[0], found, None, instance)
        random = hashes.of_number(np.arange(len(points), dtype=np.uint64)).astype(np.float32)
        known = {"point:Position": points.reshape(-1, 3), "point:Radius": radii, "point:Random": random}
        values = {own: np.ascontiguousarray(known[name]) for (_, name), own in attributes.items() if name in known}
        name = self.name_of(found, instance)
        number = self.scene.add_points(points, radii, material=number, transform=matrix, rays=rays, name=name, attributes=values)
        self.names[number] = name
        return number, is_own

    # Materials

    def material(self, material, found, mesh, instance, slot=0):
        """The number of a material, the attributes that it reads, and whether it is that of this object alone."""
        if self.override is not None:
            text = NOTHING if is_volume_alone(material) else self.override(found)
            moved, attributes, uses_object = self.displacement(material, found, mesh, slot, instance, {})
            return self.shader(text, "override", {}, moved=moved), attributes, uses_object
        if material is None:
            return self.shader(GREY, "default", {}), {}, False
        tree = getattr(material, "node_tree", None)
        if tree is None or not getattr(material, "use_nodes", True):
            color = ", ".join(repr(float(x)) for x in material.diffuse_color[:3])
            return self.shader(f"surface blender_plain () {{ Ci = color({color}) * diffuse(N); }}", material.name, {}), {}, False
        host = Surroundings(self, material, found, mesh, slot, instance)
        host.random_id = instance.random_id if instance.is_instance else hashes.of_name(found.name)
        key = (material.as_pointer(), host.active_uv(), dicing.longest_edge(self, found), mesh is None)
        if key in self.materials:
            return self.materials[key]
        code = Code("surface", host)
        output = tree.get_output_node("CYCLES")
        result, medium = [], None
        if output is not None:
            has_relief, method = output.inputs["Displacement"].is_linked, material.displacement_method
            host.moves = has_relief and mesh is not None and method != "BUMP"
            if has_relief and (method == "BUMP" or (method == "BOTH" and host.moves)):
                bump_of_displacement(code, tree, output)
            medium = volumes.of_body(self, code, tree, output, found, np.array(instance.matrix_world)) if mesh is not None and not self.masks else None
            surface = compile_tree(code, tree, output.inputs["Surface"])
            result = [f"Ci = {surface};"] if surface else []
            result += aovs.statements(code, tree) if self.part in {None, "others"} and not self.masks else []
            self.aovs |= code.aovs
        text = NOTHING if is_volume_alone(material) else code.text("blender_material", result or ["Ci = 0;"])
        moved, _, uses_object = self.displacement(material, found, mesh, slot, instance, code.attributes)
        code.uses_object |= uses_object
        number = self.shader(text, material.name, code.textures, material.pass_index, medium, moved)
        self.material_indices[number] = material.pass_index
        self.holds |= host.holdout
        made = (number, code.attributes, code.uses_object)
        if not code.uses_object:
            self.materials[key] = made
        return made

    def displacement(self, material, found, mesh, slot, instance, attributes):
        """Properties of a material that moves vertices, the attributes that it reads in addition to those given, and whether it is of
        this object alone. Materials with bumps, and others, have none."""
        tree = getattr(material, "node_tree", None) if material is not None and getattr(material, "use_nodes", True) else None
        output = tree.get_output_node("CYCLES") if tree is not None else None
        if mesh is None or output is None or not output.inputs["Displacement"].is_linked or material.displacement_method == "BUMP":
            return {}, attributes, False
        host = Surroundings(self, material, found, mesh, slot, instance)
        code = Code("surface", host)
        # One name for what both read.
        code.attributes = attributes
        properties = {"displacement_shader": displacement(code, tree, output), "displacement_textures": code.textures}
        longest = dicing.longest_edge(self, found)
        if longest is not None:
            properties["displacement_edge"] = longest
        return properties, attributes, code.uses_object

    def shader(self, text, name, textures, index=0, medium=None, moved=None):
        """The number of a material with this shader, pass index, medium and displacement."""
        moved = moved or {}
        key = (text, tuple(sorted(textures.items())), index, medium, repr(sorted(moved.items(), key=lambda item: item[0])))
        if key not in self.shaders:
            properties = {"textures": textures} if textures else {}
            properties |= {} if medium is None else {"medium": medium}
            # A surface of a medium that is not seen is no shader: shadow rays pass it without one.
            properties |= {"kind": "boundary"} if text == NOTHING and medium is not None else {"shader": text}
            self.shaders[key] = self.scene.add_material(name, **properties, **moved)
            text += moved.get("displacement_shader", "")
            self.reads_uv[self.shaders[key]] = bool(re.search(r"\(u, v|dPdu", text))
        return self.shaders[key]

    def image(self, image, user=None):
        """The number of a picture, whether its values are coded as sRGB, and its size; or None. `user` chooses the picture of a sequence."""
        if image.source == "SEQUENCE" and user is not None:
            return self.frame_of(image, user)
        if image.source == "MOVIE":
            frame = picture_files.frame_number(user, self.scene_data.frame_current) if user is not None else 1
            return self.read(image, (image.name_full, frame), lambda: images.movie_pixels(image, frame, self.warn))
        return self.read(image, image.name_full, lambda: images.pixels(image, self.warn))

    def read(self, image, key, pixels):
        """Pixels as `image` has pictures, read once for a key."""
        if key not in self.images:
            found, number = pixels(), None
            if found is not None:
                values, space = found
                number = self.scene.add_texture(values, name=image.name, colorspace="linear")
                self.pictures[number] = values
                number = (number, space == "coded", tuple(image.size))
            self.images[key] = number
        return self.images[key]

    def frame_of(self, image, user):
        """The picture of a sequence at this frame."""
        number = picture_files.frame_number(user, self.scene_data.frame_current)
        path = picture_files.of_frame(picture_files.absolute(image), number)
        return self.file(image, path)

    def tiles(self, image):
        """Tiles of an image by their numbers, as `image` has pictures; those without a file are left out."""
        made = {number: self.file(image, place) for number, place in picture_files.tiles(image).items()}
        return {number: found for number, found in made.items() if found is not None}

    def file(self, image, place):
        """A file of an image, or one that is packed, as `image` has pictures."""
        key = place if isinstance(place, str) else place.filepath
        if (image.name_full, key) not in self.images:
            self.images[image.name_full, key] = None
            try:
                if isinstance(place, str):
                    number = self.scene.add_texture(place, name=image.name, colorspace="linear")
                else:
                    with picture_files.Unpacked(place) as path:
                        number = self.scene.add_texture(path, name=image.name, colorspace="linear")
                is_coded = not image.is_float and images.is_coded(image, self.warn)
                self.images[image.name_full, key] = (number, is_coded, tuple(image.size))
            except (OSError, ValueError, RuntimeError) as error:
                self.warn(f"image '{image.name}': {error}")
        return self.images[image.name_full, key]

    def made_image(self, key, make):
        """The number of a picture in linear light that `make` returns, known by a key."""
        if key not in self.images:
            values = make()
            number = self.scene.add_texture(values, name=str(key[0]), colorspace="linear")
            self.pictures[number] = values
            self.images[key] = number
        return self.images[key]

    def light_nodes(self, data, found):
        """The colour that the nodes of a light multiply its own by, with the statements before it."""
        output = data.node_tree.get_output_node("CYCLES")
        if output is None:
            return None
        host = Surroundings(self, data, found, None)
        code = Code("surface", host)
        from .nodes.tree import FOLDER, light_factor

        factor = light_factor(code, data.node_tree, output.inputs["Surface"])
        if factor is None:
            return None
        head = "\n".join([(FOLDER / f"{file}.h").read_text() for file in code.files] + list(code.extra.values()))
        return f"light * {factor}", {"head": head, "lines": "\n".join(f"        {line}" for line in code.lines), "textures": code.textures}

    # World

    def world(self):
        world = self.scene_data.world
        if world is None or self.is_dark:
            self.scene.add_light("environment", radiance=0)
            return
        tree = getattr(world, "node_tree", None)
        if tree is None or not getattr(world, "use_nodes", True):
            self.scene.add_light("environment", radiance=tuple(world.color))
            return
        output = tree.get_output_node("CYCLES")
        host = Surroundings(self, world, None, None)
        code = Code("environment", host)
        result = None
        if output is not None:
            volumes.of_world(self, code, tree, output)
        plain = uniform(tree, output) if output is not None else None
        if plain is not None:
            self.scene.add_light("environment", radiance=plain)
            return
        direct = picture_of(output) if output is not None else None
        number = self.image(direct[0], direct[2]) if direct else None
        if number is not None:
            # In full resolution, which nodes do not have.
            strength = (direct[1],) * 3
            self.scene.add_light("environment", texture=number[0], radiance=strength, up=(0.0, 0.0, 1.0), turn=TURN)
            return
        plain_sky = sky_of(output) if output is not None else None
        if plain_sky is not None:
            # The sun is a light of its own.
            sky, strength = plain_sky
            number = self.made_image((*sky.key(), "alone"), sky.picture)
            self.scene.add_light("environment", texture=number, radiance=(strength,) * 3, up=(0.0, 0.0, 1.0), turn=TURN)
            suns.put(self, sky, strength)
            return
        if output is not None:
            result = compile_tree(code, tree, output.inputs["Surface"])
        if result is None:
            self.scene.add_light("environment", radiance=0)
            return
        text = code.text("blender_world", [f"Ci = {result};"])
        textures = {"textures": code.textures} if code.textures else {}
        self.scene.add_light("environment", shader=text, up=(0.0, 0.0, 1.0), **textures)


def own_name(found, instance):
    """A name that no other place of an object has."""
    places = [str(x) for x in instance.persistent_id if x != 2**31 - 1] if instance is not None and instance.is_instance else []
    return " ".join([found.name, *places]).replace('"', "'")


def is_volume_alone(material):
    """Whether a material has a volume and no surface."""
    tree = getattr(material, "node_tree", None)
    output = tree.get_output_node("CYCLES") if tree and getattr(material, "use_nodes", True) else None
    return output is not None and volumes.is_fed(tree, output.inputs["Volume"]) and not volumes.is_fed(tree, output.inputs["Surface"])


def uniform(tree, output):
    """The radiance of a world that is one colour, or None."""
    found = sole(output.inputs["Surface"])
    if found is None or found.type not in {"BACKGROUND", "EMISSION"}:
        return None
    if found.inputs["Color"].is_linked or found.inputs["Strength"].is_linked:
        return None
    strength = found.inputs["Strength"].default_value
    return tuple(max(x, 0.0) * strength for x in found.inputs["Color"].default_value[:3])


def picture_of(output):
    """The picture around a world that is one picture in linear light, its strength, and the user that chooses its frame; or None."""
    found, strength = background_of(output)
    if found is None or found.type != "TEX_ENVIRONMENT" or found.inputs["Vector"].is_linked:
        return None
    image = found.image
    if image is None or not image.is_float or not is_plain(found.texture_mapping) or found.projection != "EQUIRECTANGULAR":
        return None
    return image, strength, found.image_user


def sky_of(output):
    """The sky that a world is alone, and its strength; or None."""
    found, strength = background_of(output)
    # The coordinates are no input where the node has the disc.
    if found is None or found.type != "TEX_SKY" or any(each.is_linked for each in found.inputs) or not is_plain(found.texture_mapping):
        return None
    sky = skies.of_node(found)
    return None if sky is None else (sky, strength)


def background_of(output):
    """The node that alone gives the colour of a world's background, and the strength; or None and 0."""
    end = sole(output.inputs["Surface"])
    if end is None or end.type != "BACKGROUND" or end.inputs["Strength"].is_linked:
        return None, 0.0
    return sole(end.inputs["Color"]), max(end.inputs["Strength"].default_value, 0.0)


def is_plain(mapping):
    """Whether the mapping within a texture node changes nothing."""
    return tuple(mapping.rotation) == (0, 0, 0) and tuple(mapping.scale) == (1, 1, 1) and tuple(mapping.translation) == (0, 0, 0)


def sole(socket):
    """The node that feeds a socket directly, or None."""
    found = fed_by(socket)
    return found and found[0]
