# SPDX-License-Identifier: GPL-3.0-or-later
"""Times path tracing by Blender's Cycles and by gnurt on the same diffuse interiors, and says how they compare at equal error.

    python3 cycles_path.py SCENES REFERENCES GNURT [--spp 64] [--threads 2] [--no-light-tree] [--means FOLDER] [SCENE ...]

SCENES is the folder of unpacked scenes, REFERENCES that of the reference pictures, GNURT the program. Needs `pip install bpy`
(5.0 wants Python 3.11). With `--means` nothing is timed: Cycles alone renders, its means are compared with the references',
which shows that both have the same scene, and FOLDER gets its pictures.
Cycles runs on the processors as it comes (light tree, multiple importance sampling, Sobol' numbers, Russian roulette), but
without what makes pictures wrong or other than asked for: no clamping, no threshold for lights, no denoising, no adaptive
number of samples, box filter, paths of 9 edges. Where lamps are few it is faster without its light tree: measure both. Of both
programs the time of a run with one sample is taken off: reading, building trees and Blender's own preparations do not count.

"""
import functools
import os
import time

import bpy
import numpy as np
from mathutils import Matrix, Vector

import equal_error
import interiors


def load_scene(parts, camera, light_tree, max_depth=9, scatter=None):
    """Makes Blender's scene of the parts: one mesh of flat triangles, a material for each part; `scatter` as in `make_material`."""
    eye, target, up, fov, width, height = camera
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = None

    corners = np.concatenate([part_layers(part.corners).reshape(-1, 3) for part in parts])
    count = len(corners) // 3
    mesh = bpy.data.meshes.new("interior")
    mesh.vertices.add(3 * count)
    mesh.vertices.foreach_set("co", corners.ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", np.arange(3 * count, dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    if any(part.texcoords is not None for part in parts):
        texcoords = [np.zeros((len(part.corners), 3, 2)) if part.texcoords is None else part.texcoords for part in parts]
        layer = mesh.uv_layers.new(name="texcoords")
        layer.data.foreach_set("uv", np.concatenate(texcoords).astype(np.float32).ravel())
    for part in parts:
        mesh.materials.append(make_material(part, scatter or matte))
    owners = np.repeat(np.arange(len(parts), dtype=np.int32), [len(part.corners) for part in parts])
    mesh.polygons.foreach_set("material_index", owners)
    mesh.update(calc_edges=True)
    mesh.shade_flat()
    scene.collection.objects.link(bpy.data.objects.new("interior", mesh))

    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.angle = "VERTICAL", np.radians(fov)
    lens.clip_start, lens.clip_end = 1e-4, 1e6
    eye = Vector(eye)
    backward = (eye - Vector(target)).normalized()
    right = Vector(up).cross(backward).normalized()
    rotation = Matrix((right, backward.cross(right), backward)).transposed().to_4x4()
    scene.camera = bpy.data.objects.new("camera", lens)
    scene.camera.matrix_world = Matrix.Translation(eye) @ rotation
    scene.collection.objects.link(scene.camera)

    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.use_compositing = render.use_sequencer = render.use_persistent_data = False
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_auto_tile = False
    cycles.light_sampling_threshold = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.use_light_tree = light_tree
    cycles.pixel_filter_type = "BOX"
    # Cycles counts bounces before the last vertex that is lit: none of them is direct light, which is 2 edges.
    cycles.max_bounces = cycles.diffuse_bounces = max_depth - 2
    cycles.glossy_bounces = cycles.transmission_bounces = cycles.transparent_max_bounces = max_depth - 2
    return scene


def part_layers(corners, gap=1e-4):
    """Takes triangles of a material apart that lie on one another: the smaller one sinks by `gap`, against its normal.

    Cycles leaves a surface by the number of its triangle, not by an offset, so that the other one shadows it: black. The
    table of `office` has such a piece.
    """
    corners = corners.astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(areas, 1e-300)[:, None]
    # Planes, alike for both sides.
    main = np.abs(normals).argmax(axis=1)
    sign = np.sign(np.take_along_axis(normals, main[:, None], 1))
    distances = (sign * normals * corners.mean(axis=1)).sum(axis=1)
    keys = np.round(np.column_stack([sign * normals * 1e3, distances * 1e4])).astype(np.int64)
    order = np.lexsort((-areas, *keys.T))
    order = order[areas[order] > 0]
    ends = np.flatnonzero((np.diff(keys[order], axis=0) != 0).any(axis=1)) + 1
    layers = np.zeros(len(corners), int)
    for group in np.split(order, ends):
        if len(group) > 1:
            flat = np.delete(corners[group], main[group[0]], axis=2)
            low, high = flat.min(axis=1), flat.max(axis=1)
            for i in range(1, len(group)):
                near = np.flatnonzero(((low[:i] < high[i]) & (high[:i] > low[i])).all(axis=1))
                layers[group[i]] = overlap(flat[i], flat[near]).sum() if len(near) else 0
    return (corners - (gap * layers)[:, None, None] * normals[:, None, :]).astype(np.float32)


def overlap(triangle, others, least=1e-4):
    """Which of the others (n, 3, 2) has an area in common with the triangle (3, 2)? An edge's line parts those that have
    none; what is thinner than `least` is none."""
    own = np.broadcast_to(triangle, others.shape)
    result = np.ones(len(others), bool)
    for corners in (own, others):
        edges = np.roll(corners, -1, axis=1) - corners
        axes = np.stack([-edges[..., 1], edges[..., 0]], axis=2)
        axes /= np.maximum(np.linalg.norm(axes, axis=2), 1e-12)[..., None]
        # Distances (n, edge, corner).
        a, b = axes @ own.transpose(0, 2, 1), axes @ others.transpose(0, 2, 1)
        common = np.minimum(a.max(axis=2), b.max(axis=2)) - np.maximum(a.min(axis=2), b.min(axis=2))
        result &= (common >= least).all(axis=1)
    return result


def matte(part, nodes, links):
    """A node that scatters as `--force-diffuse` does; none where nothing is reflected."""
    if not any(part.reflectance):
        return None
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Roughness"].default_value = 0
    colour(part, diffuse.inputs["Color"], nodes, links)
    return diffuse


def colour(part, socket, nodes, links):
    """Kd times map_Kd."""
    socket.default_value = (*part.reflectance, 1)
    if part.texture:
        texture = nodes.new("ShaderNodeTexImage")
        texture.image = make_texture(part)
        texture.interpolation, texture.extension = "Linear", "REPEAT"
        links.new(texture.outputs["Color"], socket)


def make_material(part, scatter):
    """`scatter(part, nodes, links)` makes the node that says how it scatters, or gives None."""
    material = bpy.data.materials.new(part.name)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]
    made = scatter(part, nodes, links)
    if made:
        links.new(made.outputs[0], output)
    if any(part.emission):
        # Light leaves the front alone: times one less Backfacing.
        emission, geometry, front = (nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "NewGeometry", "Math"))
        front.operation = "SUBTRACT"
        front.inputs[0].default_value = 1
        links.new(geometry.outputs["Backfacing"], front.inputs[1])
        links.new(front.outputs[0], emission.inputs["Strength"])
        emission.inputs["Color"].default_value = (*part.emission, 1)
        material.cycles.emission_sampling = "FRONT"
        if made:
            both = nodes.new("ShaderNodeAddShader")
            links.new(made.outputs[0], both.inputs[0])
            links.new(emission.outputs[0], both.inputs[1])
            links.new(both.outputs[0], output)
        else:
            links.new(emission.outputs[0], output)
    return material


