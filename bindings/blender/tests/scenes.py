# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of the judge: each a function that fills the empty scene of `common.start`."""

import math
import random

from common import add, background, bpy, camera, emission_of, filled, floor, light, material, nodes_of, np, shape

SCENES = {}


def scene(function):
    SCENES[function.__name__] = function
    return function


def balls(*materials, lamp=True):
    """Balls in a row on a floor."""
    floor()
    count = len(materials)
    for i, made in enumerate(materials):
        shape("uv_sphere", ((i - (count - 1) / 2) * 1.7, 0, 0.8), made, True, radius=0.8, segments=48, ring_count=24)
    camera((0, -7, 2.6), (0, 0, 0.7), 45)
    if lamp:
        light("AREA", (2, -3, 5), 400, size=2)
        background(0.3)


@scene
def diffuse():
    balls(*(material(f"m{i}", "ShaderNodeBsdfDiffuse", Color=c, Roughness=r) for i, (c, r) in enumerate([((0.8, 0.2, 0.1), 0), ((0.2, 0.7, 0.2), 0.5), ((0.8, 0.8, 0.8), 1)])))


@scene
def plastic():
    balls(*(material(f"m{i}", Base_Color=(0.1, 0.3, 0.7), Roughness=r) for i, r in enumerate([0.15, 0.5, 1.0])))


@scene
def black_plastic():
    balls(*(material(f"m{i}", Base_Color=(0, 0, 0), Roughness=0.4, IOR=n) for i, n in enumerate([1.2, 1.5, 2.0])))


@scene
def no_material():
    balls(None, material("m1"), None)


@scene
def metal():
    balls(*(material(f"m{i}", Base_Color=(0.9, 0.6, 0.2), Metallic=1, Roughness=r) for i, r in enumerate([0.1, 0.4, 0.9])))


@scene
def metal_tint():
    balls(*(material(f"m{i}", Base_Color=(0.6, 0.5, 0.4), Metallic=1, Roughness=0.3, Specular_Tint=t) for i, t in enumerate([(1, 1, 1), (0.5, 0.2, 0.9), (0, 0, 0)])))


@scene
def half_metal():
    balls(*(material(f"m{i}", Base_Color=(0.2, 0.6, 0.4), Metallic=x, Roughness=0.3) for i, x in enumerate([0.25, 0.5, 0.75])))


@scene
def glass():
    balls(*(material(f"m{i}", Base_Color=(0.9, 0.95, 1), Transmission_Weight=1, Roughness=r, IOR=1.45) for i, r in enumerate([0, 0.2, 0.4])))


@scene
def coat():
    balls(*(material(f"m{i}", Base_Color=(0.5, 0.05, 0.05), Roughness=0.6, Coat_Weight=w, Coat_Roughness=0.1, Coat_Tint=t) for i, (w, t) in enumerate([(0.5, (1, 1, 1)), (1, (1, 1, 1)), (1, (0.9, 0.7, 0.3))])))


@scene
def sheen():
    balls(*(material(f"m{i}", Base_Color=(0.05, 0.05, 0.2), Roughness=0.8, Sheen_Weight=w, Sheen_Roughness=r) for i, (w, r) in enumerate([(0.5, 0.5), (1, 0.3), (1, 0.8)])))


@scene
def specular_level():
    balls(*(material(f"m{i}", Base_Color=(0.1, 0.1, 0.1), Roughness=0.3, Specular_IOR_Level=l, Specular_Tint=t) for i, (l, t) in enumerate([(0, (1, 1, 1)), (1, (1, 1, 1)), (0.8, (1, 0.3, 0.3))])))


@scene
def anisotropic():
    balls(*(material(f"m{i}", Base_Color=(0.7, 0.7, 0.7), Metallic=1, Roughness=0.35, Anisotropic=a, Anisotropic_Rotation=r) for i, (a, r) in enumerate([(0.4, 0), (0.9, 0), (0.9, 0.25)])))


@scene
def alpha_emission():
    balls(material("a", Base_Color=(0.8, 0.1, 0.1), Alpha=0.5), material("b", Base_Color=(0, 0, 0), Emission_Color=(0.2, 0.5, 1), Emission_Strength=1.5), material("c", "ShaderNodeEmission", Color=(1, 0.6, 0.2), Strength=2.0))


def scattering(i, method, color, **inputs):
    made = material(f"m{i}", "ShaderNodeSubsurfaceScattering", Color=color, **inputs)
    nodes_of(made)[2].falloff = method
    return made


@scene
def subsurface():
    colors = [(0.8, 0.5, 0.3), (0.9, 0.9, 0.9), (0.3, 0.6, 0.4)]
    balls(*(scattering(i, "RANDOM_WALK", c, Scale=s, Radius=(1, 0.5, 0.25)) for i, (c, s) in enumerate(zip(colors, [0.1, 0.5, 0.3]))))


@scene
def skin():
    colors = [(0.8, 0.5, 0.3), (0.9, 0.9, 0.9), (0.3, 0.6, 0.4)]
    balls(*(scattering(i, "RANDOM_WALK_SKIN", c, Scale=s, Radius=(1, 0.5, 0.25), Anisotropy=g) for i, (c, s, g) in enumerate(zip(colors, [0.05, 0.2, 0.1], [0, 0, 0.5]))))


@scene
def principled_subsurface():
    balls(*(material(f"m{i}", Base_Color=(0.8, 0.4, 0.3), Roughness=0.4, Subsurface_Weight=w, Subsurface_Scale=s) for i, (w, s) in enumerate([(0.5, 0.1), (1, 0.1), (1, 0.5)])))


@scene
def old_nodes():
    balls(
        material("a", "ShaderNodeBsdfAnisotropic", Color=(0.8, 0.7, 0.3), Roughness=0.3),
        material("b", "ShaderNodeBsdfTranslucent", Color=(0.6, 0.8, 0.3)),
        material("c", "ShaderNodeBsdfGlass", Color=(1, 0.9, 0.9), Roughness=0.1, IOR=1.5),
        material("d", "ShaderNodeBsdfSheen", Color=(0.7, 0.3, 0.3), Roughness=0.4),
    )


@scene
def mixes():
    def mixed(kind, factor):
        made = material(kind, "ShaderNodeBsdfDiffuse", Color=(0.1, 0.5, 0.1))
        tree, output, shader = nodes_of(made)
        other = tree.nodes.new("ShaderNodeBsdfAnisotropic")
        other.inputs["Roughness"].default_value = 0.25
        mix = tree.nodes.new(kind)
        if kind == "ShaderNodeMixShader":
            mix.inputs[0].default_value = factor
        first = 1 if kind == "ShaderNodeMixShader" else 0
        tree.links.new(shader.outputs[0], mix.inputs[first])
        tree.links.new(other.outputs[0], mix.inputs[first + 1])
        if kind == "ShaderNodeAddShader":
            other.inputs["Color"].default_value = (0.2, 0.2, 0.2, 1)
        tree.links.new(mix.outputs[0], output.inputs["Surface"])
        return made

    balls(mixed("ShaderNodeMixShader", 0.3), mixed("ShaderNodeMixShader", 0.8), mixed("ShaderNodeAddShader", 0))


def stage(lamps=1):
    floor()
    shape("cube", (-1.2, 0, 0.6), material("Cube", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.3, 0.2)), size=1.2)
    shape("uv_sphere", (1.2, 0, 0.7), material("Ball", Base_Color=(0.2, 0.4, 0.7), Roughness=0.3), True, radius=0.7)
    shape("torus", (0, 1.5, 0.3), material("Ring", "ShaderNodeBsdfDiffuse", Color=(0.3, 0.7, 0.3)), True)
    camera((0, -7, 4), (0, 0, 0.4), 45)
    background(0.02)


@scene
def point_lights():
    stage()
    light("POINT", (-2, -2, 3), 200, shadow_soft_size=0)
    light("POINT", (2, -2, 3), 200, shadow_soft_size=0.4, color=(1, 0.7, 0.4))


@scene
def sun():
    stage()
    light("SUN", (3, -4, 6), 2, angle=math.radians(5))


@scene
def spots():
    stage()
    light("SPOT", (-3, -3, 4), 600, (-1, 0, 0), spot_size=0.7, spot_blend=0.5, shadow_soft_size=0)
    light("SPOT", (3, -3, 4), 600, (1, 0, 0), spot_size=0.9, spot_blend=0.15, shadow_soft_size=0.2)


@scene
def areas():
    stage()
    light("AREA", (-3, -2, 4), 120, size=1)
    light("AREA", (3, -2, 4), 120, shape="ELLIPSE", size=2, size_y=0.5, color=(0.5, 0.7, 1))
    light("AREA", (0, 3, 4), 120, shape="RECTANGLE", size=1, size_y=3, spread=math.radians(80))
    light("AREA", (0, -4, 3), 60, shape="DISK", size=0.8)


