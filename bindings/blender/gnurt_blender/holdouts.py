# SPDX-License-Identifier: GPL-3.0-or-later
"""Holdouts: objects that cut a hole into the picture.

A second rendering of the same view, in which they shine and all else is black, is their share of each pixel. Holdout nodes, which are
black, take a share of the opacity alone.
"""

import numpy as np

MASK = "surface blender_holdout () { Ci = emission(); }"
BLACK = "surface blender_nothing () { Ci = 0; }"


class Shares:
    """Shares of the pixels that holdouts have: of objects, and of Holdout nodes; None where there are none."""

    def __init__(self, export, depsgraph, options):
        objects = of_objects(export, depsgraph)
        nodes = of_nodes(export) if export.holds else None
        self.objects, self.nodes = (mask and light_of(mask, options)[..., 0] for mask in (objects, nodes))


def are_there(export, depsgraph):
    """Whether a scene has holdouts."""
    return export.holds or bool(held_by(export, depsgraph))


def held_by(export, depsgraph):
    """Names of the objects that are holdouts."""
    held = {found.name for found, *_ in export.objects.values() if found.is_holdout}
    return held | set(collections(depsgraph.view_layer.layer_collection))


def of_nodes(export):
    """The scene of the mask of Holdout nodes."""
    from .scene import Export

    other = Export(export.depsgraph, export.size, view=export.view, warned=export.warn, masks=True)
    other.put_all()
    return other


def of_objects(export, depsgraph):
    """The scene of the mask of objects, or None if there are no such holdouts."""
    from .scene import Export

    held = held_by(export, depsgraph)
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


def rendered_as(export, shader_of, options, max_depth=1):
    """What the camera sees where objects have these shaders, (height, width, 3)."""
    from .scene import Export

    other = Export(export.depsgraph, export.size, view=export.view, warned=export.warn, override=shader_of)
    other.put_all()
    return light_of(other, options, max_depth)[..., :3]


def light_of(other, options, max_depth=1):
    kept = {name: options[name] for name in ("width", "height", "spp", "seed", "threads", "filter", "camera", "camera_shader", "camera_parameters", "motion", "crop") if name in options}
    return np.asarray(other.scene.render(integrator="path", max_depth=max_depth, **kept))


def cut(color, shares):
    """The picture without the holdouts."""
    color = color.copy()
    if shares.objects is not None:
        # What holdouts show of themselves is in the colour, too: it leaves with their share.
        color *= 1.0 - np.clip(shares.objects, 0.0, 1.0)[..., None]
    if shares.nodes is not None:
        color[..., 3] *= 1.0 - np.clip(shares.nodes, 0.0, 1.0)
    return color
