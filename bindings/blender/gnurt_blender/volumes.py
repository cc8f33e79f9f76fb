# SPDX-License-Identifier: GPL-3.0-or-later
"""Media of a scene: within meshes, in volume objects, and of the world.

Media add where they overlap, as in Cycles. Space: coefficients are per unit of the world. Light of a medium is radiance times absorption in
the package, so what shines without absorbing gets a little of it.
"""

import os
import tempfile

import bpy
import gnurt
import numpy as np

from . import drifts, fluids
from .baking import Box
from .nodes.media import Part, Reader
from .nodes.tree import source

# Absorption over a whole body that only shines, and over cells that do.
EVEN_LOSS, CELL_LOSS = 1e-3, 1e-2
# The largest difference of colours in the cells of a grid that is not reported.
SAME = 0.03


def is_fed(tree, socket):
    """Whether a socket of an output node has a node behind it."""
    found = source(None, tree, socket, None)
    return found is not None and found[0] != "default"


def has_media(depsgraph):
    """Whether anything of a scene may scatter light between surfaces."""
    for found in depsgraph.ids:
        if isinstance(found, bpy.types.Volume):
            return True
        if isinstance(found, (bpy.types.Material, bpy.types.World)):
            tree = getattr(found, "node_tree", None)
            output = tree.get_output_node("CYCLES") if tree else None
            if output is not None and is_fed(tree, output.inputs["Volume"]):
                return True
    return False


class Even:
    """A medium whose coefficients are colours: the sum of parts."""

    def __init__(self, parts, warn):
        self.absorption, self.scattering, self.emission = (
            sum((part.coefficients[k] for part in parts), np.zeros(3)) for k in range(3)
        )
        self.lobes = joined([(part.coefficients[1].mean(), part.lobes) for part in parts], warn)

    def properties(self, loss):
        """Arguments of a medium, with an absorption of at least `loss` where it shines."""
        absorption = np.where(self.emission > 0, np.maximum(self.absorption, loss), self.absorption)
        light = np.where(absorption > 0, self.emission / np.where(absorption > 0, absorption, 1.0), 0.0)
        return {
            "absorption": tuple(absorption.tolist()),
            "scattering": tuple(self.scattering.tolist()),
            "emission": tuple(light.tolist()),
            **phase(self.lobes),
        }


def phase(lobes):
    first, second, share = lobes
    return {"anisotropy": first, "second_anisotropy": second, "second_share": share}


def joined(weighted, warn):
    """The lobes of several parts: at most two, of the same mean cosine."""
    single = {}
    for weight, (first, second, share) in weighted:
        for g, own in ((first, weight * (1 - share)), (second, weight * share)):
            if own > 0:
                single[g] = single.get(g, 0.0) + own
    if not single:
        return (0.0, 0.0, 0.0)
    order = sorted(single, key=lambda g: -single[g])
    if len(order) > 2:
        warn("a volume of more than two phase functions is shown with two")
    first, rest = order[0], order[1:]
    total = sum(single.values())
    share = sum(single[g] for g in rest) / total
    second = sum(single[g] * g for g in rest) / (share * total) if rest else 0.0
    return (first, second, share)


def of_body(export, code, tree, output, found, matrix):
    """The number of the medium within an object's mesh, or None."""
    if not is_fed(tree, output.inputs["Volume"]):
        return None
    domain = fluids.domain_of(found) if found is not None else None
    if domain is not None:
        # The grids are where this object is.
        code.uses_object = True
        put_gas(export, code, tree, output, found, matrix, domain)
        return None
    box = Box(code.host.mesh, matrix) if isinstance(code.host.mesh, bpy.types.Mesh) and len(code.host.mesh.vertices) else None
    bake = box and (lambda place, identifier: box.sampled(code.host, place, identifier))
    parts = Reader(code, bake=bake).parts(tree, output.inputs["Volume"])
    if not parts:
        return None
    name = code.host.material.name
    if any(x.ndim == 4 for part in parts for x in part.coefficients):
        # The cells are where this object is.
        code.uses_object = True
        return export.scene.add_medium(name, **in_cells(parts, box, code.warn, name), extent="bodies", adds=True)
    size = np.linalg.norm(np.array(found.dimensions)) if found is not None else 1.0
    even = Even(parts, code.warn)
    return export.scene.add_medium(name, **even.properties(EVEN_LOSS / max(size, 1e-6)), adds=True)


