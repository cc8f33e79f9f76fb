# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Cycles as a rival of own_materials.py, set up as cycles_path.py says, with its light tree. Needs `pip install bpy`. """
import functools
import math
import os

import bpy

import cycles_path
import interiors


def scatter(models, part, nodes, links):
    """The node that says how a part scatters; Cycles' roughness is the root of alpha."""
    model = models[part.name]
    rough = math.sqrt(model.alpha)
    if model.kind == "glass":
        made = nodes.new("ShaderNodeBsdfGlass")
        made.inputs["Color"].default_value = (*model.colour, 1)
        made.inputs["IOR"].default_value = model.ior
    elif model.kind == "metal":
        made = nodes.new("ShaderNodeBsdfAnisotropic")
        made.inputs["Color"].default_value = (*model.colour, 1)
    elif model.kind == "plastic":
        made = nodes.new("ShaderNodeBsdfPrincipled")
        cycles_path.colour(part, made.inputs["Base Color"], nodes, links)
        made.inputs["IOR"].default_value = model.ior
    else:
        made = cycles_path.matte(part, nodes, links)
    if model.kind != "matte":
        made.distribution = "GGX"
        made.inputs["Roughness"].default_value = rough
    if made and model.opacity < 1:
        hole, both = nodes.new("ShaderNodeBsdfTransparent"), nodes.new("ShaderNodeMixShader")
        both.inputs[0].default_value = model.opacity
        links.new(hole.outputs[0], both.inputs[1])
        links.new(made.outputs[0], both.inputs[2])
        made = both
    return made


class Cycles:
    name = f"Cycles {bpy.app.version_string}"

    def __init__(self, arguments, scene, models, camera, depth, folder):
        parts = interiors.read(arguments.scenes, scene)
        self.output = os.path.join(folder, "cycles.exr")
        self.scene = cycles_path.load_scene(parts, camera, True, depth, functools.partial(scatter, models))
        self.run(1, 99)  # so that nothing is loaded for the first time when it is timed
        self.once = min(self.run(1, seed) for seed in (0, 1))

    def run(self, spp, seed):
        self.scene.cycles.seed = seed
        return cycles_path.render(self.scene, spp, 1, self.output)

    def render(self, spp, seed):
        # What one sample costs holds all that is done once.
        seconds = (self.run(spp + 1, seed) - self.once) * (spp + 1) / spp
        return cycles_path.read_exr(self.output), seconds, spp + 1
