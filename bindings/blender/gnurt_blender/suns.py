# SPDX-License-Identifier: GPL-3.0-or-later
"""The sun of a Sky Texture as a light: a disc far away that rays meet and that is sampled as other shapes that shine.

Its radiance goes linearly from its lower to its upper end, and falls from its middle to its edge. Space: world.
"""

import math

import numpy as np

from .lamps import FAR, flat_shape
from .skies import LIMB

SHADER = """
surface blender_sun (point middle = point(0), vector sun = vector(0, 0, 1), float half_size = 1, color low = 1, color high = 1, float limb = 0)
{
    // The direction from the middle, whatever place the disc is seen from.
    vector d = normalize(P - middle);
    float far = acos(clamp(dot(d, sun), -1.0, 1.0)) / half_size;
    float up = asin(clamp(d[2], -1.0, 1.0)) - asin(clamp(sun[2], -1.0, 1.0));
    color shine = mix(low, high, clamp(0.5 * up / half_size + 0.5, 0.0, 1.0)) * (1.0 - limb + limb * sqrt(max(1.0 - far * far, 0.0)));
    // In front of the sky, so that rays of the camera which pass it do not meet the disc of other rays, too.
    if (d[2] > 0.0 && !backfacing())
        Ci = shine * emission();
    else
        Ci = transparent();
}
"""
# A disc of the sun that is larger is no longer flat enough.
WIDEST = math.radians(80)


def put(export, sky, strength):
    """Adds the sun of a sky, if it is above the horizon."""
    ends = sky.disc()
    if ends is None or strength <= 0:
        return
    shown = {"half_size": min(sky.half, WIDEST / 2), "limb": LIMB, "sun": tuple(map(float, sky.sun))}
    shown |= {name: tuple(float(x) for x in end * strength) for name, end in zip(("low", "high"), ends)}
    add(export, shown, (0.0, 0.0, 0.0), FAR, "other")
    # Cameras do not see beyond their range: they get a disc just before its end.
    if not export.scene_data.render.film_transparent and not export.view.parameters.get("kind", 0) == 1:
        place = tuple(float(x) for x in np.array(export.view.world_from_camera)[:3, 3])
        add(export, shown, place, min(0.99 * export.view.parameters.get("far", FAR), FAR), "camera")


def add(export, shown, middle, distance, rays):
    """Adds a disc at a distance from a place, for a kind of rays."""
    points, faces, _ = flat_shape("DISK", 2 * distance * math.tan(shown["half_size"]), 0)
    towards = np.array(shown["sun"])
    side = np.cross(towards, (0, 0, 1) if abs(towards[2]) < 0.9 else (0, 1, 0))
    side /= np.linalg.norm(side)
    # The front of the disc looks along -z of its own axes.
    points = points @ np.array([side, np.cross(towards, side), towards]) + distance * towards + middle
    material = export.scene.add_material("sun", shader=SHADER, parameters={**shown, "middle": middle})
    export.scene.add_mesh(points, faces, material=material, rays=[rays], name="sun")
