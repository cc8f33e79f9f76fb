# SPDX-License-Identifier: GPL-3.0-or-later
"""The names of `open3d.t.geometry.RaycastingScene`, numpy in and out; Open3D itself is not needed."""

import numpy as np

from . import RayScene

__all__ = ["RaycastingScene"]


def _floats(name, values, width):
    values = np.asarray(values)
    if values.dtype != np.float32:
        raise ValueError(f"{name}: expected float32, not {values.dtype}")
    if values.ndim < 1 or values.shape[-1] != width:
        raise ValueError(f"{name}: expected shape (.., {width}), not {values.shape}")
    return values.reshape(-1, width), values.shape[:-1]


class RaycastingScene:
    """Meshes to be asked with rays `(.., 6)`, origin and direction, and points `(.., 3)`."""

    INVALID_ID = 4294967295

    def __init__(self, nthreads=0, device=None):
        self._scene = RayScene()
        self._threads = nthreads

    def _asked(self, nthreads):
        return {"threads": nthreads or self._threads}

    def add_triangles(self, vertex_positions, triangle_indices=None):
        """The mesh's number. Takes a mesh of Open3D's tensor kind or its legacy kind, too."""
        if triangle_indices is None:
            mesh = vertex_positions
            if hasattr(mesh, "vertex"):
                vertex_positions, triangle_indices = mesh.vertex.positions.numpy(), mesh.triangle.indices.numpy()
            else:
                vertex_positions, triangle_indices = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
        return self._scene.add_triangles(vertex_positions, triangle_indices)

    def cast_rays(self, rays, nthreads=0):
        """The first hit of each ray."""
        rays, shape = _floats("rays", rays, 6)
        hits = self._scene.intersect(rays[:, :3], rays[:, 3:], **self._asked(nthreads))
        return {
            "t_hit": hits.t.reshape(shape),
            "geometry_ids": hits.geom_id.view(np.uint32).reshape(shape),
            "primitive_ids": hits.prim_id.view(np.uint32).reshape(shape),
            "primitive_uvs": np.stack([hits.u, hits.v], axis=-1).reshape(*shape, 2),
            "primitive_normals": hits.normal.reshape(*shape, 3),
        }

    def test_occlusions(self, rays, tnear=0.0, tfar=float("inf"), nthreads=0):
        """Whether each ray hits anything."""
        rays, shape = _floats("rays", rays, 6)
        return self._scene.occluded(rays[:, :3], rays[:, 3:], tnear, tfar, **self._asked(nthreads)).reshape(shape)

    def count_intersections(self, rays, nthreads=0):
        """How often each ray crosses surfaces: an edge that triangles share is crossed once."""
        rays, shape = _floats("rays", rays, 6)
        return self._scene.crossings(rays[:, :3], rays[:, 3:], **self._asked(nthreads)).reshape(shape)

    def list_intersections(self, rays, nthreads=0):
        """What `count_intersections` counts, in order."""
        rays, _ = _floats("rays", rays, 6)
        hits = self._scene.crossing_hits(rays[:, :3], rays[:, 3:], **self._asked(nthreads))
        return {
            "ray_splits": hits.splits.astype(np.uint32),
            "ray_ids": hits.ray_id.astype(np.uint32),
            "t_hit": hits.t,
            "geometry_ids": hits.geom_id.view(np.uint32),
            "primitive_ids": hits.prim_id.view(np.uint32),
            "primitive_uvs": np.stack([hits.u, hits.v], axis=-1),
        }

    def compute_closest_points(self, query_points, nthreads=0):
        """The nearest point of any surface."""
        points, shape = _floats("query_points", query_points, 3)
        at, _, prims, geoms, uvs, normals = self._scene._nearest(points, **self._asked(nthreads))
        return {
            "points": at.astype(np.float32).reshape(*shape, 3),
            "geometry_ids": geoms.view(np.uint32).reshape(shape),
            "primitive_ids": prims.view(np.uint32).reshape(shape),
            "primitive_uvs": uvs.reshape(*shape, 2),
            "primitive_normals": normals.reshape(*shape, 3),
        }

    def compute_distance(self, query_points, nthreads=0):
        """Distance to the nearest surface."""
        points, shape = _floats("query_points", query_points, 3)
        return self._scene.distance(points, **self._asked(nthreads)).astype(np.float32).reshape(shape)

    def compute_signed_distance(self, query_points, nthreads=0, nsamples=1):
        """The same, negative inside. One sample is exact: `nsamples` must be odd, and changes nothing."""
        points, shape = self._odd(query_points, nsamples)
        return self._scene.signed_distance(points, **self._asked(nthreads)).astype(np.float32).reshape(shape)

    def compute_occupancy(self, query_points, nthreads=0, nsamples=1):
        """1 inside, 0 outside."""
        points, shape = self._odd(query_points, nsamples)
        return self._scene.contains(points, **self._asked(nthreads)).astype(np.float32).reshape(shape)

    @staticmethod
    def _odd(query_points, nsamples):
        if nsamples < 1 or nsamples % 2 == 0:
            raise RuntimeError(f"nsamples: expected an odd number, not {nsamples}")
        return _floats("query_points", query_points, 3)

    @staticmethod
    def create_rays_pinhole(*args, **kwargs):
        """float32 `(height, width, 6)` through pixel centres: from matrices (intrinsic, extrinsic), or from
        (fov_deg, center, eye, up), with width_px and height_px last. As in Open3D rows go up in the second form: the first pixel
        is that of the lower right corner of what the eye sees."""
        names = ("fov_deg", "center", "eye", "up", "width_px", "height_px")
        if len(args) == 6 or "fov_deg" in kwargs:
            given = dict(zip(names, args), **kwargs)
            width, height = given["width_px"], given["height_px"]
            eye, center, up = (np.asarray(given[k], float) for k in ("eye", "center", "up"))
            forward = (center - eye) / np.linalg.norm(center - eye)
            left = np.cross(up, forward)
            left /= np.linalg.norm(left)
            rotation = np.stack([left, np.cross(forward, left), forward])
            focal = 0.5 * width / np.tan(0.5 * np.deg2rad(given["fov_deg"]))
            intrinsic = np.array([[focal, 0, 0.5 * width], [0, focal, 0.5 * height], [0, 0, 1]])
        else:
            names = ("intrinsic_matrix", "extrinsic_matrix", "width_px", "height_px")
            given = dict(zip(names, args), **kwargs)
            width, height = given["width_px"], given["height_px"]
            intrinsic, extrinsic = (np.asarray(given[k], float) for k in names[:2])
            rotation = extrinsic[:3, :3]
            eye = -rotation.T @ extrinsic[:3, 3]
        y, x = np.mgrid[0:height, 0:width] + 0.5
        pixels = np.stack([x, y, np.ones_like(x)], axis=-1)
        directions = pixels @ np.linalg.inv(intrinsic).T @ rotation
        return np.concatenate([np.broadcast_to(eye, directions.shape), directions], axis=-1).astype(np.float32)
