# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of the judge for single nodes: toon, hair, ambient occlusion, light paths, points and particles."""

from common import background, bpy, camera, emission_of, floor, light, material, nodes_of, np, shape
from scenes import balls, lit, scene, stage, tuft


def fed(made, kind, output, socket="Color", **settings):
    """A node that feeds an input of the shader of a material."""
    tree, _, shader = nodes_of(made)
    node = tree.nodes.new(kind)
    for name, value in settings.items():
        if hasattr(node, name):
            setattr(node, name, value)
        else:
            node.inputs[name].default_value = value
    tree.links.new(node.outputs[output], shader.inputs[socket])
    return node


@scene
def toon():
    sizes = [(0.3, 0.0), (0.5, 0.3), (0.9, 0.1)]
    balls(*(material(f"m{i}", "ShaderNodeBsdfToon", Color=(0.7, 0.3, 0.2), Size=s, Smooth=b) for i, (s, b) in enumerate(sizes)))
    light("SUN", (3, -4, 6), 1.5, angle=0.02)


@scene
def toon_glossy():
    sizes = [(0.2, 0.0), (0.5, 0.2), (0.8, 0.4)]
    balls(*(material(f"m{i}", "ShaderNodeBsdfToon", component="GLOSSY", Color=(0.4, 0.6, 0.8), Size=s, Smooth=b) for i, (s, b) in enumerate(sizes)))


def fibre(name, component, **values):
    return material(name, "ShaderNodeBsdfHair", component=component, **values)


@scene
def hair_reflection():
    tuft((-0.9, 0, 0), fibre("a", "Reflection", Color=(0.7, 0.5, 0.3), RoughnessU=0.2, RoughnessV=0.7), seed=5)
    tuft((0.9, 0, 0), fibre("b", "Reflection", Color=(0.5, 0.5, 0.8), RoughnessU=0.5, RoughnessV=1.0, Offset=0.2), seed=6)
    camera((0, -5, 1.8), (0, 0, 0.6), 50)
    light("SUN", (2, -4, 5), 3, angle=0.1)
    background(0.3)
    bpy.context.scene["means only"] = True


@scene
def hair_transmission():
    tuft((-0.9, 0, 0), fibre("a", "Transmission", Color=(0.8, 0.6, 0.4), RoughnessU=0.2, RoughnessV=0.5), seed=7)
    tuft((0.9, 0, 0), fibre("b", "Transmission", Color=(0.8, 0.5, 0.8), RoughnessU=0.5, RoughnessV=1.0, Offset=-0.2), seed=8)
    camera((0, -5, 1.8), (0, 0, 0.6), 50)
    light("SUN", (-2, 6, 3), 3, angle=0.1)
    background(0.3)
    bpy.context.scene["means only"] = True


@scene
def hair_on_balls():
    """The node on surfaces, with a tangent."""
    made = [fibre(f"m{i}", c, Color=(0.8, 0.6, 0.4), RoughnessU=u, RoughnessV=v) for i, (c, u, v) in enumerate([("Reflection", 0.2, 0.6), ("Reflection", 0.6, 1.0), ("Reflection", 0.4, 0.3)])]
    for each in made:
        fed(each, "ShaderNodeTangent", 0, "Tangent", axis="Z")
    balls(*made)


def crowded(**settings):
    """Things near to each other whose colour is the ambient occlusion."""
    ground = floor()
    paints = [material(f"paint {i}", "ShaderNodeBsdfDiffuse") for i in range(4)]
    for i, paint in enumerate(paints):
        fed(paint, "ShaderNodeAmbientOcclusion", 0, Color=[(0.9, 0.8, 0.7, 1), (0.8, 0.4, 0.3, 1), (0.4, 0.7, 0.9, 1), (0.5, 0.8, 0.4, 1)][i], samples=16, **settings)
    bpy.data.objects["Plane"].data.materials.clear()
    bpy.data.objects["Plane"].data.materials.append(paints[0])
    shape("cube", (-0.7, 0, 0.52), paints[1], size=1)
    shape("uv_sphere", (0.5, 0.1, 0.6), paints[2], True, radius=0.6)
    shape("torus", (0, -0.9, 0.25), paints[3], True, major_radius=0.5, minor_radius=0.2)
    camera((0, -6, 3.5), (0, 0, 0.4), 45)
    light("AREA", (2, -3, 5), 400, size=2)
    background(0.3)
    return ground


@scene
def ambient_occlusion():
    crowded(Distance=0.8)


