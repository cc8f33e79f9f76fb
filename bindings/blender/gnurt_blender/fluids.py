# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids of gas that a mesh's modifier simulated: density, flames, heat, temperature, colour, velocity.

Blender lists cells with x first. Space: grids fill the box of the evaluated mesh, which is the domain's, also if that adapts.
Tests: `tests/checks.py`.
"""

import numpy as np

# Names as the nodes read them: the property, and the numbers of a cell.
GRIDS = {
    "density": ("density_grid", 1),
    "flame": ("flame_grid", 1),
    "heat": ("heat_grid", 1),
    "temperature": ("temperature_grid", 1),
    "color": ("color_grid", 4),
    "velocity": ("velocity_grid", 3),
}


def domain_of(found):
    """The settings of the gas that an evaluated object is the domain of, or None."""
    for modifier in found.modifiers:
        if modifier.type == "FLUID" and modifier.show_render and modifier.fluid_type == "DOMAIN" and modifier.domain_settings.domain_type == "GAS":
            return modifier.domain_settings
    return None


def shape_of(base, count):
    """The cells along the axes of a grid with so many cells: those of the domain, or a multiple where noise refines it."""
    times = round((count / max(int(np.prod(base)), 1)) ** (1 / 3))
    return tuple(int(n) * times for n in base) if int(np.prod(base)) * times**3 == count and times > 0 else None


def grids_of(domain, box, warn):
    """Grids by name, as files of volumes have them: arrays (x, y, z) or (x, y, z, 3), and matrices from the unit cube to the object."""
    low, high = box
    place = np.diag([*(high - low), 1.0])
    place[:3, 3] = low
    made = {}
    for name, (source, width) in GRIDS.items():
        values = np.array(getattr(domain, source)[:], np.float32)
        if not values.any():
            continue
        shape = shape_of(domain.domain_resolution, len(values) // width)
        if shape is None:
            warn(f"grid '{name}' of a gas has {len(values)} numbers, which do not fit its domain")
            continue
        cells = values.reshape(*shape[::-1], width).transpose(2, 1, 0, 3)
        made[name] = (np.ascontiguousarray(cells[..., 0] if width == 1 else cells[..., :3]), place)
    return made