def in_cells(parts, box, warn, name):
    """Arguments of one medium of coefficients that vary in the cells of a box."""
    zero = np.zeros((*box.cells, 3))
    absorption, scattering, light = (sum((part.coefficients[k] for part in parts), zero) for k in range(3))
    place = box.world_from_unit()
    both = np.concatenate([absorption, scattering], axis=-1)
    shines = light.max(axis=-1) > 0
    loss = CELL_LOSS / max(np.linalg.norm(place[:3, :3], axis=0).max(), 1e-12)
    density = both.max(axis=-1)
    density = np.where(shines, np.maximum(density, loss), density)
    only_shines = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    color = both.reshape(-1, 6).sum(axis=0) / density.sum() if both.any() else only_shines
    if both.any() and np.abs(both - density[..., None] * color).max() > SAME * density.max() + loss:
        warn(f"material '{name}': colours that vary within a volume are shown as their mean")
    made = {"scattering": tuple(color[3:].tolist()), "density": density.astype(np.float32), "transform": place}
    if shines.any():
        color[:3] = np.maximum(color[:3], 1e-2)
        glow = light / np.maximum(density[..., None] * color[:3], 1e-30)
        made |= {"emission": glow.max(), "emission_grid": (glow / glow.max()).astype(np.float32)}
    made["absorption"] = tuple(color[:3].tolist())
    return made | phase(joined([(part.coefficients[1].mean(), part.lobes) for part in parts], warn))


def of_world(export, code, tree, output):
    """Adds the fog of the world."""
    parts = Reader(code).parts(tree, output.inputs["Volume"])
    if parts:
        properties = Even(parts, code.warn).properties(1e-4)
        export.scene.add_medium("world", extent="around", **properties)


