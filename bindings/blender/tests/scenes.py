# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of the judge: each a function that fills the empty scene of `common.start`."""

import math
import random

import bpy
import numpy as np

from common import add, background, camera, floor, light, material, nodes_of, shape

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
    balls(*(material(f"m{i}", Base_Color=(0.9, 0.95, 1), Transmission_Weight=1, Roughness=r, IOR=1.45) for i, r in enumerate([0, 0.2, 0.6])))


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
