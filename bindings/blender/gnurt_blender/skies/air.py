# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through the shells of the air around the earth: places along them, and tables over two coordinates."""

import numpy as np


def to_sphere(radius, cosine, outer):
    """The length of the way from a distance to the earth's centre, in a direction at an angle to the zenith, to a sphere around it."""
    return -radius * cosine + np.sqrt(np.maximum(radius**2 * (cosine**2 - 1) + outer**2, 0))


def radius_at(radius, cosine, length):
    """The distance to the earth's centre after a way."""
    return np.sqrt(radius**2 + length**2 + 2 * radius * length * cosine)


def is_shadowed(radius, cosine, ground):
    """Whether the earth is in the way."""
    return (cosine < 0) & (radius * np.sqrt(np.maximum(1 - cosine**2, 0)) < ground)


def bilinear(table, row, column):
    """Values of a table between its entries; places beyond its edges have the values there."""
    row, column = np.clip(row, 0, table.shape[0] - 1), np.clip(column, 0, table.shape[1] - 1)
    i, j = np.minimum(row.astype(int), table.shape[0] - 2), np.minimum(column.astype(int), table.shape[1] - 2)
    down, right = (row - i)[..., None], (column - j)[..., None]
    upper = table[i, j] * (1 - right) + table[i, j + 1] * right
    lower = table[i + 1, j] * (1 - right) + table[i + 1, j + 1] * right
    return upper * (1 - down) + lower * down


def henyey_greenstein(cosine, g):
    return (1 - g * g) / (1 + g * g - 2 * g * cosine) ** 1.5 / (4 * np.pi)


def rayleigh(cosine):
    return 3 / (16 * np.pi) * (1 + cosine**2)


def directions(high, beside):
    """Unit vectors of all pairs of elevations and azimuths; the sun's azimuth is 0 and along the second axis."""
    high, beside = np.meshgrid(high, beside, indexing="ij")
    return np.stack([np.sin(beside) * np.cos(high), np.cos(beside) * np.cos(high), np.sin(high)], axis=-1)
