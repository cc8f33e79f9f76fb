# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers: objects that show the background behind them, with the shadows and reflections of others on it.

Four renderings of one view make them: the other objects, with holes where catchers are; the catchers below the light that the other
objects leave; the catchers alone; and the background. The second over the third, 1 where no catcher is, is the factor of the background.
"""

import numpy as np

from . import kept

SHAPES = {"MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES", "POINTCLOUD", "VOLUME"}
# The light of catchers, as a share of the brightest, below which there is nothing to divide by.
DARK = 1e-4


def are_there(depsgraph):
    """Whether a scene has shadow catchers."""
    return any(catches(found) for found in depsgraph.objects)


def catches(found):
    """Whether an object is a shadow catcher; lights carry the mark for something else."""
    return found.type in SHAPES and found.is_shadow_catcher


def rays_of(found, rays, part):
    """The kinds of rays that meet an object in a part of the picture: "caught", "alone" or "behind"; all of them in others."""
    if part not in {"caught", "alone", "behind"} or (catches(found) and part != "behind"):
        return rays
    return [kind for kind in rays if kind != "camera"] if part == "caught" else []


def hold_out(export, is_held):
    """Cuts holes into the picture of the others where catchers are, or closes them."""
    names = {export.names.get(number, found.name) for number, (found, *_) in export.objects.items() if catches(found)}
    for name in sorted(names):
        if "," in name or "=" in name:
            export.warn(f"object '{name}': shadow catchers of names with commas are not shown")
        else:
            export.scene.set(f"instances.{name}.holdout={'true' if is_held else 'false'}")


class Caught:
    """The factor of the background in each pixel, (height, width, 3)."""

    def __init__(self, export, options, ways):
        scene = kept.Changing(export.scene)
        lit, alone = (self._picture(export, scene, part, options, ways, options["max_depth"])[0] for part in ("caught", "alone"))
        self.background = self._picture(export, scene, "behind", options, ways, 1)[1]
        # As it was.
        self._part(export, scene, "others", ways)
        light, coverage = alone[..., :3], alone[..., 3:]
        least = DARK * max(float(light.max()), 1e-9)
        share = np.where(light > least, lit[..., :3] / np.maximum(light, least), 1.0)
        self.factor = (1.0 + coverage * (share - 1.0)).astype(np.float32)

    @staticmethod
    def _part(export, scene, part, ways):
        """The export of a part of the picture, by changes of the scene where that is possible."""
        from .scene import Export

        def made(recorder):
            shapes = ways and ways.shapes
            other = Export(export.depsgraph, export.size, view=export.view, warned=export.warn, part=part, shapes=shapes, recorder=recorder)
            other.put_all()
            return other

        return scene.changed(made)

    def _picture(self, export, scene, part, options, ways, depth):
        """Light and opacity of what is there, and the light behind it."""
        from .passes import combined

        other = self._part(export, scene, part, ways)
        names = ("width", "height", "spp", "seed", "threads", "filter", "integrator", "camera", "camera_shader", "camera_parameters", "crop")
        same = {name: options[name] for name in names if name in options}
        # Instances may have other numbers in each part.
        same |= ways.options(other) if ways else {}
        picture = other.scene.render(layers=True, max_depth=depth, **same)
        return combined(picture, True), picture["background"][..., :3]

    def put(self, color, is_transparent):
        """A picture of the other objects, over what the catchers show: without the background its shadows are opacity."""
        color = color.copy()
        left = 1.0 - np.clip(color[..., 3:], 0.0, 1.0)
        if is_transparent:
            color[..., 3:] += left * np.clip(1.0 - self.factor.mean(axis=2, keepdims=True), 0.0, 1.0)
            return color
        color[..., :3] += left * self.background * self.factor
        color[..., 3] = 1.0
        return color
