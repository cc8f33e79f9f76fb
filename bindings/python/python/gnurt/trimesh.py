# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays for trimesh: `gnurt.trimesh.install()`, or `mesh.ray = gnurt.trimesh.RayMeshIntersector(mesh)`.

Meshes whose vertices are not float32 numbers are asked in double precision.

Hits of triangles that share a corner or an edge at one place are one hit of the surface, as `RayScene.crossings` counts.
"""

import copy as _copy

import numpy as np

from . import RayScene

__all__ = ["RayMeshIntersector", "install"]


def install():
    """All meshes that trimesh makes from now on ask GNU RT, and `trimesh.ray.ray_pyembree` is this module, whether embreex is there
    or not. May be called again."""
    import sys

    import trimesh

    ours = sys.modules[__name__]
    trimesh.ray.ray_pyembree = ours
    trimesh.ray.has_embree = True
    # For `from trimesh.ray.ray_pyembree import RayMeshIntersector`: without embreex there is no module of that name.
    sys.modules["trimesh.ray.ray_pyembree"] = ours


class RayMeshIntersector:
    """What `mesh.ray` offers; follows changes of the mesh. `scale_to_box` and `threads` change no answer."""

    def __init__(self, geometry, scale_to_box=True, threads=0):
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._threads = threads
        self._built = (None, None)
        # A corner and a normal of each triangle, once they are asked for.
        self._planes = None

    def __getstate__(self):
        return {**self.__dict__, "_built": (None, None), "_planes": None}

    def __copy__(self, *_):
        return type(self)(self.mesh, self._scale_to_box, self._threads)

    def __deepcopy__(self, memo):
        return type(self)(_copy.deepcopy(self.mesh, memo), self._scale_to_box, self._threads)

    @property
    def _scene(self):
        # The key is what trimesh itself tells changes by.
        key, scene = self._built
        if scene is None or key != hash(self.mesh):
            vertices = np.asanyarray(self.mesh.vertices)
            # Rounded vertices would be those of another mesh, with folds that this one lacks.
            with np.errstate(over="ignore"):
                fits = (vertices.astype(np.float32) == vertices).all()
            scene = RayScene(dtype="float32" if fits else "float64")
            scene.add_triangles(vertices, self.mesh.faces)
            self._built = (hash(self.mesh), scene)
            self._planes = None
        return scene

    def _rays(self, origins, directions):
        origins, directions = (np.asanyarray(a, dtype=np.float64) for a in (origins, directions))
        if origins.shape != directions.shape or origins.shape[1:] != (3,):
            shapes = f"{origins.shape} and {directions.shape}"
            raise ValueError(f"ray_origins and ray_directions: expected two arrays of one shape (n, 3), not {shapes}")
        return origins, directions

    def _hits(self, origins, directions, multiple_hits, max_hits):
        """Rays, triangles and parameters of hits, those of a ray in order."""
        if not multiple_hits:
            hits = self._scene.intersect(origins, directions, threads=self._threads)
            rays = np.nonzero(hits.prim_id >= 0)[0]
            return rays, hits.prim_id[rays], hits.t[rays]
        hits = self._scene.all_hits(origins, directions, threads=self._threads)
        rays, faces, t = hits.ray_id, hits.prim_id, hits.t
        if len(rays) == 0:
            return rays, faces, t
        keep = self._once(rays, faces, t)
        rays, faces, t = rays[keep], faces[keep], t[keep]
        # The number of each hit along its ray.
        first = np.r_[True, rays[1:] != rays[:-1]]
        number = np.arange(len(rays)) - np.maximum.accumulate(np.where(first, np.arange(len(rays)), 0))
        keep = number < max_hits
        return rays[keep], faces[keep], t[keep]

    def _once(self, rays, faces, t):
        """False where a hit at the place of the one before is on a triangle that shares a corner with it."""
        keep = np.ones(len(rays), bool)
        # Parameters of float64 are off by 1e-13 of themselves.
        off = 4e-13 * t[1:] if t.dtype == np.float64 else 0.0
        same = np.r_[False, (rays[1:] == rays[:-1]) & (t[1:] - t[:-1] <= off)]
        if not same.any():
            return keep
        corners = self.mesh.triangles
        # How many at the same place are before each hit; those with few come first, as those after them ask which were kept.
        at = np.arange(len(rays))
        before = at - np.maximum.accumulate(np.where(same, 0, at))
        for number in range(1, before.max() + 1):
            ours = np.nonzero(before == number)[0]
            for back in range(1, number + 1):
                a, b = corners[faces[ours]], corners[faces[ours - back]]
                meet = (a[:, :, None] == b[:, None]).all(axis=3).any(axis=(1, 2))
                keep[ours[meet & keep[ours - back]]] = False
        return keep

    def _locations(self, origins, directions, rays, faces):
        """Where rays meet the planes of triangles, in double precision."""
        if self._planes is None:
            corners = self.mesh.triangles
            self._planes = corners[:, 0], np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        corner, normal = (of[faces] for of in self._planes)
        o, d = origins[rays], directions[rays]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.einsum("ij,ij->i", corner - o, normal) / np.einsum("ij,ij->i", d, normal)
        return o, d, t

    def intersects_location(self, ray_origins, ray_directions, multiple_hits=True, **_):
        """`(locations (m, 3), index_ray (m,), index_tri (m,))`."""
        tri, rays, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits=multiple_hits, return_locations=True
        )
        return locations, rays, tri

    def intersects_id(
        self, ray_origins, ray_directions, multiple_hits=True, max_hits=100, return_locations=False, **_
    ):
        """`(index_tri (m,), index_ray (m,))`, and `locations (m, 3)` if asked for."""
        origins, directions = self._rays(ray_origins, ray_directions)
        rays, faces, t = self._hits(origins, directions, multiple_hits, max_hits)
        rays, faces = rays.astype(np.int64), faces.astype(np.int64)
        if not return_locations:
            return faces, rays
        if t.dtype == np.float64:
            return faces, rays, origins[rays] + directions[rays] * t[:, None]
        o, d, exact = self._locations(origins, directions, rays, faces)
        t = np.where(np.isfinite(exact), exact, t)
        return faces, rays, (o + d * t[:, None]).reshape(-1, 3)

    def intersects_first(self, ray_origins, ray_directions, **_):
        """int (n,): the first triangle that each ray hits, -1 where it misses."""
        origins, directions = self._rays(ray_origins, ray_directions)
        return self._scene.intersect(origins, directions, threads=self._threads).prim_id.astype(np.int64)

    def intersects_any(self, ray_origins, ray_directions, **_):
        """bool (n,): whether each ray hits anything."""
        origins, directions = self._rays(ray_origins, ray_directions)
        return self._scene.occluded(origins, directions, threads=self._threads)

    def contains_points(self, points):
        """bool (n,): whether points are inside of a closed mesh."""
        points = np.asanyarray(points, dtype=np.float64)
        if points.shape[1:] != (3,):
            raise ValueError(f"points: expected shape (n, 3), not {points.shape}")
        return self._scene.contains(points, threads=self._threads)
