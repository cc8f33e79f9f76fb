# SPDX-License-Identifier: GPL-3.0-or-later
"""A sky of light that scatters once, in 21 wavelengths.

Source: [NSTN93]; the phase function of aerosols is that of Cornette and Shanks there. The heights of air, aerosols and ozone are those of
[BN08] and [Bru17], the cross-sections of ozone those of [Bru17], the sun is a black body of 5778 K. Steps and places of the table are those that
Cycles' pictures show: 32 steps, light of a step passes the whole step, and an entry is shown half an entry higher and nearer to the sun.
"""

import functools
import math

import numpy as np

from . import air
from .colors import MATCHING, RGB_FROM_XYZ

GROUND, TOP = 6360e3, 60e3
AIR_HEIGHT, AEROSOL_HEIGHT = 8000.0, 1200.0
STEPS = 32
ROWS, COLUMNS = 128, 256
WAVELENGTHS = np.arange(380, 781, 20)
# Scattering per metre on the ground: Rayleigh's formula with an index of 1.0002926 and 2.504e25 molecules/m3 [NSTN93], and aerosols, whose
# extinction is larger by their absorption.
AIR = 1.1311e-6 * (WAVELENGTHS * 1e-3) ** -4.0
AEROSOL, EXTINCTION, G = 2e-5, 1.11, 0.76
# Cross-sections of ozone by wavelength, m2, and the largest number of molecules per m3, of 310 Dobson units.
OZONE_SECTIONS = np.interp(
    WAVELENGTHS,
    np.arange(365, 800, 10),
    1e-26 * np.array([
        0.118, 0.02182, 0.02818, 0.06636, 0.1527, 0.2763, 0.552, 0.8451, 1.582, 2.316, 3.669, 4.924, 7.752, 9.016, 14.8, 16.02, 21.39, 27.55, 30.91,
        35.0, 42.66, 46.72, 43.98, 47.01, 50.19, 43.05, 37.4, 32.15, 26.62, 22.38, 18.52, 14.73, 12.09, 9.423, 7.455, 6.566, 5.105, 4.15, 4.228, 3.237,
        2.451, 2.801, 2.534, 1.624,
    ]),
)  # fmt: skip
OZONE = OZONE_SECTIONS * 310 * 2.687e20 / 15e3


def of_the_sun():
    """Irradiance by a black body of the sun's size and distance, W/(m2 nm)."""
    metres = WAVELENGTHS * 1e-9
    return 1.191043e-16 / metres**5 / (np.exp(0.01438777 / (metres * 5778)) - 1) * 1e-9 * math.pi * (6.957e8 / 1.495979e11) ** 2


SUN = of_the_sun()


def color(spectra):
    """Linear Rec. 709 of spectra."""
    return np.maximum(spectra @ (20 * MATCHING) @ RGB_FROM_XYZ.T, 0)


def densities(height):
    """Air, aerosols and ozone, as shares of the most."""
    ozone = np.where(height < 25e3, height - 10e3, 40e3 - height) / 15e3
    return np.stack([np.exp(-height / AIR_HEIGHT), np.exp(-height / AEROSOL_HEIGHT), np.maximum(ozone, 0)], axis=-1)


def lengths_to_space(radius, cosine):
    """Lengths of a way out of the air, as if air, aerosols and ozone were everywhere as dense as at most."""
    way = air.to_sphere(radius, cosine, GROUND + TOP)
    made = 0.0
    for at, share in zip(*np.polynomial.legendre.leggauss(24)):
        height = air.radius_at(radius, cosine, way * (at + 1) / 2) - GROUND
        made = made + share / 2 * way[..., None] * densities(np.maximum(height, -2e3))
    return made


@functools.cache
def table_to_space():
    """`lengths_to_space` by the root of the height and by the signed root of the cosine."""
    roots = np.linspace(-1, 1, 385)
    height, cosine = np.meshgrid(TOP * np.linspace(0, 1, 96) ** 2, np.sign(roots) * roots**2, indexing="ij")
    return lengths_to_space(GROUND + height, cosine)


def to_space(radius, cosine):
    height = np.clip(radius - GROUND, 0, TOP)
    return air.bilinear(table_to_space(), np.sqrt(height / TOP) * 95, (np.sign(cosine) * np.sqrt(np.abs(cosine)) + 1) * 192)


def extinctions(lengths, amounts):
    """The optical depth of lengths, by wavelength."""
    a, b, c = np.moveaxis(lengths * amounts, -1, 0)[..., None]
    return a * AIR + b * (AEROSOL * EXTINCTION) + c * OZONE


@functools.lru_cache(maxsize=8)
def table(elevation, altitude, *amounts):
    """Colours of directions above the horizon: rows by the root of the elevation, columns from the sun to the far side."""
    way = air.directions(math.pi / 2 * (np.arange(ROWS) / ROWS) ** 2, math.pi * (np.arange(COLUMNS) + 1) / COLUMNS)
    sun = np.array([0, math.cos(elevation), math.sin(elevation)])
    start, cosine = GROUND + altitude, way[..., 2]
    to_sun = way @ sun
    step = air.to_sphere(start, cosine, GROUND + TOP) / STEPS
    scattered_by_air = air.rayleigh(to_sun)
    scattered_by_aerosols = 3 * (1 - G * G) * (1 + to_sun**2) / (8 * math.pi * (2 + G * G) * (1 + G * G - 2 * G * to_sun) ** 1.5)
    passed, spectra = np.zeros((*cosine.shape, 3)), np.zeros((*cosine.shape, len(WAVELENGTHS)))
    for i in range(STEPS):
        length = (i + 0.5) * step
        radius = air.radius_at(start, cosine, length)
        dense = densities(radius - GROUND)
        passed += dense * step[..., None]
        above = (start * sun[2] + length * to_sun) / radius
        light = np.exp(-extinctions(passed + to_space(radius, above), amounts))
        light[air.is_shadowed(radius, above, GROUND)] = 0
        by_air = (amounts[0] * scattered_by_air * dense[..., 0] * step)[..., None] * AIR
        by_aerosols = amounts[1] * AEROSOL * scattered_by_aerosols * dense[..., 1] * step
        spectra += light * (by_air + by_aerosols[..., None])
    made = color(spectra * SUN)
    # Below the horizon its light fades.
    below = np.maximum(1 - 2.5 * np.sin(math.pi / 2 * (np.arange(ROWS, 0, -1) / ROWS) ** 2), 0) ** 3
    return np.concatenate([made[:1] * below[:, None, None], made])


def radiance(high, beside, elevation, altitude, *amounts):
    """Colours of all pairs of elevations and of angles beside the sun's azimuth: (elevations, angles, 3)."""
    row = ROWS - 0.5 + np.sign(high) * np.sqrt(np.abs(high) / (math.pi / 2)) * ROWS
    row, column = np.meshgrid(row, beside / math.pi * COLUMNS - 0.5, indexing="ij")
    return air.bilinear(table(elevation, altitude, *amounts), row, column)


def sunlight(high, altitude, *amounts):
    """The irradiance of the sun at elevations, after the air: (elevations, 3). As in Cycles' pictures ozone takes none of it."""
    lengths = lengths_to_space(np.full_like(high, GROUND + altitude), np.sin(np.maximum(high, 0)))
    return color(SUN * np.exp(-extinctions(lengths, np.array([*amounts[:2], 0.0]))))
