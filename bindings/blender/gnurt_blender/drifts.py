# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion of the grids of a volume object while the shutter is open: the mean of their cells over the time.

At a moment a cell has what its velocity brings there from the moment of the frame, as in Cycles. The mean of the density stands for
densities one after the other, through which a little more light passes. Space: velocities are the object's, in its units.
Tests: the scene `drifting_smoke`.
"""

import numpy as np

from .motion import motion_position

# Moments over the time that the shutter is open.
MOMENTS = 9


class Drift:
    """How cells of a box move while the shutter is open."""

    def __init__(self, velocities, times):
        # In cells of the box in one frame, by axis: (x, y, z, 3).
        self.velocities, self.times = velocities, times

    def mean(self, values):
        """The mean over the time of values (x, y, z, n) in the cells."""
        total = np.zeros(values.shape)
        places = np.stack(np.meshgrid(*map(np.arange, values.shape[:3]), indexing="ij"), axis=-1).astype(np.float64)
        for time in self.times:
            # The velocity where the cell's content comes from, found in two steps.
            back = places - time * self.velocities
            total += sampled(values, places - time * sampled(self.velocities, back))
        return total / len(self.times)


def of_volume(cells, data, scene):
    """The motion of the cells of a volume object's data, whose box it makes wide enough; None where they stand still."""
    name = data.velocity_grid
    if not scene.render.use_motion_blur or name not in cells.grids or cells.grids[name][0].ndim != 4:
        return None
    shutter = scene.render.motion_blur_shutter
    first = {"START": 0.0, "CENTER": -shutter / 2, "END": -shutter}[motion_position(scene)]
    times = first + shutter * (np.arange(MOMENTS) + 0.5) / MOMENTS
    fps = scene.render.fps / scene.render.fps_base
    scale = data.velocity_scale / (fps if data.velocity_unit == "SECOND" else 1.0)
    index = scale * np.linalg.inv(cells.step)[:3, :3]
    far = np.abs(cells.grids[name][0].reshape(-1, 3) @ index.T).max(axis=0) * np.abs(times).max()
    cells.widen(np.ceil(far).astype(int) + 1)
    velocities = cells.values(name) @ index.T
    return Drift(velocities, times) if velocities.any() and shutter > 0 else None


def sampled(values, places):
    """Values (x, y, z, n) at places (..., 3) between the middles of cells; beyond the box nothing."""
    low = np.floor(places).astype(int)
    share = places - low
    made = np.zeros((*places.shape[:-1], values.shape[-1]))
    for corner in np.ndindex(2, 2, 2):
        at = low + corner
        weight = np.prod(np.where(corner, share, 1 - share), axis=-1)
        within = np.all((at >= 0) & (at < values.shape[:3]), axis=-1)
        at = np.where(within[..., None], at, 0)
        made += (weight * within)[..., None] * values[at[..., 0], at[..., 1], at[..., 2]]
    return made