class Cells:
    """The grids of a volume object on the cells of one box."""

    def __init__(self, grids, first):
        self.grids, self.used = grids, []
        array, matrix = grids[first]
        # From the world of the file to cells of the first grid.
        self.step = matrix @ np.diag([*(1.0 / np.array(array.shape[:3])), 1.0])
        index = np.linalg.inv(self.step)
        low, high = np.zeros(3), np.array(array.shape[:3], float)
        for _, other in grids.values():
            corners = np.array([[x, y, z, 1] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
            at = (index @ other @ corners.T)[:3]
            low, high = np.minimum(low, at.min(axis=1)), np.maximum(high, at.max(axis=1))
        self.low = np.floor(low + 1e-4).astype(int)
        self.shape = np.ceil(high - 1e-4).astype(int) - self.low

    def matrix(self):
        """From the unit cube, which the cells fill, to the world of the file."""
        place = np.eye(4)
        place[:3, 3] = self.low
        return self.step @ place @ np.diag([*self.shape.astype(float), 1.0])

    def widen(self, cells):
        """Adds cells on both sides of each axis."""
        self.low, self.shape = self.low - cells, self.shape + 2 * np.asarray(cells)

    def __call__(self, name):
        if name not in self.grids:
            return None
        if name not in self.used:
            self.used.append(name)
        return self.values(name)

    def values(self, name):
        """The values of a grid in the cells of the box."""
        array, matrix = self.grids[name]
        # The middles of our cells in those of the grid.
        index = np.diag([*map(float, array.shape[:3]), 1.0]) @ np.linalg.inv(matrix) @ self.step
        axes = np.meshgrid(*(self.low[k] + np.arange(self.shape[k]) + 0.5 for k in range(3)), indexing="ij")
        at = [np.floor(sum(index[k, m] * axes[m] for m in range(3)) + index[k, 3] + 1e-6).astype(int) for k in range(3)]
        within = np.all([(at[k] >= 0) & (at[k] < array.shape[k]) for k in range(3)], axis=0)
        values = array[tuple(np.clip(at[k], 0, array.shape[k] - 1) for k in range(3))].astype(np.float64)
        return np.where(within if values.ndim == 3 else within[..., None], values, 0.0)


def grids_of(volume, export, name):
    """The evaluated grids of a volume, by name."""
    volume.grids.load()
    if volume.grids.error_message:
        export.warn(f"object '{name}': its file is not shown: {volume.grids.error_message}")
        return {}
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "grids.vdb")
        if len(volume.grids) == 0 or not volume.grids.save(path):
            return {}
        try:
            return gnurt.read_volume(path)
        except (ValueError, OSError) as error:
            export.warn(f"object '{name}': its grids are not shown: {error}")
            return {}


def put_object(export, code, tree, output, found, matrix):
    """Adds the media of a volume object at a place."""
    grids = grids_of(found.data, export, found.name)
    if not grids:
        return
    cells = Cells(grids, "density" if "density" in grids else next(iter(grids)))
    drift = drifts.of_volume(cells, found.data, export.scene_data)
    if output is None:
        half = 0.5 * (cells("density") if "density" in grids else 0.0)
        parts = [Part(half, half)]
    else:
        parts = Reader(code, cells).parts(tree, output.inputs["Volume"])
    if not cells.used or not parts:
        return
    if not (found.visible_camera and found.visible_shadow):
        export.warn(f"object '{found.name}': volume objects are visible to all rays")
    scale = 1.0
    if found.data.render.space == "OBJECT":
        scale = 1.0 / max(np.linalg.norm(matrix[:3, :3] @ np.ones(3)) / 3**0.5, 1e-12)
    put_cells(export, cells, parts, found, matrix, scale, found.data.render.clipping, drift)


def put_gas(export, code, tree, output, found, matrix, domain):
    """Adds the media of simulated gas, whose mesh shows where it is."""
    corners = np.array(found.bound_box)
    grids = fluids.grids_of(domain, (corners.min(axis=0), corners.max(axis=0)), export.warn)
    if grids:
        cells = Cells(grids, "density" if "density" in grids else next(iter(grids)))
        parts = Reader(code, cells).parts(tree, output.inputs["Volume"])
        if cells.used and parts:
            if "velocity" in cells.grids and export.scene_data.render.use_motion_blur:
                export.warn(f"object '{found.name}': the motion of its gas is not blurred")
            put_cells(export, cells, parts, found, matrix, 1.0, domain.clipping)


def put_cells(export, cells, parts, found, matrix, scale, clipping, drift=None):
    """Adds media of parts on the cells of grids: one for each phase function, and one that shines."""
    place = matrix @ cells.matrix()
    # Even parts fill the cells that are there.
    there = np.any([np.abs(cells(name)).reshape(*cells.shape, -1).max(axis=-1) > clipping for name in cells.used], axis=0)
    by_lobes, light = {}, np.zeros((*cells.shape, 3))
    for part in parts:
        own = [x * scale if x.ndim == 4 else there[..., None] * x * scale for x in part.coefficients]
        both = np.concatenate(own[:2], axis=-1)
        by_lobes[part.lobes] = by_lobes.get(part.lobes, 0.0) + both
        light = light + own[2]
    if drift is not None:
        by_lobes, light = {lobes: drift.mean(both) for lobes, both in by_lobes.items()}, drift.mean(light)
    for lobes, both in by_lobes.items():
        density = both.max(axis=-1)
        if not density.any():
            continue
        color = both.reshape(-1, 6).sum(axis=0) / density.sum()
        if np.abs(both - density[..., None] * color).max() > SAME * density.max():
            export.warn(f"object '{found.name}': colours that vary within a volume are shown as their mean")
        export.scene.add_medium(
            found.name, absorption=tuple(color[:3].tolist()), scattering=tuple(color[3:].tolist()), **phase(lobes), density=density.astype(np.float32), transform=place
        )
    if light.any():
        shines = dilated(light.max(axis=-1) > 0)
        loss = CELL_LOSS / max(np.linalg.norm(place[:3, :3], axis=0).max(), 1e-12)
        most = light.max()
        export.scene.add_medium(
            f"{found.name} light", absorption=loss, emission=most / loss, density=shines.astype(np.float32), emission_grid=(light / most).astype(np.float32), transform=place
        )


def dilated(mask):
    """Also the neighbours of cells, so that what is interpolated between them stays whole."""
    for axis in range(3):
        grown = mask.copy()
        low, high = [slice(None)] * 3, [slice(None)] * 3
        low[axis], high[axis] = slice(None, -1), slice(1, None)
        grown[tuple(low)] |= mask[tuple(high)]
        grown[tuple(high)] |= mask[tuple(low)]
        mask = grown
    return mask