def linked(made, kind, socket, output=0, **settings):
    """Puts a new node before an input of the shader of a material."""
    tree, _, shader = nodes_of(made)
    node = tree.nodes.new(kind)
    for name, value in settings.items():
        if hasattr(node, name):
            setattr(node, name, value)
        else:
            node.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(node.outputs[output], shader.inputs[socket])
    return node


def picture(name="picture", width=32, height=16, seed=1):
    image = bpy.data.images.new(name, width, height)
    values = np.random.default_rng(seed).random((height, width, 4)).astype(np.float32)
    values[..., 3] = 1
    image.pixels.foreach_set(values.ravel())
    image.update()
    image.pack()
    return image


def lit():
    camera((0, -7, 4), (0, 0, 0.5), 45)
    light("AREA", (2, -4, 6), 600, size=3)
    background(0.2)


@scene
def textured():
    made = material("image", "ShaderNodeBsdfDiffuse")
    linked(made, "ShaderNodeTexImage", "Color", image=picture())
    noisy = material("noise", Roughness=0.5)
    linked(noisy, "ShaderNodeTexNoise", "Base Color", 1, Scale=6.0)
    ground = material("checker", "ShaderNodeBsdfDiffuse")
    linked(ground, "ShaderNodeTexChecker", "Color", Scale=8.0)
    floor(ground)
    shape("cube", (-1.3, 0, 0.8), made, size=1.6)
    shape("uv_sphere", (1.3, 0, 0.9), noisy, True, radius=0.9)
    lit()


def saved(folder, *names):
    """Files of pictures of noise in a folder, each brighter than the one before."""
    import os

    for seed, name in enumerate(names):
        image = picture(f"made {name}", 16, 16, seed + 20)
        values = np.empty(16 * 16 * 4, np.float32)
        image.pixels.foreach_get(values)
        values = values.reshape(-1, 4)
        values[:, :3] *= (seed + 1) / len(names)
        image.pixels.foreach_set(values.ravel())
        image.filepath_raw, image.file_format = os.path.join(folder, name), "PNG"
        image.save()
        bpy.data.images.remove(image)


@scene
def tiles():
    """Tiles of an image by unit squares of the coordinates; one square has none."""
    import tempfile

    folder = tempfile.mkdtemp()
    saved(folder, "skin.1001.png", "skin.1002.png", "skin.1011.png")
    image = bpy.data.images.load(f"{folder}/skin.1001.png")
    image.source, image.filepath = "TILED", f"{folder}/skin.<UDIM>.png"
    for number in (1002, 1011):
        image.tiles.new(number)
    made = material("tiles", "ShaderNodeBsdfDiffuse")
    linked(made, "ShaderNodeTexImage", "Color", image=image)
    wall = shape("plane", (0, 1, 1.5), made, size=3)
    wall.rotation_euler = (math.pi / 2, 0, 0)
    for layer in wall.data.uv_layers:
        for corner in layer.uv:
            corner.vector = corner.vector * 2
    floor()
    lit()
    image.pack()


def cubes_with_films(image):
    """Two cubes at frame 8, with frames of a film that repeats and of one that stops at its end; `image` loads it."""
    floor()
    for x, cyclic in ((-1.3, True), (1.3, False)):
        made = material("film", "ShaderNodeBsdfDiffuse")
        node = linked(made, "ShaderNodeTexImage", "Color", image=image())
        user = node.image_user
        user.frame_duration, user.frame_start, user.frame_offset, user.use_cyclic = 4, 2, 1, cyclic
        user.use_auto_refresh = True
        shape("cube", (x, 0, 0.8), made, size=1.6)
    lit()
    bpy.context.scene.frame_set(8)


@scene
def sequence():
    """Frames of a sequence, one that repeats and one that stops at its end."""
    import tempfile

    folder = tempfile.mkdtemp()
    saved(folder, *(f"film{number:03}.png" for number in range(1, 7)))

    def image():
        loaded = bpy.data.images.load(f"{folder}/film001.png", check_existing=False)
        loaded.source = "SEQUENCE"
        return loaded

    cubes_with_films(image)


def filmed(path, frames=6):
    """A movie file of even pictures, made by the sequencer of a scene of its own."""
    film = bpy.data.scenes.new("film")
    film.render.resolution_x = film.render.resolution_y = 32
    film.frame_start, film.frame_end = 1, frames
    editor = film.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    length = "length" if hasattr(editor, "strips") and bpy.app.version >= (5, 0) else "frame_end"
    for number in range(1, frames + 1):
        strip = strips.new_effect(name=f"{number}", type="COLOR", channel=1, frame_start=number, **{length: 1 if length == "length" else number + 1})
        strip.color = (number / frames, 1 - number / frames, 0.3)
    settings = film.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"
    film.render.ffmpeg.format, film.render.ffmpeg.codec = "MPEG4", "H264"
    film.render.ffmpeg.constant_rate_factor = "LOSSLESS"
    film.render.filepath = path
    bpy.ops.render.render(animation=True, scene=film.name)
    bpy.data.scenes.remove(film)


@scene
def movie():
    """Pictures of a movie, of one that repeats and one that stops at its end."""
    import tempfile

    path = f"{tempfile.mkdtemp()}/film.mp4"
    filmed(path)
    cubes_with_films(lambda: bpy.data.images.load(path, check_existing=True))


@scene
def portal():
    """A room whose window a portal marks: it shines no light."""
    white = material("white", "ShaderNodeBsdfDiffuse", Color=0.7)
    for where, scale, size in (((0, 0, 0), (1, 1, 1), 6), ((0, 0, 3), (1, 1, 1), 6), ((0, 3, 1.5), (1, 0.02, 0.5), 6), ((-3, 0, 1.5), (0.02, 1, 0.5), 6)):
        shape("cube", where, white, size=size).scale = (*scale[:2], scale[2] if len({*scale}) > 1 else 0.01)
    for y in (-2.1, 2.1):
        shape("cube", (3, y, 1.5), white, size=1.8).scale = (0.05, 1, 1.7)
    window = light("AREA", (2.9, 0, 1.5), 10, (0, 0, 1.5), shape="RECTANGLE", size=2.4, size_y=3)
    window.data.cycles.is_portal = True
    shape("uv_sphere", (0, 0.5, 0.8), material("ball", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.4, 0.2)), True, radius=0.8)
    camera((0, -8, 1.6), (0, 0, 1.4), 35)
    background(1.0)


@scene
def bumps():
    rough = material("bump", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.6, 0.5))
    bump = linked(rough, "ShaderNodeBump", "Normal", Strength=0.8, Distance=0.03)
    wave = rough.node_tree.nodes.new("ShaderNodeTexWave")
    wave.inputs["Scale"].default_value = 3
    rough.node_tree.links.new(wave.outputs["Fac"], bump.inputs["Height"])
    mapped = material("map", Base_Color=(0.3, 0.5, 0.3), Roughness=0.4)
    normal = linked(mapped, "ShaderNodeNormalMap", "Normal", Strength=0.7)
    image = mapped.node_tree.nodes.new("ShaderNodeTexImage")
    image.image = picture("normals", 16, 16, 4)
    values = np.empty(16 * 16 * 4, np.float32)
    image.image.pixels.foreach_get(values)
    values = values.reshape(-1, 4)
    values[:, :2], values[:, 2] = 0.35 + 0.3 * values[:, :2], 1.0
    image.image.colorspace_settings.name = "Non-Color"
    image.image.pixels.foreach_set(values.ravel())
    mapped.node_tree.links.new(image.outputs["Color"], normal.inputs["Color"])
    floor()
    shape("uv_sphere", (-1.2, 0, 1), rough, True, radius=1, segments=64, ring_count=32)
    shape("uv_sphere", (1.2, 0, 1), mapped, True, radius=1, segments=64, ring_count=32)
    lit()


@scene
def several_materials():
    floor()
    cube = shape("cube", (-1.2, 0, 0.8), size=1.6)
    for color in ((0.8, 0.1, 0.1), (0.1, 0.8, 0.1), (0.1, 0.1, 0.8)):
        cube.data.materials.append(material("m", "ShaderNodeBsdfDiffuse", Color=color))
    for i, polygon in enumerate(cube.data.polygons):
        polygon.material_index = i % 3
    other = shape("uv_sphere", (1.2, 0, 0.8), smooth=True, radius=0.8)
    paint = other.data.color_attributes.new("paint", "BYTE_COLOR", "CORNER")
    values = np.random.default_rng(5).random((len(other.data.loops), 4)).astype(np.float32)
    paint.data.foreach_set("color", values.ravel())
    made = material("paint", "ShaderNodeBsdfDiffuse")
    linked(made, "ShaderNodeVertexColor", "Color", layer_name="paint")
    other.data.materials.append(made)
    lit()


