# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes that are pictures of their own: all surfaces shine with a value. Texture coordinates, mist, ambient occlusion."""

import numpy as np

from .holdouts import rendered_as
from .nodes.inputs import matrix

UV = "surface blender_uv () { Ci = color(u, v, 1) * emission(); }"
# One ray for each sample; the places of samples are its random numbers.
OCCLUSION = """
surface blender_occlusion ()
{
    vector n = (dot(N, I) > 0.0) ? vector(-N) : vector(N);
    float z = 2.0 * hashnoise(P) - 1.0, a = M_2PI * hashnoise(P, 1.0);
    float r = sqrt(max(1.0 - z * z, 0.0));
    vector d = normalize(n + 0.999 * vector(r * cos(a), r * sin(a), z));
    int hidden = trace(P, d, "maxdist", REACH);
    Ci = (1.0 - hidden) * radiance();
}
"""
CLEAR = """
surface blender_mist ()
{
    vector seen = vector(transform(CAMERA, P));
    float far = clamp((LENGTH - START) / DEPTH, 0.0, 1.0);
    Ci = color(1.0 - pow(far, POWER)) * emission();
}
"""
POWERS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}


def coordinates(export, options):
    """Texture coordinates of what the camera sees."""
    return rendered_as(export, lambda found: UV, options)


def mist(export, options):
    """Share of mist by the distance from the camera; the world is all mist."""
    world = export.scene_data.world
    settings = world.mist_settings if world else None
    start, depth, falloff = (settings.start, settings.depth, settings.falloff) if settings else (5.0, 25.0, "QUADRATIC")
    is_orthographic = export.view.parameters.get("kind", 0) == 1
    text = CLEAR.replace("CAMERA", matrix(np.linalg.inv(export.view.world_from_camera)))
    text = text.replace("LENGTH", "fabs(seen[2])" if is_orthographic else "length(seen)")
    for name, value in (("START", start), ("DEPTH", max(depth, 1e-9)), ("POWER", POWERS[falloff])):
        text = text.replace(name, repr(float(value)))
    return 1.0 - rendered_as(export, lambda found: text, options)[..., :1]


def occlusion(export, options):
    """Share of the sky above a surface that nothing hides within the world's distance."""
    world = export.scene_data.world
    reach = world.light_settings.distance if world else 10.0
    text = OCCLUSION.replace("REACH", repr(float(reach) if reach > 0 else 1e30))
    return rendered_as(export, lambda found: text, options, 4)


# By the names of passes.
SEEN = {"UV": coordinates, "Mist": mist, "Ambient Occlusion": occlusion}
