#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hours of sun on a square between houses, from morning to evening, as a plot of PyVista.

pip install pyvista gnurt; shadow_study.py [PICTURE.png]
"""

import sys

import numpy as np
import pyvista as pv

import gnurt

#: Latitude in degrees, and the sun's declination at an equinox.
LATITUDE, DECLINATION = np.radians(49.2), 0.0
STEPS = 49


def houses():
    """Boxes around a square of 60 m; x is east, y is north."""
    spots = [(-22, 18, 14, 8, 12), (4, 20, 20, 8, 20), (20, -8, 8, 20, 15), (-24, -16, 10, 14, 9), (0, -4, 6, 6, 26)]
    boxes = [pv.Box((x, x + w, y, y + d, 0, h)).triangulate() for x, y, w, d, h in spots]
    return boxes[0].merge(boxes[1:])


def suns():
    """Unit vectors to the sun from sunrise to sunset, and the hours that each stands for."""
    hour_angles = np.radians(np.linspace(-90, 90, STEPS))
    east = -np.sin(hour_angles) * np.cos(DECLINATION)
    north = np.cos(LATITUDE) * np.sin(DECLINATION) - np.sin(LATITUDE) * np.cos(DECLINATION) * np.cos(hour_angles)
    up = np.sin(LATITUDE) * np.sin(DECLINATION) + np.cos(LATITUDE) * np.cos(DECLINATION) * np.cos(hour_angles)
    toward = np.stack([east, north, up], axis=1)
    return toward[up > 0.02], 12.0 / (STEPS - 1)


def sunlit_hours(points, buildings):
    """Hours of direct sun at each point."""
    scene = gnurt.RayScene()
    scene.add_triangles(buildings.points, buildings.faces.reshape(-1, 4)[:, 1:])
    toward, hours = suns()
    origins = np.repeat(points, len(toward), axis=0)
    directions = np.tile(toward, (len(points), 1))
    shadowed = scene.occluded(origins, directions).reshape(len(points), -1)
    return (~shadowed).sum(axis=1) * hours


def main():
    buildings = houses()
    ground = pv.Plane(i_size=60, j_size=60, i_resolution=240, j_resolution=240).triangulate()
    ground["hours of sun"] = sunlit_hours(ground.points + [0, 0, 0.01], buildings)
    hours = ground["hours of sun"]
    print(f"{len(hours)} points, {hours.min():.2f} to {hours.max():.2f} hours of sun, mean {hours.mean():.2f}")
    if len(sys.argv) > 1:
        plot = pv.Plotter(off_screen=True, window_size=(900, 700))
        plot.add_mesh(ground, scalars="hours of sun", cmap="inferno")
        plot.add_mesh(buildings, color="lightgrey", show_edges=True)
        plot.screenshot(sys.argv[1])


if __name__ == "__main__":
    main()
