# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a scene, at `scene.gnurt`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

INTEGRATORS = (
    ("path", "Path tracing", "The reference: light along paths from the camera"),
    ("auto", "Automatic", "Paths or virtual lights, whichever a pilot rendering finds to have less noise for its time"),
    ("ir", "Instant radiosity", "Virtual lights at the ends of light paths"),
    ("bir", "Bidirectional instant radiosity", "Virtual lights chosen from both ends of paths"),
    ("mir", "Metropolis instant radiosity", "Virtual lights found by Markov chains"),
    ("whitted", "Whitted", "Direct light, mirrors and glass only"),
    ("eyelight", "Eyelight", "Surfaces by their angle to the camera"),
    ("normals", "Normals", "Normals as colours"),
)

GUIDES = (
    ("auto", "Automatic", "Learn where light comes from, and use it where that pays"),
    ("on", "On", "Use it in any case"),
    ("off", "Off", "Do not learn"),
)
PIXEL_NOISE = (
    ("white", "White", "Errors of pixels are independent; the denoiser works best with it"),
    ("blue", "Blue", "Errors of neighbouring pixels cancel out; for few samples without denoising"),
)


class GnurtSettings(bpy.types.PropertyGroup):
    samples: IntProperty(name="Samples", description="Samples per pixel", default=64, min=1, soft_max=4096, max=1 << 24)
    preview_samples: IntProperty(
        name="Viewport samples", description="Samples per pixel in the viewport", default=32, min=1, max=1 << 24
    )
    integrator: EnumProperty(name="Integrator", description="How light is found", items=INTEGRATORS, default="path")
    denoise: BoolProperty(name="Denoise", description="Remove the noise of the finished picture", default=False)
    pixel_noise: EnumProperty(name="Pattern", description="Noise between pixels", items=PIXEL_NOISE, default="white")
    guide: EnumProperty(name="Path guiding", description="Aim paths at light, with path tracing", items=GUIDES, default="auto")
    max_depth: IntProperty(
        name="Segments",
        description="Longest path in segments: 1 is emitted light, 2 direct light",
        default=13,
        min=1,
        soft_max=64,
        max=1024,
    )
    clamp: FloatProperty(
        name="Clamp", description="Limit of each indirect contribution; 0 is no limit", default=0.0, min=0.0
    )
    noise: FloatProperty(
        name="Noise", description="Stop sampling tiles whose noise is below this; 0 samples all alike", default=0.0, min=0.0, max=1.0
    )
    seed: IntProperty(name="Seed", description="Start of the random numbers", default=0, min=0)
    threads: IntProperty(name="Threads", description="Number of threads; 0 is one per core", default=0, min=0, max=1024)
    warnings: StringProperty(
        name="Warnings", description="Parts of the scene that the last rendering could not show, one a line", default=""
    )


def register():
    bpy.utils.register_class(GnurtSettings)
    bpy.types.Scene.gnurt = PointerProperty(type=GnurtSettings)


def unregister():
    del bpy.types.Scene.gnurt
    bpy.utils.unregister_class(GnurtSettings)
