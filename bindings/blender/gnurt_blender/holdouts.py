# SPDX-License-Identifier: GPL-3.0-or-later
"""Holdouts: objects that cut a hole into the picture.

A second rendering of the same view, in which they shine and all else is black, is their share of each pixel.
"""

import numpy as np

MASK = "surface blender_holdout () { Ci = emission(); }"
BLACK = "surface blender_nothing () { Ci = 0; }"


def of(export, depsgraph):
    """The scene of the mask, or None if there are no holdouts."""
    from .scene import Export

    held = {found.name for found, *_ in export.objects.values() if found.is_holdout}
    held |= set(collections(depsgraph.view_layer.layer_collection))
    if not held:
        return None
    other = Export(depsgraph, export.size, view=export.view, warned=export.warn, override=lambda found: MASK if found.name in held else BLACK)
    other.put_all()
    return other


def collections(layer, inside=False):
    """Names of the objects of collections that are holdouts in a view layer."""
    inside = inside or layer.holdout
    if inside:
        yield from (found.name for found in layer.collection.objects)
    for child in layer.children:
        yield from collections(child, inside)


def rendered_as(export, shader_of, options):
    """What the camera sees where objects have these shaders, (height, width, 3)."""
    from .scene import Export

    other = Export(export.depsgraph, export.size, view=export.view, warned=export.warn, override=shader_of)
    other.put_all()
    return light_of(other, options)[..., :3]


def rendered(masks, options):
    """The share of holdouts, (height, width)."""
    return light_of(masks, options)[..., 0]


def light_of(other, options):
    kept = {name: options[name] for name in ("width", "height", "spp", "seed", "threads", "filter", "camera", "camera_shader", "camera_parameters", "motion", "crop") if name in options}
    return np.asarray(other.scene.render(integrator="path", max_depth=1, **kept))


def cut(color, share):
    """The picture without the holdouts."""
    kept = 1.0 - np.clip(share, 0.0, 1.0)[..., None]
    # What holdouts show of themselves is in the colour, too: it leaves with their share.
    color = color.copy()
    color *= kept
    return color