@scene
def ambient_occlusion_local():
    crowded(Distance=1.0, only_local=True)


@scene
def ambient_occlusion_inside():
    crowded(Distance=0.7, inside=True, only_local=True)


@scene
def ambient_occlusion_shining():
    """It shines by its occlusion. Cycles samples such light as if nothing were near: it only meets it here."""
    floor()
    paint = material("paint", "ShaderNodeEmission", Strength=1.0)
    paint.cycles.emission_sampling = "NONE"
    fed(paint, "ShaderNodeAmbientOcclusion", 0, Distance=1.5)
    shape("cube", (-0.8, 0, 0.5), paint, size=1)
    shape("cube", (0.2, 0.4, 0.8), paint, size=1)
    shape("uv_sphere", (1.2, -0.6, 0.5), material("mirror", "ShaderNodeBsdfGlossy", Color=(0.9, 0.9, 0.9), Roughness=0.1), True, radius=0.5)
    camera((0, -6, 3), (0, 0, 0.4), 45)
    background(0.1)


@scene
def path_depths():
    """Colours by the number of bounces of a room of balls, each by another depth."""
    floor()
    for i, (output, kind, values) in enumerate(
        [
            ("Ray Depth", "ShaderNodeBsdfDiffuse", {}),
            ("Diffuse Depth", "ShaderNodeBsdfDiffuse", {}),
            ("Glossy Depth", "ShaderNodeBsdfGlossy", {"Roughness": 0.2}),
        ]
    ):
        paint = material(f"m{i}", kind, **values)
        tree, _, shader = nodes_of(paint)
        path, less, ramp = (tree.nodes.new(n) for n in ("ShaderNodeLightPath", "ShaderNodeMath", "ShaderNodeCombineColor"))
        less.operation, less.inputs[1].default_value = "DIVIDE", 3.0
        tree.links.new(path.outputs[output], less.inputs[0])
        tree.links.new(less.outputs[0], ramp.inputs[0])
        ramp.inputs[1].default_value, ramp.inputs[2].default_value = 0.4, 0.6
        tree.links.new(ramp.outputs[0], shader.inputs["Color"])
        shape("uv_sphere", ((i - 1) * 1.2, 0, 0.6), paint, True, radius=0.6)
    wall = material("wall", "ShaderNodeBsdfGlossy", Color=(0.9, 0.9, 0.9), Roughness=0.05)
    shape("cube", (0, 1.5, 1.5), wall, size=3).scale = (2, 0.05, 1)
    camera((0, -6, 2.6), (0, 0, 0.7), 45)
    light("AREA", (2, -3, 5), 400, size=2)
    background(0.4)


@scene
def path_lengths():
    """Light by the length of rays, and transparent sheets that count."""
    floor()
    paint = material("far", "ShaderNodeEmission")
    tree, _, shader = nodes_of(paint)
    path, fall = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMath")
    fall.operation, fall.inputs[1].default_value = "DIVIDE", 10.0
    tree.links.new(path.outputs["Ray Length"], fall.inputs[0])
    tree.links.new(fall.outputs[0], shader.inputs["Strength"])
    shape("cube", (-0.9, 0, 0.5), paint, size=1)
    seen = material("seen", "ShaderNodeEmission")
    seen.cycles.emission_sampling = "NONE"
    tree, _, shader = nodes_of(seen)
    path, part = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMath")
    part.operation, part.inputs[1].default_value = "DIVIDE", 4.0
    tree.links.new(path.outputs["Transparent Depth"], part.inputs[0])
    tree.links.new(part.outputs[0], shader.inputs["Strength"])
    shape("cube", (0.9, 0.5, 0.5), seen, size=1)
    sheet = material("sheet", "ShaderNodeBsdfTransparent", Color=(0.9, 0.9, 0.9))
    for i in range(2):
        shape("plane", (0.9, -0.6 - 0.4 * i, 0.6), sheet, size=1).rotation_euler = (1.57, 0, 0)
    shape("uv_sphere", (-0.2, -1.2, 0.4), material("mirror", "ShaderNodeBsdfGlossy", Color=(0.9, 0.9, 0.9), Roughness=0.0), True, radius=0.4)
    camera((0, -6, 2.6), (0, 0, 0.5), 45)
    light("AREA", (2, -3, 5), 200, size=2)
    background(0.2)