def make_texture(part):
    """Kd times the texture, decoded before it is interpolated, as floats."""
    file = bpy.data.images.load(part.texture)
    texels = read_pixels(file)
    linear = np.where(texels <= 0.04045, texels / 12.92, ((texels + 0.055) / 1.055) ** 2.4)
    linear[..., :3] *= part.reflectance
    linear[..., 3] = 1
    width, height = file.size
    image = bpy.data.images.new(part.name, width, height, float_buffer=True, is_data=True)
    image.pixels.foreach_set(linear.astype(np.float32).ravel())
    image.pack()
    return image


def read_pixels(image):
    """The values as they stand in the file, (rows, columns, 4), the lowest row first."""
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "NONE"
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4).astype(np.float64)


def read_exr(path):
    if not os.path.exists(path):
        raise FileNotFoundError(f"{path}: no such picture")
    image = bpy.data.images.load(os.path.abspath(path))
    picture = read_pixels(image)[::-1, :, :3]
    bpy.data.images.remove(image)
    return picture


def render(scene, spp, threads, output):
    """CPU seconds, preparations and all; the picture goes into the file."""
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.cycles.samples = spp
    scene.render.filepath = output
    start = time.process_time()
    bpy.ops.render.render(write_still=True)
    return time.process_time() - start


def run_cycles(parts, camera, spp, threads, folder, light_tree):
    output = os.path.join(folder, "cycles.exr")
    scene = load_scene(parts, camera, light_tree)
    render(scene, 1, threads, output)  # so that nothing is loaded for the first time when it is timed
    seconds = equal_error.without_setup(lambda spp: render(scene, spp, threads, output), spp)
    return read_exr(output), seconds


def check_means(arguments):
    os.makedirs(arguments.means, exist_ok=True)
    print("| scene | spp | mean error R G B, % | relMSE | trimmed |")
    print("|---|---|---|---|---|")
    for name in arguments.only or interiors.CAMERAS:
        output = os.path.abspath(os.path.join(arguments.means, f"{name}.exr"))
        scene = load_scene(interiors.read(arguments.scenes, name), interiors.CAMERAS[name], arguments.light_tree)
        render(scene, arguments.spp, arguments.threads, output)
        reference, variance = (read_exr(os.path.join(arguments.references, f"{name}-{kind}.exr")) for kind in ("path9", "path9-var"))
        picture = read_exr(output)
        off = (picture.mean(axis=(0, 1)) / reference.mean(axis=(0, 1)) - 1) * 100
        errors = interiors.rel_mse(picture, reference, variance)
        print(f"| {name} | {arguments.spp} | {' '.join(f'{o:+.2f}' for o in off)} | {errors[0]:.5f} | {errors[1]:.5f} |", flush=True)


def main():
    parser = equal_error.parser()
    parser.add_argument("--means")
    parser.add_argument("--no-light-tree", dest="light_tree", action="store_false")
    arguments = parser.parse_intermixed_args()
    if arguments.means:
        check_means(arguments)
    else:
        name = f"Cycles {bpy.app.version_string}" + ("" if arguments.light_tree else " without light tree")
        run = functools.partial(run_cycles, light_tree=arguments.light_tree)
        equal_error.compare(arguments, name, read_exr, run)


if __name__ == "__main__":
    main()
