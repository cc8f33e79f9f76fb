# SPDX-License-Identifier: GPL-3.0-or-later
"""embreex.rtcore_scene."""

import numpy as np

from ... import RayScene

__all__ = ["EmbreeScene"]

#: What a ray that nothing stops has as its far end.
_FAR = 1e37


def _checked(name, array):
    array = np.asarray(array)
    if array.dtype != np.float32:
        raise ValueError(f"{name}: expected float32, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name}: expected shape (n, 3), not {array.shape}")
    return array


class EmbreeScene:
    """Meshes that rays are run against. All rays are watertight, whatever `robust`."""

    def __init__(self, device=None, robust=True, threads=0):
        self.device = device
        self.is_committed = 0
        self._threads = threads
        self._scene = RayScene()

    def run(self, vec_origins, vec_directions, dists=None, query="INTERSECT", output=None):
        """primIDs (n,) or -1; OCCLUDED: 0 or -1; DISTANCE: far ends. A dict of everything if `output`."""
        origins, directions = _checked("vec_origins", vec_origins), _checked("vec_directions", vec_directions)
        if query not in ("INTERSECT", "OCCLUDED", "DISTANCE"):
            raise ValueError(f"query: expected INTERSECT, OCCLUDED or DISTANCE, not {query!r}")
        n = len(origins)
        if dists is None:
            far = np.full(n, _FAR, np.float32)
        elif isinstance(dists, np.ndarray):
            if dists.dtype != np.float32:
                raise ValueError(f"dists: expected float32, not {dists.dtype}")
            far = dists
        else:
            far = np.full(n, dists, np.float32)
        self.is_committed = 1
        if query == "OCCLUDED" and not output:
            hit = self._scene.occluded(origins, directions, 0.0, far, threads=self._threads)
            return np.where(hit, 0, -1).astype(np.int32)
        hits = self._scene.intersect(origins, directions, 0.0, far, threads=self._threads)
        hit = hits.prim_id >= 0
        far[hit] = hits.t[hit]
        if output:
            return {
                "u": hits.u,
                "v": hits.v,
                "Ng": self._normals(hits),
                "tfar": far,
                "primID": hits.prim_id,
                "geomID": hits.geom_id,
            }
        return far if query == "DISTANCE" else hits.prim_id

    def _normals(self, hits):
        """(n, 3): normals of the triangles that were hit by the right hand rule, twice their area long; zeros where rays missed."""
        normals = np.zeros((len(hits), 3), np.float32)
        for geom_id, (vertices, faces, _) in enumerate(self._scene.__getstate__()["meshes"]):
            here = hits.geom_id == geom_id
            a, b, c = np.moveaxis(vertices[faces[hits.prim_id[here]]], 1, 0)
            normals[here] = np.cross(b - a, c - a)
        return normals
