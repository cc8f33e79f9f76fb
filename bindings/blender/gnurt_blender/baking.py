# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees sampled in the cells of a box: what textures make of the volume of a mesh.

The tree becomes the shader of slices through the box. One picture, whose rays start at the middles of cells just above a slice, shows all.
Space: the object's, which a matrix takes to the world.
"""

import gnurt
import numpy as np

from . import meshes
from .nodes.tree import Code, Place

# Cells along the longest side of the box.
CELLS = 64
RAYS = """
camera blender_cells (point corner = point(0), vector x = vector(1, 0, 0), vector y = vector(0, 1, 0), vector z = vector(0, 0, 1),
    float columns = 1, float rows = 1, float layers = 1)
{
    float column = min(floor(u * columns), columns - 1.0), line = min(floor((1.0 - v) * rows * layers), rows * layers - 1.0);
    float level = floor((line + 0.5) / rows), row = line - level * rows;
    P = corner + ((column + 0.5) / columns) * x + ((row + 0.5) / rows) * y + ((level + 0.75) / layers) * z;
    I = -normalize(z);
    weight = color(1);
    tmin = 0;
    tmax = 0.5 * length(z) / layers;
}
"""


class Box:
    """The cells of the box of a mesh."""

    def __init__(self, mesh, matrix):
        self.mesh, self.matrix = mesh, matrix
        points = meshes.flat(mesh.vertices, "co", np.float32, 3).astype(np.float64)
        self.low, high = points.min(axis=0), points.max(axis=0)
        self.size = np.maximum(high - self.low, 1e-6 * max(np.ptp(points), 1e-6))
        sides = self.size * np.linalg.norm(matrix[:3, :3], axis=0)
        self.cells = np.clip(np.ceil(CELLS * sides / sides.max()), 2, CELLS).astype(int)

    def world_from_unit(self):
        place = np.diag([*self.size, 1.0])
        place[:3, 3] = self.low
        return self.matrix @ place

    def slices(self):
        """A square in the middle of each layer of cells."""
        nx, ny, nz = self.cells
        corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
        points = np.empty((nz, 4, 3))
        points[..., :2] = corners
        points[..., 2] = ((np.arange(nz) + 0.5) / nz)[:, None]
        faces = np.array([(0, 1, 2), (0, 2, 3)])[None] + 4 * np.arange(nz)[:, None, None]
        return self.low + points.reshape(-1, 3) * self.size, faces.reshape(-1, 3)

    def sampled(self, host, place, identifier):
        """An input of a node in all cells, (x, y, z, 3); one colour where it is even; None if nothing can be read."""
        code = Code("surface", host)
        value = Place(code, place.tree, place.node, place.outer).value(identifier, "color")
        points, faces = self.slices()
        attributes = {}
        for (_, name), known in code.attributes.items():
            if name not in {"box_low", "box_scale"}:
                place.warn(f"attributes of a mesh are not known in its volume: {name}")
                continue
            attributes[known] = np.tile(np.asarray(meshes.box(self.mesh)[name == "box_scale"], np.float32), (len(points), 1))
        scene = gnurt.Scene()
        text = code.text("blender_volume", [f"Ci = {value} * emission();"])
        scene.add_mesh(
            points, faces, transform=self.matrix, attributes=attributes, material=scene.add_material(shader=text, **({"textures": textures(code, scene, host)} if code.textures else {}))
        )
        scene.add_light("environment", radiance=0)
        unit, (nx, ny, nz) = self.world_from_unit(), self.cells
        names = {"corner": unit[:3, 3], "x": unit[:3, 0], "y": unit[:3, 1], "z": unit[:3, 2]}
        parameters = {name: tuple(map(float, vector)) for name, vector in names.items()}
        parameters |= {"columns": float(nx), "rows": float(ny), "layers": float(nz)}
        camera = gnurt.Camera(eye=(0, 0, 1), target=(0, 0, 0))
        seen = scene.render(int(nx), int(ny * nz), spp=1, max_depth=1, camera=camera, camera_shader=RAYS, camera_parameters=parameters, filter="box")
        values = np.asarray(seen)[..., :3].astype(np.float64).reshape(nz, ny, nx, 3).transpose(2, 1, 0, 3)
        if np.ptp(values.reshape(-1, 3), axis=0).max() <= 1e-5 * max(values.max(), 1e-9):
            return values.mean(axis=(0, 1, 2))
        return values


def textures(code, scene, host):
    """Pictures of a shader in the scene of its slices."""
    made = {}
    for name, number in code.textures.items():
        made[name] = scene.add_texture(host.export.pictures[number], colorspace="linear")
    return made