@scene
def values_of_particles():
    base = shape("plane", (0, 0, 0), size=4)
    paint = material("by particle", "ShaderNodeBsdfDiffuse")
    tree, _, shader = nodes_of(paint)
    info, mix, age = (tree.nodes.new(n) for n in ("ShaderNodeParticleInfo", "ShaderNodeCombineColor", "ShaderNodeMath"))
    age.operation, age.inputs[1].default_value = "DIVIDE", 60.0
    tree.links.new(info.outputs["Random"], mix.inputs[0])
    tree.links.new(info.outputs["Age"], age.inputs[0])
    tree.links.new(age.outputs[0], mix.inputs[1])
    tree.links.new(info.outputs["Size"], mix.inputs[2])
    tree.links.new(mix.outputs[0], shader.inputs["Color"])
    ball = shape("uv_sphere", (0, 0, -20), paint, True, radius=0.6)
    base.modifiers.new("throw", "PARTICLE_SYSTEM")
    settings = base.particle_systems[0].settings
    settings.count, settings.frame_end, settings.lifetime = 60, 30, 100
    settings.render_type, settings.instance_object = "OBJECT", ball
    settings.particle_size, settings.size_random = 0.5, 0.6
    scene_data = bpy.context.scene
    for frame in range(1, 41):
        scene_data.frame_set(frame)
    camera((0, -9, 5), (0, 0, 0.5), 45)
    light("AREA", (2, -3, 8), 800, size=2)
    background(0.3)
    scene_data["means only"] = True


@scene
def values_of_points():
    floor()
    base = shape("grid", (0, 0, 0.5), x_subdivisions=7, y_subdivisions=7, size=3)
    tree = bpy.data.node_groups.new("cloud", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    begin, end, points, paint = (tree.nodes.new(n) for n in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeMeshToPoints", "GeometryNodeSetMaterial"))
    made = material("balls", "ShaderNodeBsdfDiffuse")
    inner, _, shader = nodes_of(made)
    info, mix, parts = (inner.nodes.new(n) for n in ("ShaderNodePointInfo", "ShaderNodeCombineColor", "ShaderNodeSeparateXYZ"))
    inner.links.new(info.outputs["Position"], parts.inputs[0])
    inner.links.new(parts.outputs[0], mix.inputs[0])
    inner.links.new(info.outputs["Random"], mix.inputs[1])
    inner.links.new(info.outputs["Radius"], mix.inputs[2])
    inner.links.new(mix.outputs[0], shader.inputs["Color"])
    points.inputs["Radius"].default_value = 0.2
    paint.inputs["Material"].default_value = made
    tree.links.new(begin.outputs[0], points.inputs["Mesh"])
    tree.links.new(points.outputs[0], paint.inputs[0])
    tree.links.new(paint.outputs[0], end.inputs[0])
    base.modifiers.new("nodes", "NODES").node_group = tree
    base.location.x = 0.6
    lit()


@scene
def falloffs_of_areas():
    """Areas whose light falls less, or not at all, with the distance."""
    stage()
    for where, name, strength, settings in (
        ((-2.5, -2, 3), "Linear", 40.0, {"size": 1.0}),
        ((2.5, -2, 2), "Quadratic", 150.0, {"size": 0.5, "color": (1, 0.7, 0.4)}),
        ((0, -3, 4), "Constant", 12.0, {"shape": "DISK", "size": 0.8}),
    ):
        tree, emission = emission_of(light("AREA", where, 1.0, **settings))
        node = tree.nodes.new("ShaderNodeLightFalloff")
        node.inputs["Strength"].default_value = strength
        node.inputs["Smooth"].default_value = 0.0 if name == "Linear" else 2.0
        tree.links.new(node.outputs[name], emission.inputs["Strength"])


@scene
def bevels():
    """Sharp cubes and rings of few faces with rounded edges, alone and with bumps."""
    floor()
    paints = [material(f"paint {i}", "ShaderNodeBsdfGlossy", Color=(0.8, 0.7, 0.5), Roughness=0.3) for i in range(3)]
    for i, paint in enumerate(paints):
        fed(paint, "ShaderNodeBevel", 0, "Normal", samples=8, Radius=[0.08, 0.25, 0.15][i])
    shape("cube", (-1.4, 0, 0.52), paints[0], size=1).rotation_euler.z = 0.6
    shape("cube", (0, 0, 0.52), paints[1], size=1).rotation_euler.z = 0.4
    shape("cylinder", (1.4, 0, 0.52), paints[2], vertices=6, radius=0.6, depth=1)
    camera((0, -6, 3.5), (0, 0, 0.4), 45)
    light("AREA", (2, -3, 5), 400, size=2)
    background(0.4)