@scene
def modifiers():
    floor()
    cube = shape("cube", (-2, 0, 0.6), material("a", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.4, 0.2)), size=1.2)
    cube.modifiers.new("bevel", "BEVEL").width = 0.2
    row = shape("cube", (-0.5, 0, 0.3), material("b", "ShaderNodeBsdfDiffuse", Color=(0.3, 0.4, 0.8)), size=0.5)
    array = row.modifiers.new("array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (0, 0, 1.2)
    soft = shape("cube", (1.4, 0, 0.9), material("c", Base_Color=(0.3, 0.7, 0.4), Roughness=0.4), size=1.8)
    soft.modifiers.new("subsurf", "SUBSURF").render_levels = 3
    soft.modifiers["subsurf"].levels = 3
    soft.data.shade_smooth()
    lit()


@scene
def instances():
    floor()
    seed = shape("uv_sphere", (0, 0, 0), material("a", Base_Color=(0.8, 0.3, 0.1), Roughness=0.4), True, radius=0.3)
    group = bpy.data.collections.new("group")
    bpy.context.scene.collection.objects.unlink(seed)
    group.objects.link(seed)
    rng = random.Random(2)
    for _ in range(14):
        empty = add("place", None, (rng.uniform(-2, 2), rng.uniform(-1, 1.5), rng.uniform(0.3, 1.6)))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        empty.scale = (1, 1, rng.uniform(0.6, 1.4))
    lit()


@scene
def particles():
    floor()
    leaf = shape("cube", (0, 0, -5), material("leaf", "ShaderNodeBsdfDiffuse", Color=(0.2, 0.6, 0.2)), size=0.4)
    base = shape("uv_sphere", (0, 0, 1), material("base", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.4, 0.3)), True, radius=1)
    base.modifiers.new("grow", "PARTICLE_SYSTEM")
    settings = base.particle_systems[0].settings
    settings.type, settings.render_type, settings.instance_object = "HAIR", "OBJECT", leaf
    settings.count, settings.hair_length, settings.particle_size = 60, 1.0, 0.5
    settings.use_advanced_hair = True
    lit()


