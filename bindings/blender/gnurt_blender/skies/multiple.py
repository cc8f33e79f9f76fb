# SPDX-License-Identifier: GPL-3.0-or-later
"""A sky of light that scatters often, in four wavelengths whose sum is a colour.

Source: [Gar23], with its four wavelengths, its heights of molecules and ozone, its matrix to colours and its fit of light scattered more than
once; coefficients of molecules [Buc95], urban aerosols and ozone as its path tracer has them. The table of transmittance is that of [BN08].
Units: kilometres.
"""

import functools
import math

import numpy as np

from . import air

GROUND, THICKNESS = 6371.0, 100.0
# Of altitudes, metres.
TOP = 1000 * THICKNESS
STEPS = 64
ALBEDO, G = 0.3, 0.8
# At 630, 560, 490 and 430 nm: irradiance of the sun, W/(m2 nm), scattering of molecules on the ground, 1/km, cross-sections of ozone, m2, and of
# urban aerosols, km2 of a number per km3.
SUN = np.array([1.679, 1.828, 1.986, 1.307])
MOLECULES = np.array([6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2])
OZONE_SECTIONS = np.array([3.472e-25, 3.914e-25, 1.349e-25, 1.103e-26])
SCATTERED, ABSORBED = np.array([1.5898e-22, 1.7704e-22, 2.0933e-22, 2.4001e-22]), np.array([2.8633e-24, 4.6088e-24, 7.9562e-24, 1.3519e-23])
AEROSOLS, AEROSOL_HEIGHT = 1.3681e20, 0.73
# Ozone of 354 Dobson units, around a height of 21 km: the logarithm of the height is normal. Molecules per m2 and km.
OZONE = 354.2 * 2.6867e20 / math.sqrt(math.pi / 5.5556) * 1e-3
OFTEN = 0.02 * np.array([0.217, 0.347, 0.594, 1.0])
RGB_FROM_FOUR = np.array([[137.672, 32.5491, -38.9143, 8.57284], [-8.6329, 91.2980, 34.3167, -11.1034], [-1.71816, -12.0054, 29.8904, 117.476]])
HEIGHTS, COSINES = 64, 256
# Entries of the table of directions: from the horizon up or down, and beside the sun.
HALF, BESIDE = 80, 96


def media(height, amounts):
    """Scattering of molecules, of aerosols, and extinction, per km at heights in km."""
    height = np.maximum(height, 0)[..., None]
    molecules = np.exp(-0.07771971 * height**1.16364243) * MOLECULES * amounts[0]
    aerosols = AEROSOLS * np.exp(-height / AEROSOL_HEIGHT) * amounts[1]
    root = np.log(np.maximum(height, 1e-4))
    ozone = OZONE * 1e3 * np.exp(-((root - 3.22261) ** 2) * 5.5556 - root) * OZONE_SECTIONS * amounts[2]
    return molecules, aerosols * SCATTERED, molecules + aerosols * (SCATTERED + ABSORBED) + ozone


def transmittance(radius, cosine, amounts):
    """The share of light that goes out of the air."""
    way = air.to_sphere(radius, cosine, GROUND + THICKNESS) / STEPS
    depth = 0.0
    for i in range(STEPS):
        height = air.radius_at(radius, cosine, way * (i + 0.5)) - GROUND
        depth = depth + media(height, amounts)[2] * way[..., None]
    return np.exp(-depth)


class Table:
    """Transmittance by height and cosine."""

    def __init__(self, amounts):
        height, cosine = np.meshgrid(np.linspace(0, THICKNESS, HEIGHTS), np.linspace(-1, 1, COSINES), indexing="ij")
        self.values = transmittance(GROUND + height, cosine, amounts)

    def at(self, height, cosine):
        return air.bilinear(self.values, height / THICKNESS * (HEIGHTS - 1), (cosine + 1) / 2 * (COSINES - 1))


def scattered_often(table, radius, above):
    """Light that reaches a place from the ground and from the rest of the air, as a share of the sun's, by the cosine of the sun's angle there."""
    height, here, up = np.maximum(radius - GROUND, 0), np.zeros_like(above), np.ones_like(above)
    ground = 0.5 * (1 - np.sqrt(np.maximum(1 - (GROUND / radius) ** 2, 0))) * (ALBEDO / math.pi) * np.maximum(above, 0)
    way = table.at(here, above) * (table.at(here, up) / np.maximum(table.at(height, up), 1e-30))
    return OFTEN / (1 + 5 * np.exp(-17.92 * above))[..., None] + ground[..., None] * way


@functools.lru_cache(maxsize=8)
def quarter(high, beside, elevation, altitude, *amounts):
    """`radiance` of tuples of angles."""
    table = Table(amounts)
    way = air.directions(np.array(high), np.array(beside))
    sun = np.array([0, math.cos(elevation), math.sin(elevation)])
    start, cosine = GROUND + altitude * 1e-3, way[..., 2]
    to_sun = way @ sun
    inner = start**2 * (cosine**2 - 1) + GROUND**2
    to_ground = -start * cosine - np.sqrt(np.maximum(inner, 0))
    step = np.where((cosine < 0) & (inner > 0), to_ground, air.to_sphere(start, cosine, GROUND + THICKNESS)) / STEPS
    by_molecules, by_aerosols = air.rayleigh(to_sun)[..., None], air.henyey_greenstein(to_sun, G)[..., None]
    light, left = np.zeros((*cosine.shape, 4)), np.ones((*cosine.shape, 4))
    for i in range(STEPS):
        length = (i + 0.5) * step
        radius = air.radius_at(start, cosine, length)
        molecules, aerosols, extinction = media(radius - GROUND, amounts)
        above = (start * sun[2] + length * to_sun) / radius
        from_sun = table.at(np.maximum(radius - GROUND, 0), above)
        from_sun[air.is_shadowed(radius, above, GROUND)] = 0
        source = from_sun * (molecules * by_molecules + aerosols * by_aerosols) + (molecules + aerosols) * scattered_often(table, radius, above)
        passes = np.exp(-extinction * step[..., None])
        light += left * source * np.where(extinction > 0, (1 - passes) / np.maximum(extinction, 1e-30), step[..., None])
        left *= passes
    return color(light * SUN)


def color(four):
    """Linear Rec. 709 of the four wavelengths."""
    return np.maximum(four @ RGB_FROM_FOUR.T, 0)


def radiance(high, beside, elevation, altitude, *amounts):
    """Colours of all pairs of elevations and of angles beside the sun's azimuth: (elevations, angles, 3)."""
    # From entries that lie closer at the horizon and at the sun.
    rows, columns = np.linspace(-1, 1, 2 * HALF + 1), np.linspace(0, 1, BESIDE + 1)
    made = quarter(tuple(math.pi / 2 * np.sign(rows) * rows**2), tuple(math.pi * columns**2), elevation, altitude, *amounts)
    row = (np.sign(high) * np.sqrt(np.abs(high) / (math.pi / 2)) + 1) * HALF
    row, column = np.meshgrid(row, np.sqrt(beside / math.pi) * BESIDE, indexing="ij")
    # The horizon is an edge.
    above, below = air.bilinear(made[HALF:], row - HALF, column), air.bilinear(made[:HALF], row, column)
    return np.where((row >= HALF)[..., None], above, below)


def sunlight(high, altitude, *amounts):
    """The irradiance of the sun at elevations, after the air: (elevations, 3)."""
    return color(SUN * transmittance(np.full_like(high, GROUND + altitude * 1e-3), np.sin(high), amounts))
