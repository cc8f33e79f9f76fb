# SPDX-License-Identifier: GPL-3.0-or-later
"""Skies of the Sky Texture node as pictures of all directions in linear Rec. 709, and the radiance of the sun's disc.

`of_node` returns a `Sky`. Space: z is up, and the sun's azimuth turns from +y to +x, as in Blender. Units: W/(m2 sr), which Blender takes as colours.
Two models compute it: `single` (light scattered once) and `multiple` (light scattered often).
"""

import functools
import math

import numpy as np

from . import multiple, single

WIDTH, HEIGHT = 1024, 512
MODELS = {"SINGLE_SCATTERING": single, "MULTIPLE_SCATTERING": multiple}
# The sun is darker at its edge: the radiance at a cosine c to its surface is 1 - LIMB + LIMB c of that in the middle.
LIMB = 0.6
# The least angle across the disc.
SMALLEST = math.radians(0.05)


class Sky:
    """A sky: `picture()` is its radiance, `disc` that of the sun at the lower and the upper end of its disc."""

    def __init__(self, model, elevation, rotation, size, intensity, altitude, air, aerosol, ozone, has_disc):
        self.model, self.elevation, self.rotation = model, elevation, rotation
        self.medium = (min(max(altitude, 1.0), model.TOP - 1.0), air, aerosol, ozone)
        # A disc without a size shines, too.
        self.half = min(max(size, SMALLEST), math.pi) / 2
        self.intensity = intensity if has_disc else 0.0

    def key(self):
        """What tells skies apart."""
        return ("sky", self.model.__name__, self.elevation, self.rotation, self.half, self.intensity, *self.medium)

    @property
    def sun(self):
        """The direction to the middle of the sun."""
        flat = math.cos(self.elevation)
        return math.sin(self.rotation) * flat, math.cos(self.rotation) * flat, math.sin(self.elevation)

    def picture(self):
        """The radiance without the disc: (HEIGHT, WIDTH, 3), the zenith first, -y in the first and +y in the middle column of Blender's projection."""
        return picture(self.model, self.elevation, self.rotation, self.medium)

    def disc(self):
        """The radiance of the middle of the disc as it is at its lowest and its highest elevation; None without a disc above the horizon."""
        high = math.asin(max(min(math.sin(self.elevation), 1.0), -1.0))
        if self.intensity <= 0 or high + self.half <= 0:
            return None
        solid_angle = 2 * math.pi * (1 - math.cos(self.half))
        ends = np.array([high - self.half, min(high + self.half, math.pi / 2)])
        return self.model.sunlight(ends, *self.medium) * (self.intensity / solid_angle)

    def picture_with_disc(self):
        """The picture with the disc in it, spread over the pixels that it covers."""
        made, ends = self.picture(), self.disc()
        if ends is None:
            return made
        # Directions of parts of pixels near the sun.
        parts = 8
        reach = self.half + 2 * math.pi / HEIGHT
        rows = np.nonzero(np.abs(latitudes(HEIGHT) - math.asin(self.sun[2])) < reach)[0]
        inner = (np.arange(parts) + 0.5) / parts
        high = math.pi / 2 - (rows[:, None] + inner).ravel() / HEIGHT * math.pi
        turn = -((np.arange(WIDTH)[:, None] + inner).ravel() / WIDTH - 0.5) * 2 * math.pi
        cosine = np.sin(high)[:, None] * self.sun[2] + np.cos(high)[:, None] * (np.cos(turn) * self.sun[0] + np.sin(turn) * self.sun[1])
        outer = np.clip(1 - (1 - cosine**2) / math.sin(min(self.half, math.pi / 2)) ** 2, 0, None)
        light = np.where((cosine > math.cos(self.half)) & (high > 0)[:, None], 1 - LIMB + LIMB * np.sqrt(outer), 0)
        share = np.clip((high - math.asin(self.sun[2])) / (2 * self.half) + 0.5, 0, 1)[:, None, None]
        shine = light[..., None] * (ends[0] + share * (ends[1] - ends[0]))
        made = made.copy()
        made[rows] += shine.reshape(len(rows), parts, WIDTH, parts, 3).mean(axis=(1, 3)).astype(np.float32)
        return made


def latitudes(height):
    return math.pi / 2 - (np.arange(height) + 0.5) / height * math.pi


@functools.lru_cache(maxsize=8)
def picture(model, elevation, rotation, medium):
    high = latitudes(HEIGHT)
    turn = -((np.arange(WIDTH) + 0.5) / WIDTH - 0.5) * 2 * math.pi
    # The sky is the same on both sides of the sun.
    beside = np.abs((math.pi / 2 - turn - rotation + math.pi) % (2 * math.pi) - math.pi)
    made = np.ascontiguousarray(model.radiance(high, beside, elevation, *medium), np.float32)
    made.setflags(write=False)
    return made


def of_node(node):
    """The sky of a Sky Texture node, or None where its type is no model of the air."""
    model = MODELS.get({"NISHITA": "SINGLE_SCATTERING"}.get(node.sky_type, node.sky_type))
    if model is None:
        return None
    aerosol = node.aerosol_density if hasattr(node, "aerosol_density") else node.dust_density
    return Sky(
        model, node.sun_elevation, node.sun_rotation, node.sun_size, node.sun_intensity, node.altitude,
        node.air_density, aerosol, node.ozone_density, node.sun_disc,
    )
