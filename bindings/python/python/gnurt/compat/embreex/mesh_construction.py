# SPDX-License-Identifier: GPL-3.0-or-later
"""embreex.mesh_construction."""

import numpy as np

__all__ = ["ElementMesh", "TriangleMesh"]

#: Sides of a tetrahedron and of a hexahedron in the order of Exodus II, seen from outside, in embreex's order: triangles
#: that rays hit have its numbers. Of a hexahedron's side the half with the second corner comes first where that is True.
_TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
_SIDES = (
    ((0, 3, 2, 1), False),
    ((4, 5, 6, 7), True),
    ((0, 1, 5, 4), True),
    ((1, 2, 6, 5), True),
    ((0, 4, 7, 3), False),
    ((3, 7, 6, 2), False),
)
_HEXAHEDRON = tuple(
    half
    for (a, b, c, d), second_first in _SIDES
    for half in (((a, b, c), (a, c, d)) if second_first else ((a, c, d), (a, b, c)))
)


class TriangleMesh:
    """A mesh: `(n, 3, 3)` corners, or vertices and `(m, 3)` of their numbers."""

    def __init__(self, scene, vertices, indices=None):
        vertices = np.asarray(vertices)
        if indices is None:
            if vertices.ndim != 3 or vertices.shape[1:] != (3, 3):
                raise ValueError(f"vertices: expected shape (n, 3, 3) without indices, not {vertices.shape}")
            indices = np.arange(3 * len(vertices)).reshape(-1, 3)
            vertices = vertices.reshape(-1, 3)
        self.vertices, self.indices = vertices, np.asarray(indices)
        self.mesh = scene._scene.add_triangles(self.vertices, self.indices)


class ElementMesh(TriangleMesh):
    """The sides of tetrahedra `(n, 4)` or hexahedra `(n, 8)`."""

    def __init__(self, scene, vertices, indices):
        indices = np.asarray(indices)
        tables = {4: _TETRAHEDRON, 8: _HEXAHEDRON}
        if indices.ndim != 2 or indices.shape[1] not in tables:
            raise ValueError(f"indices: expected shape (n, 4) or (n, 8), not {indices.shape}")
        sides = indices[:, np.array(tables[indices.shape[1]])].reshape(-1, 3)
        super().__init__(scene, vertices, sides)