@scene
def geometry_nodes():
    floor()
    base = shape("grid", (0, 0, 0.4), x_subdivisions=6, y_subdivisions=4, size=3)
    tree = bpy.data.node_groups.new("points", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    begin, end, spread, cone = (tree.nodes.new(n) for n in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshCone"))
    cone.inputs["Radius Bottom"].default_value, cone.inputs["Depth"].default_value = 0.2, 0.7
    paint = tree.nodes.new("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = material("cones", Base_Color=(0.6, 0.2, 0.6), Roughness=0.5)
    tree.links.new(begin.outputs[0], spread.inputs["Points"])
    tree.links.new(cone.outputs[0], paint.inputs[0])
    tree.links.new(paint.outputs[0], spread.inputs["Instance"])
    tree.links.new(spread.outputs[0], end.inputs[0])
    base.modifiers.new("nodes", "NODES").node_group = tree
    lit()


@scene
def curves_and_text():
    floor()
    data = bpy.data.curves.new("way", "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.15
    spline = data.splines.new("BEZIER")
    spline.bezier_points.add(2)
    for point, at in zip(spline.bezier_points, ((-2.4, 0, 0.3), (-1, 0.5, 1.4), (0, -0.3, 0.3))):
        point.co, point.handle_left_type, point.handle_right_type = at, "AUTO", "AUTO"
    data.materials.append(material("way", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.5, 0.1)))
    add("way", data)
    words = bpy.data.curves.new("words", "FONT")
    words.body, words.extrude, words.size = "RT", 0.1, 1.6
    words.materials.append(material("words", Base_Color=(0.1, 0.4, 0.8), Roughness=0.4))
    made = add("words", words, (0.3, 0, 0.2))
    made.rotation_euler = (math.pi / 2, 0, 0)
    lit()


@scene
def world_image():
    floor()
    shape("uv_sphere", (-1.1, 0, 0.9), material("m", Base_Color=(0.9, 0.9, 0.9), Metallic=1, Roughness=0.15), True, radius=0.9)
    shape("cube", (1.1, 0, 0.7), material("d", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.6, 0.6)), size=1.4)
    node = background(1.0)
    tree = bpy.context.scene.world.node_tree
    image = tree.nodes.new("ShaderNodeTexEnvironment")
    image.image = picture("sky", 32, 16, 9)
    tree.links.new(image.outputs[0], node.inputs["Color"])
    camera((0, -7, 1.6), (0, 0, 0.9), 45)


@scene
def world_floats():
    world_image()
    image = bpy.data.images.new("floats", 64, 32, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    values = np.random.default_rng(3).random((32, 64, 4)).astype(np.float32)
    values[:, :20] *= 4
    values[10:20, 40:, 0] *= 5
    values[..., 3] = 1
    image.pixels.foreach_set(values.ravel())
    image.update()
    image.pack()
    next(n for n in bpy.context.scene.world.node_tree.nodes if n.type == "TEX_ENVIRONMENT").image = image


@scene
def world_nodes():
    floor()
    shape("uv_sphere", (-1.1, 0, 0.9), material("m", Base_Color=(0.9, 0.9, 0.9), Metallic=1, Roughness=0.1), True, radius=0.9)
    shape("cube", (1.1, 0, 0.7), material("d", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.6, 0.6)), size=1.4)
    node = background(1.0)
    tree = bpy.context.scene.world.node_tree
    where, apart, ramp = (tree.nodes.new(n) for n in ("ShaderNodeTexCoord", "ShaderNodeSeparateXYZ", "ShaderNodeValToRGB"))
    tree.links.new(where.outputs["Generated"], apart.inputs[0])
    tree.links.new(apart.outputs["Z"], ramp.inputs[0])
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (1, 0.7, 0.4, 1), (0.1, 0.3, 1, 1)
    tree.links.new(ramp.outputs[0], node.inputs["Color"])
    camera((0, -7, 1.6), (0, 0, 0.9), 45)


@scene
def sky_preetham():
    floor()
    shape("uv_sphere", (-1.1, 0, 0.9), material("m", "ShaderNodeBsdfDiffuse", Color=0.7), True, radius=0.9)
    node = background(1.0)
    node.inputs["Strength"].default_value = 0.1
    tree = bpy.context.scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type, sky.sun_direction, sky.turbidity = "PREETHAM", (0.3, -0.5, 0.8), 3
    tree.links.new(sky.outputs[0], node.inputs["Color"])
    camera((0, -7, 2.6), (0, 0, 0.9), 35)


def sky(kind, elevation, strength, **settings):
    """Balls and a box below a Sky Texture, whose node is returned."""
    floor()
    shape("uv_sphere", (-1.6, 0, 0.9), material("m", "ShaderNodeBsdfDiffuse", Color=0.7), True, radius=0.9)
    shape("uv_sphere", (1.6, 0, 0.9), material("g", Base_Color=(0.8, 0.8, 0.8), Metallic=1, Roughness=0.4), True, radius=0.9)
    shape("cube", (0, 0.6, 0.6), material("c", Base_Color=(0.6, 0.3, 0.2), Roughness=0.5), size=1.2)
    node = background(1.0)
    node.inputs["Strength"].default_value = strength
    tree = bpy.context.scene.world.node_tree
    made = tree.nodes.new("ShaderNodeTexSky")
    # Blender 4 has one sky of scattering, by another name.
    kinds = {each.identifier for each in made.bl_rna.properties["sky_type"].enum_items}
    made.sky_type = kind if kind in kinds else "NISHITA"
    made.sun_elevation, made.sun_rotation = math.radians(elevation), math.radians(200)
    for name, value in settings.items():
        setattr(made, name if hasattr(made, name) else name.replace("aerosol", "dust"), value)
    tree.links.new(made.outputs[0], node.inputs["Color"])
    camera((0, -7, 2.2), (0, 0, 1.1), 32)
    return made


@scene
def sky_single():
    sky("SINGLE_SCATTERING", 45, 0.1, sun_disc=False)


@scene
def sky_single_sun():
    sky("SINGLE_SCATTERING", 15, 0.05, aerosol_density=3.0)


@scene
def sky_multiple():
    sky("MULTIPLE_SCATTERING", 15, 0.1, sun_disc=False)


@scene
def sky_multiple_sun():
    """The node as it is made, but for the sun's height: the disc is a light."""
    sky("MULTIPLE_SCATTERING", 30, 0.03)


@scene
def sky_evening():
    """The sun in view, near the horizon, from a mountain."""
    sky("MULTIPLE_SCATTERING", 2, 0.2, altitude=3000, sun_size=math.radians(3), sun_intensity=0.5, sun_rotation=math.radians(-12))


@scene
def sky_mixed():
    """A sky that is not the world alone: the disc is in its picture."""
    node = sky("MULTIPLE_SCATTERING", 40, 0.03, sun_size=math.radians(4))
    tree = bpy.context.scene.world.node_tree
    tint = tree.nodes.new("ShaderNodeMix")
    tint.data_type, tint.blend_type = "RGBA", "MULTIPLY"
    tint.inputs[0].default_value, tint.inputs[7].default_value = 1.0, (1, 0.8, 0.6, 1)
    tree.links.new(node.outputs[0], tint.inputs[6])
    tree.links.new(tint.outputs[2], next(n for n in tree.nodes if n.type == "BACKGROUND").inputs["Color"])


@scene
def orthographic():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    bpy.context.scene.camera.data.type = "ORTHO"
    bpy.context.scene.camera.data.ortho_scale = 5
    bpy.context.scene.camera.data.shift_x = 0.1


@scene
def shifted():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    data = bpy.context.scene.camera.data
    data.shift_x, data.shift_y, data.sensor_fit, data.sensor_height = 0.12, -0.08, "VERTICAL", 30
    data.clip_start = 6.6


@scene
def blurred():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    dof = bpy.context.scene.camera.data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop, dof.aperture_blades = True, 6, 0.15, 5
    bpy.context.scene["means only"] = True


@scene
def panorama():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    data = bpy.context.scene.camera.data
    data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"


@scene
def fisheye():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    data = bpy.context.scene.camera.data
    data.type, data.panorama_type, data.fisheye_fov = "PANO", "FISHEYE_EQUIDISTANT", 2.5


@scene
def motion():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    settings = bpy.context.scene.render
    settings.use_motion_blur, settings.motion_blur_shutter = True, 1.0
    ball = next(o for o in bpy.data.objects if o.name.startswith("Sphere"))
    bpy.context.scene.frame_set(1)
    for frame, x in ((0, 0.2), (2, 2.2)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    action = ball.animation_data.action
    # Actions have layers since Blender 4.4.
    bags = [bag for layer in getattr(action, "layers", ()) for strip in layer.strips for bag in strip.channelbags] or [action]
    for curve in (curve for bag in bags for curve in bag.fcurves):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    bpy.context.scene.frame_set(1)
    bpy.context.scene["means only"] = True


@scene
def transparent_film():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    bpy.data.objects["Plane"].scale = (0.25, 0.25, 1)
    bpy.context.scene.render.film_transparent = True


@scene
def transparent_surfaces():
    """Over nothing: a part of a surface, colours that light passes in, and glass, which covers."""
    half = material("half", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.3, 0.2))
    tree, output, shader = nodes_of(half)
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    mix.inputs[0].default_value = 0.6
    tree.links.new(shader.outputs[0], mix.inputs[1])
    tree.links.new(clear.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    pane = material("pane", "ShaderNodeBsdfTransparent", Color=(0.3, 0.8, 0.4))
    shape("plane", (-1.2, 0.3, 1), half, size=1.6, rotation=(1.3, 0, 0))
    shape("plane", (-0.4, -0.6, 1), pane, size=1.4, rotation=(1.3, 0, 0.3))
    shape("uv_sphere", (1.4, 0, 1), material("glass", "ShaderNodeBsdfGlass", IOR=1.3), smooth=True, radius=0.7)
    camera((0, -6, 1.5), (0, 0, 1), 45)
    light("AREA", (2, -4, 6), 600, size=3)
    background(0.4, 0.5, 0.7)
    bpy.context.scene.render.film_transparent = True


@scene
def transparent_media():
    """Over nothing: smoke and fire."""
    cloud = filled("smoke", "ShaderNodeVolumePrincipled", Color=(0.8, 0.6, 0.5), Density=2.0)
    burning = filled("fire", "ShaderNodeVolumePrincipled", Color=(0.5, 0.5, 0.5), Density=0.5, Emission_Strength=0.8, Emission_Color=(1, 0.4, 0.1))
    for x, made in ((-1.2, cloud), (1.2, burning)):
        shape("cube", (x, 0, 1), made, size=1.4, rotation=(0, 0, 0.4))
    camera((0, -6, 1.5), (0, 0, 1), 45)
    light("AREA", (2, -4, 6), 600, size=3)
    background(0.4, 0.5, 0.7)
    bpy.context.scene.render.film_transparent = True
    bpy.context.scene["means only"] = True


def catching(transparent):
    """The floor and the cube catch the shadows of a ball and a ring, coloured by two lamps."""
    stage()
    light("AREA", (2, -4, 6), 400, size=2, color=(1, 0.7, 0.5))
    light("POINT", (-3, -3, 3), 200, shadow_soft_size=0.1, color=(0.5, 0.7, 1))
    background(0.4, 0.5, 0.7)
    bpy.data.objects["Plane"].is_shadow_catcher = True
    bpy.context.scene.render.film_transparent = transparent


@scene
def shadow_catcher():
    catching(False)


@scene
def shadow_catcher_and_motion():
    catching(False)
    bpy.context.scene.render.use_motion_blur, bpy.context.scene.render.motion_blur_shutter = True, 1.0
    ball = bpy.data.objects["Sphere"]
    for frame, x in ((0, 0.4), (2, 2.0)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(1)
    bpy.context.scene["means only"] = True


@scene
def shadow_catcher_alone():
    """Without the background: shadows are opacity."""
    catching(True)
    bpy.data.objects["Cube"].is_shadow_catcher = True


@scene
def holdout():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    bpy.data.objects["Cube"].is_holdout = True
    bpy.context.scene.render.film_transparent = True
    bpy.context.scene["means only"] = True


@scene
def light_nodes():
    stage()
    _, shader = emission_of(light("AREA", (2, -3, 4), 300, size=2))
    shader.inputs["Color"].default_value, shader.inputs["Strength"].default_value = (1, 0.4, 0.2, 1), 0.7


@scene
def falloffs():
    """Points and a spot whose light falls less, or not at all, with the distance."""
    stage()
    for kind, where, name, strength, settings in (
        ("POINT", (-2, -2, 3), "Linear", 40.0, {"shadow_soft_size": 0.0}),
        ("POINT", (2.5, -2, 2), "Quadratic", 150.0, {"shadow_soft_size": 0.2, "color": (1, 0.7, 0.4)}),
        ("SPOT", (0, -3, 4), "Constant", 12.0, {"shadow_soft_size": 0.1, "spot_size": 0.9}),
    ):
        tree, emission = emission_of(light(kind, where, 1.0, **settings))
        node = tree.nodes.new("ShaderNodeLightFalloff")
        node.inputs["Strength"].default_value = strength
        node.inputs["Smooth"].default_value = 0.0 if name == "Linear" else 2.0
        tree.links.new(node.outputs[name], emission.inputs["Strength"])


@scene
def groups():
    inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
    inner.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    inner.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    begin, end, change = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput"), inner.nodes.new("ShaderNodeHueSaturation")
    change.inputs["Hue"].default_value = 0.8
    inner.links.new(begin.outputs[0], change.inputs["Color"])
    inner.links.new(change.outputs[0], end.inputs[0])

    def made(color, muted):
        made = material("grouped", "ShaderNodeBsdfDiffuse")
        tree, _, shader = nodes_of(made)
        group = tree.nodes.new("ShaderNodeGroup")
        group.node_tree = inner
        group.inputs[0].default_value = color
        gamma = tree.nodes.new("ShaderNodeGamma")
        gamma.inputs["Gamma"].default_value, gamma.mute = 3.0, muted
        through = tree.nodes.new("NodeReroute")
        tree.links.new(group.outputs[0], through.inputs[0])
        tree.links.new(through.outputs[0], gamma.inputs[0])
        tree.links.new(gamma.outputs[0], shader.inputs["Color"])
        return made

    balls(made((0.8, 0.2, 0.1, 1), True), made((0.1, 0.7, 0.3, 1), False), made((0.3, 0.3, 0.9, 1), True))


@scene
def visibility():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    bpy.data.objects["Cube"].visible_shadow = False
    bpy.data.objects["Sphere"].visible_camera = False


@scene
def hair():
    floor()
    base = shape("uv_sphere", (0, 0, 1), material("base", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.4, 0.3)), True, radius=1)
    base.modifiers.new("grow", "PARTICLE_SYSTEM")
    settings = base.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length = "HAIR", 200, 0.6
    settings.root_radius, settings.radius_scale, settings.tip_radius = 2.0, 0.02, 1.0
    bpy.context.scene["means only"] = True
    lit()


def tuft(where, paint, count=400, seed=1, radius=0.012):
    """Hair that stands on a square, as a Curves object."""
    rng = np.random.default_rng(seed)
    steps = np.linspace(0, 1, 8)
    roots = np.concatenate([rng.uniform(-0.7, 0.7, (count, 2)), np.zeros((count, 1))], axis=1)
    lean = np.concatenate([rng.normal(0, 0.35, (count, 2)), np.ones((count, 1))], axis=1)
    points = roots[:, None] + lean[:, None] * steps[:, None] * np.where(np.arange(3) < 2, steps[:, None], 1.0) * 1.2
    data = bpy.data.hair_curves.new("tuft")
    data.add_curves([len(steps)] * count)
    data.attributes["position"].data.foreach_set("vector", points.astype(np.float32).ravel())
    widths = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    widths.data.foreach_set("value", np.tile(radius * (1 - 0.7 * steps), count).astype(np.float32))
    data.materials.append(paint)
    return add("tuft", data, where)


def hair_paint(name, parametrization, **values):
    """A material of the node Principled Hair."""
    return material(name, "ShaderNodeBsdfHairPrincipled", model="CHIANG", parametrization=parametrization, **values)


@scene
def hair_colors():
    floor()
    tuft((-1.1, 0, 0), hair_paint("by color", "COLOR", Color=(0.7, 0.3, 0.1)), seed=1)
    tuft((1.1, 0, 0), hair_paint("by absorption", "ABSORPTION", Absorption_Coefficient=(0.2, 0.5, 1.0), Roughness=0.2, Radial_Roughness=0.5, Coat=0.4), seed=2)
    background(0.8)
    bpy.context.scene["means only"] = True
    lit()


@scene
def hair_melanin():
    floor()
    tuft((-1.1, 0, 0), hair_paint("brown", "MELANIN", Melanin=0.6, Melanin_Redness=0.1, Random_Color=0.3, Random_Roughness=0.2), seed=3)
    tuft((1.1, 0, 0), hair_paint("red", "MELANIN", Melanin=0.3, Melanin_Redness=1.0, Tint=(0.9, 0.6, 0.8), Random_Color=0.0, IOR=1.4, Offset=0.1), seed=4)
    bpy.context.scene["means only"] = True
    lit()


@scene
def hair_alone():
    """Without a floor, whose light hides errors of the hair."""
    tuft((0, 0, 0), hair_paint("red", "MELANIN", Melanin=0.5, Melanin_Redness=0.8, Random_Color=0.0, Offset=0.15), count=700, radius=0.02)
    camera((0, -5, 1.8), (0, 0, 0.6), 60)
    light("AREA", (2, -4, 5), 500, size=3)
    bpy.context.scene.render.film_transparent = True
    bpy.context.scene["means only"] = True


def rough_paint(name, parametrization="COLOR", **values):
    """A material of the node Principled Hair, of rough cylinders."""
    return material(name, "ShaderNodeBsdfHairPrincipled", model="HUANG", parametrization=parametrization, **values)


@scene
def rough_hair():
    """Hair as rough cylinders, by colour and by melanin."""
    floor()
    tuft((-1.1, 0, 0), rough_paint("by color", Color=(0.7, 0.3, 0.1)), seed=1)
    tuft((1.1, 0, 0), rough_paint("brown", "MELANIN", Melanin=0.6, Melanin_Redness=0.3, Roughness=0.15, Offset=0.1, IOR=1.4, Aspect_Ratio=0.6), seed=2)
    background(0.8)
    bpy.context.scene["means only"] = True
    lit()


@scene
def rough_hair_alone():
    """Without a floor, whose light hides errors of the hair."""
    paint = rough_paint("red", "ABSORPTION", Absorption_Coefficient=(0.2, 0.5, 1.0), Roughness=0.3, Reflection=0.7, Secondary_Reflection=0.5)
    tuft((0, 0, 0), paint, count=700, radius=0.02)
    camera((0, -5, 1.8), (0, 0, 0.6), 60)
    light("AREA", (2, -4, 5), 500, size=3)
    light("AREA", (-2, 5, 3), 300, size=2)
    bpy.context.scene.render.film_transparent = True
    bpy.context.scene["means only"] = True


@scene
def flat_hair():
    """Sections whose major axis follows normals that are set: light passes beside narrow ones."""
    found = tuft((0, 0, 0), rough_paint("flat", Color=(0.6, 0.4, 0.3), Aspect_Ratio=0.4, Roughness=0.2), count=100, radius=0.05)
    data = found.data
    data.attributes.new("normal_mode", "INT8", "CURVE").data.foreach_set("value", np.full(100, 2, np.int32))
    turns = np.repeat(np.random.default_rng(5).uniform(0, math.pi, 100), 8)
    normals = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1).astype(np.float32)
    data.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", normals.ravel())
    bpy.context.scene["means only"] = True
    camera((0, -5, 1.8), (0, 0, 0.6), 60)
    light("AREA", (2, -4, 5), 500, size=3)
    background(0.3)


@scene
def thick_hair():
    floor()
    tuft((0, 0, 0), hair_paint("round", "COLOR", Color=(0.5, 0.5, 0.6)), count=80, radius=0.05)
    bpy.context.scene.cycles_curves.shape = "THICK"
    bpy.context.scene["means only"] = True
    lit()


@scene
def strands_by_attributes():
    floor()
    paint = material("stripes", "ShaderNodeBsdfDiffuse")
    nodes, links = paint.node_tree.nodes, paint.node_tree.links
    info, body = nodes.new("ShaderNodeHairInfo"), next(n for n in nodes if n.type == "BSDF_DIFFUSE")
    mixed = nodes.new("ShaderNodeCombineColor")
    for name, socket in (("Intercept", 0), ("Random", 1)):
        links.new(info.outputs[name], mixed.inputs[socket])
    links.new(mixed.outputs[0], body.inputs["Color"])
    tuft((0, 0, 0), paint, count=150, radius=0.04)
    bpy.context.scene["means only"] = True
    lit()


@scene
def cloud_of_points():
    floor()
    base = shape("grid", (0, 0, 0.5), x_subdivisions=7, y_subdivisions=7, size=3)
    tree = bpy.data.node_groups.new("cloud", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    begin, end, points, paint = (tree.nodes.new(n) for n in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeMeshToPoints", "GeometryNodeSetMaterial"))
    points.inputs["Radius"].default_value = 0.2
    paint.inputs["Material"].default_value = material("balls", Base_Color=(0.2, 0.5, 0.7), Roughness=0.4)
    tree.links.new(begin.outputs[0], points.inputs["Mesh"])
    tree.links.new(points.outputs[0], paint.inputs[0])
    tree.links.new(paint.outputs[0], end.inputs[0])
    base.modifiers.new("nodes", "NODES").node_group = tree
    lit()


@scene
def pixel_aspect():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    bpy.context.scene.render.pixel_aspect_x = 1.6
    bpy.context.scene["means only"] = True


@scene
def lights_in_view():
    floor()
    shape("uv_sphere", (0, 0.5, 1), material("mirror", Base_Color=(0.9, 0.9, 0.9), Metallic=1, Roughness=0.0), True, radius=1)
    light("POINT", (-1.8, -1, 1.2), 40, shadow_soft_size=0.3)
    light("SPOT", (1.8, -1.5, 2.5), 300, (0, 0.5, 1), shadow_soft_size=0.2, spot_size=1.2)
    light("AREA", (1.9, 1, 1.5), 60, (0, -4, 1), size=1)
    camera((0, -7, 2.6), (0, 0, 0.9), 40)
    bpy.context.scene["means only"] = True


@scene
def many_lights():
    stage()
    rng = random.Random(4)
    for _ in range(30):
        color = (rng.random(), rng.random(), rng.random())
        light("POINT", (rng.uniform(-4, 4), rng.uniform(-4, 3), rng.uniform(1, 4)), 30, shadow_soft_size=0.15, color=color)


@scene
def light_path():
    stage()
    node = background(0.3, 0.5, 1.0)
    tree = bpy.context.scene.world.node_tree
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    mix.inputs[6].default_value, mix.inputs[7].default_value = (1, 0.8, 0.5, 1), (0.1, 0.1, 0.3, 1)
    tree.links.new(mix.outputs[2], node.inputs["Color"])
    made = material("hidden", "ShaderNodeBsdfTransparent")
    _, output, _ = nodes_of(made)
    tree = made.node_tree
    choose, path, solid = (tree.nodes.new(n) for n in ("ShaderNodeMixShader", "ShaderNodeLightPath", "ShaderNodeBsdfDiffuse"))
    solid.inputs["Color"].default_value = (0.8, 0.1, 0.1, 1)
    tree.links.new(path.outputs["Is Shadow Ray"], choose.inputs[0])
    tree.links.new(solid.outputs[0], choose.inputs[1])
    tree.links.new(next(n for n in tree.nodes if n.type == "BSDF_TRANSPARENT").outputs[0], choose.inputs[2])
    tree.links.new(choose.outputs[0], output.inputs["Surface"])
    bpy.data.objects["Cube"].data.materials.clear()
    bpy.data.objects["Cube"].data.materials.append(made)
    light("SUN", (-3, -4, 6), 2, angle=0.1)


@scene
def hidden_behind_transparent():
    """Hidden from the camera, also through a pane and smoke; shown to the camera alone, too."""
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    bpy.data.objects["Cube"].visible_camera = False
    ring = bpy.data.objects["Torus"]
    ring.visible_diffuse = ring.visible_glossy = ring.visible_transmission = ring.visible_volume_scatter = ring.visible_shadow = False
    shape("plane", (-1, -1.6, 1), material("pane", "ShaderNodeBsdfTransparent", Color=(0.8, 0.9, 0.8)), size=2.4, rotation=(1.3, 0, 0))
    shape("cube", (1.2, 0, 1), filled("smoke", "ShaderNodeVolumePrincipled", Color=(0.8, 0.8, 0.8), Density=0.2), size=2.4)
    bpy.context.scene["means only"] = True


@scene
def transparent_shadows():
    stage()
    light("AREA", (2, -4, 6), 600, size=1)
    shape("plane", (0.6, -1.3, 2.0), material("pane", "ShaderNodeBsdfTransparent", Color=(0.3, 0.8, 0.4)), size=1.6)
    bpy.context.scene["means only"] = True


@scene
def displaced():
    made = material("displaced", Base_Color=(0.6, 0.5, 0.4), Roughness=0.5)
    tree, output, _ = nodes_of(made)
    moved, wave = tree.nodes.new("ShaderNodeDisplacement"), tree.nodes.new("ShaderNodeTexNoise")
    moved.inputs["Scale"].default_value = 0.1
    tree.links.new(wave.outputs["Fac"], moved.inputs["Height"])
    tree.links.new(moved.outputs[0], output.inputs["Displacement"])
    floor()
    shape("uv_sphere", (0, 0, 1), made, True, radius=1, segments=64, ring_count=32)
    lit()


def moved(name, method, node="ShaderNodeDisplacement", texture="ShaderNodeTexNoise", scale=0.3, **inputs):
    """A material whose vertices move by a texture."""
    made = material(name, Base_Color=(0.6, 0.5, 0.4), Roughness=0.6)
    made.displacement_method = method
    tree, output, _ = nodes_of(made)
    mover, wave = tree.nodes.new(node), tree.nodes.new(texture)
    mover.inputs["Scale"].default_value = scale
    for known, value in inputs.items():
        wave.inputs[known].default_value = value
    into = mover.inputs["Height"] if node == "ShaderNodeDisplacement" else mover.inputs["Vector"]
    tree.links.new(wave.outputs["Fac" if into.name == "Height" else "Color"], into)
    tree.links.new(mover.outputs[0], output.inputs["Displacement"])
    return made


@scene
def displaced_truly():
    """Outlines and shadows follow: noise along normals, and vectors of the object's space."""
    floor()
    shape("uv_sphere", (-1.1, 0, 1.2), moved("rocks", "DISPLACEMENT", scale=0.5), True, radius=0.8, segments=128, ring_count=64)
    made = moved("blown", "DISPLACEMENT", "ShaderNodeVectorDisplacement", scale=0.6)
    next(node for node in made.node_tree.nodes if node.type == "VECTOR_DISPLACEMENT").space = "OBJECT"
    shape("uv_sphere", (1.1, 0, 1.2), made, True, radius=0.8, segments=128, ring_count=64)
    lit()


@scene
def displaced_and_bumped():
    """Relief that is finer than the mesh, on a coarse ball, a fine one, and a cube of flat faces."""
    floor()
    for x, segments in ((-1.5, 24), (0.2, 128)):
        made = moved(f"both {segments}", "BOTH", scale=0.3, Scale=6.0)
        shape("uv_sphere", (x, 0, 1.1), made, True, radius=0.8, segments=segments, ring_count=segments // 2)
    cube = shape("cube", (1.7, 0, 0.9), moved("both flat", "BOTH", scale=0.2, Scale=6.0), False, size=1.1)
    finer = cube.modifiers.new("finer", "SUBSURF")
    finer.subdivision_type, finer.levels, finer.render_levels = "SIMPLE", 3, 3
    lit()


@scene
def displaced_vectors_and_bumped():
    floor()
    for x, segments in ((-1.0, 24), (1.0, 128)):
        made = moved(f"both {segments}", "BOTH", "ShaderNodeVectorDisplacement", scale=0.4)
        next(node for node in made.node_tree.nodes if node.type == "VECTOR_DISPLACEMENT").space = "OBJECT"
        shape("uv_sphere", (x, 0, 1.2), made, True, radius=0.8, segments=segments, ring_count=segments // 2)
    lit()


@scene
def bumped_by_vectors():
    floor()
    for x, space in ((-1.1, "OBJECT"), (1.1, "TANGENT")):
        made = moved(f"bumps {space}", "BUMP", "ShaderNodeVectorDisplacement", scale=0.2)
        next(node for node in made.node_tree.nodes if node.type == "VECTOR_DISPLACEMENT").space = space
        shape("uv_sphere", (x, 0, 1.2), made, True, radius=0.9, segments=64, ring_count=32)
    lit()


@scene
def displaced_colors():
    """Colours and bumps by generated coordinates stay where they were before the displacement."""
    floor()
    made = moved("striped", "DISPLACEMENT", scale=0.8)
    tree, output, shader = nodes_of(made)
    stripes, waves, bump = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexWave", "TexNoise", "Bump"))
    waves.inputs["Scale"].default_value, bump.inputs["Distance"].default_value = 8.0, 0.1
    tree.links.new(stripes.outputs["Color"], shader.inputs["Base Color"])
    tree.links.new(waves.outputs["Fac"], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], shader.inputs["Normal"])
    shape("uv_sphere", (0, 0, 1.2), made, True, radius=0.8, segments=128, ring_count=64)
    lit()


@scene
def displaced_lamp():
    """A shining ball that displacement makes larger, and a cube of hard edges that is cut finer."""
    floor()
    made = material("shining", "ShaderNodeEmission", Strength=4.0)
    made.displacement_method = "DISPLACEMENT"
    tree, output, _ = nodes_of(made)
    mover = tree.nodes.new("ShaderNodeDisplacement")
    mover.inputs["Height"].default_value, mover.inputs["Midlevel"].default_value = 1.0, 0.0
    mover.inputs["Scale"].default_value = 0.4
    tree.links.new(mover.outputs[0], output.inputs["Displacement"])
    shape("uv_sphere", (-1.2, 0, 1.4), made, True, radius=0.4, segments=64, ring_count=32)
    cube = shape("cube", (1.2, 0, 1.1), moved("waves", "DISPLACEMENT", texture="ShaderNodeTexWave", scale=0.2, Scale=1.0), True, size=1.4)
    finer = cube.modifiers.new("finer", "SUBSURF")
    finer.subdivision_type, finer.levels, finer.render_levels = "SIMPLE", 6, 6
    lit()


@scene
def displaced_adaptively():
    """A cube of six faces whose modifier asks for short edges."""
    floor()
    cube = shape("cube", (0, 0, 1.2), moved("ripples", "DISPLACEMENT", scale=0.4), True, size=1.6)
    finer = cube.modifiers.new("finer", "SUBSURF")
    finer.levels = finer.render_levels = 3
    finer.use_adaptive_subdivision, finer.adaptive_space, finer.adaptive_object_edge_length = True, "OBJECT", 0.02
    lit()


def bodies(*materials):
    """Cubes on a floor, between a lamp and a camera."""
    floor()
    count = len(materials)
    for i, made in enumerate(materials):
        shape("cube", ((i - (count - 1) / 2) * 2, 0, 0.8), made, size=1.5)
    camera((0, -8, 3), (0, 0, 0.7), 42)
    light("AREA", (2, -3, 5), 500, size=2)
    background(0.4)
    bpy.context.scene["means only"] = True


@scene
def volume_nodes():
    bodies(
        filled("absorbing", "ShaderNodeVolumeAbsorption", Color=(0.2, 0.6, 0.9), Density=0.8),
        filled("scattering", "ShaderNodeVolumeScatter", Color=(0.9, 0.7, 0.3), Density=1.5, Anisotropy=0.5),
        filled("principled", "ShaderNodeVolumePrincipled", Color=(0.3, 0.5, 0.7), Density=2.0, Absorption_Color=(0.5, 0.1, 0.0), Anisotropy=-0.4),
    )


@scene
def volumes_that_shine():
    bodies(
        filled("emission", "ShaderNodeEmission", Color=(1, 0.5, 0.2), Strength=0.4),
        filled("strength", "ShaderNodeVolumePrincipled", Color=0.5, Density=0.5, Emission_Strength=0.5, Emission_Color=(0.2, 0.4, 1)),
        filled("hot", "ShaderNodeVolumePrincipled", Color=0.2, Density=1.0, Blackbody_Intensity=1.0, Temperature=2000.0, Blackbody_Tint=(1, 0.8, 0.9)),
    )
    background(0.05)


@scene
def volumes_mixed():
    def mixed(kind):
        made = filled(kind, "ShaderNodeVolumeScatter", Color=(0.8, 0.8, 0.9), Density=2.0, Anisotropy=0.6)
        tree = made.node_tree
        output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
        one = output.inputs["Volume"].links[0].from_node
        other, both, amount = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new(kind), tree.nodes.new("ShaderNodeValue")
        other.inputs["Color"].default_value, other.inputs["Anisotropy"].default_value = (0.9, 0.3, 0.3, 1), -0.3
        amount.outputs[0].default_value = 0.7
        tree.links.new(amount.outputs[0], other.inputs["Density"])
        first = len(both.inputs) - 2
        if first:
            both.inputs[0].default_value = 0.3
        tree.links.new(one.outputs[0], both.inputs[first])
        tree.links.new(other.outputs[0], both.inputs[first + 1])
        tree.links.new(both.outputs[0], output.inputs["Volume"])
        return made

    bodies(mixed("ShaderNodeMixShader"), mixed("ShaderNodeAddShader"), filled("rayleigh", "ShaderNodeVolumeScatter", phase="RAYLEIGH", Color=0.7, Density=1.0))


@scene
def volumes_in_glass():
    floor()
    whisky = filled(material("whisky", "ShaderNodeBsdfGlass", Color=1.0, IOR=1.4), "ShaderNodeVolumeAbsorption", Color=(0.9, 0.5, 0.1), Density=1.0)
    milk = filled(material("milk", "ShaderNodeBsdfRefraction", Color=1.0, IOR=1.2), "ShaderNodeVolumeScatter", Color=(0.9, 0.9, 0.8), Density=1.2, Anisotropy=0.3)
    for x, made in ((-1.1, whisky), (1.1, milk)):
        shape("uv_sphere", (x, 0, 0.9), made, True, radius=0.9, segments=64, ring_count=32)
    camera((0, -7, 2.6), (0, 0, 0.8), 45)
    light("AREA", (2, -3, 5), 400, size=2)
    background(0.5)


def fog(density, color=0.7, **values):
    tree = bpy.context.scene.world.node_tree
    made = tree.nodes.new("ShaderNodeVolumePrincipled")
    made.inputs["Density"].default_value, made.inputs["Color"].default_value = density, (color, color, color, 1)
    for name, value in values.items():
        made.inputs[name].default_value = value
    tree.links.new(made.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_WORLD").inputs["Volume"])


@scene
def world_fog():
    stage()
    light("POINT", (-2, -2, 3), 300, shadow_soft_size=0.3)
    light("AREA", (2, -3, 4), 300, size=2)
    fog(0.06, Anisotropy=0.3)
    # The cube's medium adds to the fog; glass without one holds the fog, too.
    bpy.data.objects["Cube"].data.materials[0] = filled("body", "ShaderNodeVolumeScatter", Color=(0.9, 0.5, 0.5), Density=1.0)
    bpy.context.scene["means only"] = True


@scene
def camera_in_fog():
    stage()
    light("AREA", (2, -3, 4), 500, size=2)
    shape("cube", (0, 0, 0), filled("room", "ShaderNodeVolumeScatter", Color=(0.8, 0.8, 0.9), Density=0.04), size=24)
    bpy.data.objects["Cube"].data.materials[0] = filled("body", "ShaderNodeVolumeAbsorption", Color=(0.9, 0.2, 0.2), Density=1.0)
    background(0.3)
    bpy.context.scene["means only"] = True


def grid_cloud(values, made, where=(0, 0, 1), **place):
    """A volume object by geometry nodes: named grids of fields, each a node of the field's tree or a number."""
    tree = bpy.data.node_groups.new("grids", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    end, cube, drop, paint = (tree.nodes.new(n) for n in ("NodeGroupOutput", "GeometryNodeVolumeCube", "GeometryNodeGetNamedGrid", "GeometryNodeSetMaterial"))
    for name in "XYZ":
        cube.inputs[f"Resolution {name}"].default_value = 24
    drop.inputs["Name"].default_value, drop.inputs["Remove"].default_value = "density", True
    tree.links.new(cube.outputs[0], drop.inputs["Volume"])
    last = drop.outputs["Volume"]
    for name, field in values.items():
        grid, store = tree.nodes.new("GeometryNodeFieldToGrid"), tree.nodes.new("GeometryNodeStoreNamedGrid")
        grid.grid_items.clear()
        grid.grid_items.new("VECTOR" if isinstance(field, tuple) else "FLOAT", name)
        tree.links.new(drop.outputs["Grid"], grid.inputs["Topology"])
        socket = next(each for each in grid.inputs if each.name == name)
        if callable(field):
            tree.links.new(field(tree), socket)
        else:
            socket.default_value = field
        if isinstance(field, tuple):
            store.data_type = "VECTOR_FLOAT"
        store.inputs["Name"].default_value = name
        tree.links.new(next(each for each in grid.outputs if each.name == name), store.inputs["Grid"])
        tree.links.new(last, store.inputs["Volume"])
        last = store.outputs["Volume"]
    paint.inputs["Material"].default_value = made
    tree.links.new(last, paint.inputs[0])
    tree.links.new(paint.outputs[0], end.inputs[0])
    found = add("grids", bpy.data.meshes.new("grids"), where)
    for name, value in place.items():
        setattr(found, name, value)
    found.modifiers.new("nodes", "NODES").node_group = tree
    return found


def ball_field(scale, noise=0.0):
    """A field that falls from the middle of a cube to its sides."""

    def put(tree):
        where, length, change, top = (tree.nodes.new(n) for n in ("GeometryNodeInputPosition", "ShaderNodeVectorMath", "ShaderNodeTexNoise", "ShaderNodeMath"))
        length.operation = "LENGTH"
        change.inputs["Scale"].default_value = 2.5
        mixed = tree.nodes.new("ShaderNodeMath")
        mixed.operation, top.operation, top.use_clamp = "MULTIPLY_ADD", "MULTIPLY", True
        tree.links.new(where.outputs[0], length.inputs[0])
        tree.links.new(length.outputs["Value"], mixed.inputs[0])
        mixed.inputs[1].default_value, mixed.inputs[2].default_value = -1.0, 1.0
        tree.links.new(mixed.outputs[0], top.inputs[0])
        if noise:
            tree.links.new(change.outputs["Fac" if "Fac" in change.outputs else 0], top.inputs[1])
        else:
            top.inputs[1].default_value = 1.0
        many = tree.nodes.new("ShaderNodeMath")
        many.operation = "MULTIPLY"
        many.inputs[1].default_value = scale
        tree.links.new(top.outputs[0], many.inputs[0])
        return many.outputs[0]

    return put


@scene
def smoke():
    floor()
    made = filled("smoke", "ShaderNodeVolumePrincipled", Color=(0.8, 0.6, 0.5), Density=2.0, Anisotropy=0.2)
    grid_cloud({"density": ball_field(4.0, 1.0)}, made, scale=(1.2, 1.2, 0.9), rotation_euler=(0.3, 0.2, 0.5))
    camera((0, -7, 2.6), (0, 0, 0.8), 45)
    light("AREA", (2, -3, 5), 500, size=2)
    background(0.3)
    bpy.context.scene["means only"] = True


@scene
def fire():
    floor()
    made = filled("fire", "ShaderNodeVolumePrincipled", Color=(0.5, 0.5, 0.5), Density=1.0, Blackbody_Intensity=1.0, Temperature=1500.0)
    grid_cloud({"density": ball_field(3.0), "temperature": ball_field(1.6)}, made)
    camera((0, -7, 2.6), (0, 0, 0.8), 45)
    background(0.05)
    bpy.context.scene["means only"] = True


def volume_object(values, made, where):
    """A volume object whose file has the grids of `grid_cloud`."""
    import tempfile

    found = grid_cloud(values, None)
    path = tempfile.NamedTemporaryFile(suffix=".vdb", delete=False).name
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.object.type == "VOLUME":
            instance.object.data.grids.save(path)
    bpy.data.objects.remove(found)
    data = bpy.data.volumes.new("file")
    data.filepath = path
    data.materials.append(made)
    return add("file", data, where)


@scene
def volume_file():
    """A volume object of a file, whose density a ramp changes."""
    floor()
    made = filled("file", "ShaderNodeVolumeScatter", Color=(0.6, 0.7, 0.9))
    tree = made.node_tree
    info, ramp, more = (tree.nodes.new(n) for n in ("ShaderNodeVolumeInfo", "ShaderNodeValToRGB", "ShaderNodeMath"))
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.2, 0.7
    more.operation, more.inputs[1].default_value = "MULTIPLY", 5.0
    tree.links.new(info.outputs["Density"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], more.inputs[0])
    tree.links.new(more.outputs[0], next(n for n in tree.nodes if n.type == "VOLUME_SCATTER").inputs["Density"])
    found = volume_object({"density": ball_field(1.0)}, made, (0, 0, 1))
    found.data.render.space, found.scale = "WORLD", (1.3, 1.3, 1.3)
    camera((0, -7, 2.6), (0, 0, 0.8), 45)
    light("AREA", (2, -3, 5), 500, size=2)
    background(0.3)
    bpy.context.scene["means only"] = True


@scene
def drifting_smoke():
    """A volume object that its velocities move while the shutter is open, thin, then dense at one side."""
    floor()
    made = filled("drift", "ShaderNodeVolumePrincipled", Color=(0.7, 0.8, 0.9), Density=3.0)
    drifting = volume_object({"density": ball_field(1.0), "velocity": (24.0, 0.0, 8.0)}, made, (-0.4, 0, 1.2))
    drifting.rotation_euler, drifting.data.velocity_unit = (0, 0, 0.3), "SECOND"
    settings = bpy.context.scene.render
    settings.use_motion_blur, settings.motion_blur_shutter = True, 1.0
    camera((0, -7, 2.6), (0, 0, 0.8), 45)
    light("AREA", (2, -3, 5), 500, size=2)
    background(0.3)
    bpy.context.scene["means only"] = True


@scene
def lamps_and_smoke():
    """Every kind of lamp beside a volume that scatters."""
    stage()
    light("POINT", (-2, -2, 3), 200, shadow_soft_size=0)
    light("SPOT", (3, -3, 4), 900, (1, 0, 0), spot_size=0.9, spot_blend=0.15, shadow_soft_size=0.1)
    light("SUN", (3, -4, 6), 1, angle=math.radians(5))
    light("SUN", (-3, -4, 6), 0.5, angle=0)
    light("AREA", (0, -4, 3), 100, size=1, spread=math.radians(70))
    shape("cube", (0, 0, 0.8), filled("smoke", "ShaderNodeVolumeScatter", Color=0.8, Density=0.8, Anisotropy=0.3), size=1.4)
    bpy.context.scene["means only"] = True


@scene
def bending():
    """Vertices that move while the shutter is open: by shape keys, and by a modifier."""
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    settings = bpy.context.scene.render
    settings.use_motion_blur, settings.motion_blur_shutter = True, 1.0
    cube = bpy.data.objects["Cube"]
    cube.shape_key_add(name="Basis")
    key = cube.shape_key_add(name="long")
    for point in key.data:
        point.co.z += 1.5 if point.co.z > 0 else 0.0
    for frame, value in ((0, 0.0), (2, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    ball = bpy.data.objects["Sphere"]
    bend = ball.modifiers.new("wave", "SIMPLE_DEFORM")
    bend.deform_method = "STRETCH"
    for frame, value in ((0, -0.4), (2, 1.0)):
        bend.factor = value
        bend.keyframe_insert("factor", frame=frame)
    bpy.context.scene.frame_set(1)
    bpy.context.scene["means only"] = True


@scene
def holdout_nodes():
    stage()
    light("AREA", (2, -4, 6), 600, size=3)
    bpy.context.scene.render.film_transparent = True
    made = material("hole", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.3, 0.2))
    tree, output, shader = nodes_of(made)
    mix, hole = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeHoldout")
    mix.inputs[0].default_value = 0.7
    tree.links.new(shader.outputs[0], mix.inputs[1])
    tree.links.new(hole.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    bpy.data.objects["Cube"].data.materials[0] = made


@scene
def volume_textures():
    """Textures in the volumes of meshes: by generated coordinates, and by those of a turned object."""
    cloud = filled("cloud", "ShaderNodeVolumeScatter", Color=(0.9, 0.8, 0.7), Anisotropy=0.2)
    ramped = filled("ramped", "ShaderNodeVolumePrincipled", Color=(0.4, 0.5, 0.8))
    glowing = filled("glowing", "ShaderNodeEmission", Color=(1, 0.5, 0.2))
    for made, name, texture, scale in ((cloud, "Density", "ShaderNodeTexNoise", 4), (ramped, "Density", "ShaderNodeTexGradient", 3), (glowing, "Strength", "ShaderNodeTexChecker", 1)):
        tree = made.node_tree
        node = next(n for n in tree.nodes if n.type in {"VOLUME_SCATTER", "PRINCIPLED_VOLUME", "EMISSION"})
        source, more = tree.nodes.new(texture), tree.nodes.new("ShaderNodeMath")
        more.operation, more.inputs[1].default_value = "MULTIPLY", scale
        if texture == "ShaderNodeTexGradient":
            where = tree.nodes.new("ShaderNodeTexCoord")
            tree.links.new(where.outputs["Object"], source.inputs["Vector"])
        tree.links.new(source.outputs["Factor" if "Factor" in source.outputs else "Fac"], more.inputs[0])
        tree.links.new(more.outputs[0], node.inputs[name])
    bodies(cloud, ramped, glowing)
    bpy.data.objects["Cube.001"].rotation_euler = (0.3, 0.4, 0.5)


def collection(name, *objects):
    made = bpy.data.collections.new(name)
    for each in objects:
        made.objects.link(each)
    return made


@scene
def light_links():
    stage()
    light("SUN", (3, -4, 6), 0.5, angle=0.05)
    cube, ball, ring, ground = (bpy.data.objects[name] for name in ("Cube", "Sphere", "Torus", "Plane"))
    only = light("POINT", (-2, -2, 3), 200, shadow_soft_size=0.2, color=(1, 0.5, 0.3))
    only.light_linking.receiver_collection = collection("lit", cube, ground)
    without = light("AREA", (2, -4, 5), 300, size=1, color=(0.4, 0.6, 1))
    without.light_linking.receiver_collection = collection("unlit", ball)
    without.light_linking.receiver_collection.collection_objects[0].light_linking.link_state = "EXCLUDE"
    without.light_linking.blocker_collection = collection("shadows", ring)


def profiled(lamp, kind, vertical, horizontal, candelas):
    """Gives a lamp's light the directions of an IES profile of a type: 1 for C, 2 for B, 3 for A."""
    rows = [" ".join(map(str, row)) for row in (vertical, horizontal, *candelas)]
    head = f"1 1000 1.5 {len(vertical)} {len(horizontal)} {kind} 2 0 0 0"
    tree, emission = emission_of(lamp)
    source, words = tree.nodes.new("ShaderNodeTexIES"), bpy.data.texts.new("profile")
    words.write("\n".join(["IESNA:LM-63-2002", "TILT=NONE", head, "1 1 50", *rows]))
    source.ies, source.inputs["Strength"].default_value = words, 2.0
    tree.links.new(source.outputs[0], emission.inputs["Strength"])


@scene
def profiles():
    """Lights whose strength an IES profile gives by direction."""
    stage()
    vertical, horizontal = range(0, 91, 10), (0, 90, 180, 270, 360)
    candelas = [[(1000 - 10 * v) * (1 + 0.8 * math.sin(math.radians(h))) for v in vertical] for h in horizontal]
    for kind, where, turn in (("POINT", (-2, -2, 3), (0.4, 0.2, 0.5)), ("AREA", (2, -3, 3), (0.5, 0.3, 0))):
        lamp = light(kind, where, 3, **({"shadow_soft_size": 0.1} if kind == "POINT" else {"size": 0.5}))
        lamp.rotation_euler = turn
        profiled(lamp, 1, vertical, horizontal, candelas)


def of_profile(kind, vertical, horizontal):
    """A floor below one light of a profile whose candelas differ by both angles."""
    floor()
    camera()
    lamp = light("POINT", (0, 0, 2), 3, shadow_soft_size=0.1)
    lamp.rotation_euler = (0.4, 0.2, 0.5)
    profiled(lamp, kind, vertical, horizontal, [[300 + 5 * v + 2 * h + 200 * math.sin(0.05 * v * h) for v in vertical] for h in horizontal])


@scene
def profile_of_a_quarter():
    of_profile(1, range(0, 181, 20), (0, 30, 60, 90))


@scene
def profile_of_a_half():
    of_profile(1, range(0, 91, 15), (90, 150, 210, 270))


@scene
def profile_without_an_end():
    of_profile(1, range(10, 81, 10), range(0, 360, 40))


@scene
def profile_of_type_b():
    of_profile(2, range(-90, 91, 30), range(0, 91, 15))


@scene
def profile_of_type_a():
    of_profile(3, range(-90, 91, 20), range(0, 91, 30))


@scene
def profile_of_type_a_whole():
    of_profile(3, range(-90, 91, 30), range(-60, 91, 30))
