# SPDX-License-Identifier: GPL-3.0-or-later
"""A backend for MuJoCo-LiDAR: rays of a sensor at the geoms of a MuJoCo model, in trees that follow what moves."""

import numpy as np

from . import RayScene

__all__ = ["MjLidarGnurt", "install"]

#: Sides of what is round: surfaces are 0.06 % of their radius too far in at most.
_SIDES = 96


class MjLidarGnurt:
    """What `MjLidarCPU` does, by all threads.

    Planes are exact, height fields, boxes and meshes are as they are, what is round has 96 sides. As for `mj_ray`, planes are seen
    from above only, invisible geoms (alpha 0) and those of `bodyexclude` not at all, and of groups those with `geomgroup`.
    """

    def __init__(self, mj_model, cutoff_dist=100.0, geomgroup=None, bodyexclude=-1, threads=0):
        self.mj_model, self.cutoff_dist, self.threads = mj_model, float(cutoff_dist), threads
        self._scene, self._moving, self._planes = RayScene(), [], []
        self._data = self._distances = self._points = None
        # Meshes and height fields that the scene has already.
        known = {}
        for geom in range(mj_model.ngeom):
            if not _is_seen(mj_model, geom, geomgroup, bodyexclude):
                continue
            kind = int(mj_model.geom_type[geom])
            if kind == 0:
                self._planes.append(geom)
                continue
            key = (kind, int(mj_model.geom_dataid[geom])) if kind in (1, 7, 8) else None
            if key in known:
                self._moving.append((geom, {"inst_id": self._scene.add_instance(known[key], np.eye(4))}))
                continue
            vertices, faces = _shape(mj_model, geom, kind)
            if len(faces) == 0:
                continue
            number = self._scene.add_triangles(vertices, faces, transform=np.eye(4))
            self._moving.append((geom, {"geom_id": number}))
            if key is not None:
                known[key] = number

    def update(self, mj_data):
        """Takes the places of all geoms."""
        place = np.eye(4)
        for geom, number in self._moving:
            place[:3, :3] = mj_data.geom_xmat[geom].reshape(3, 3)
            place[:3, 3] = mj_data.geom_xpos[geom]
            self._scene.update(**number, transform=place)
        self._data = mj_data

    def trace_rays(self, pose_4x4, ray_theta, ray_phi):
        """Rays of a sensor at a place: azimuths and elevations in radians."""
        theta, phi = np.asarray(ray_theta, float), np.asarray(ray_phi, float)
        if theta.shape != phi.shape:
            raise ValueError(f"ray_phi and ray_theta must have the same shape, not {phi.shape} and {theta.shape}")
        if self._data is None:
            raise RuntimeError("update() comes first: it says where geoms are")
        pose = np.asarray(pose_4x4, float)
        local = np.stack((np.cos(phi) * np.cos(theta), np.cos(phi) * np.sin(theta), np.sin(phi)), -1)
        origin, directions = pose[:3, 3], local @ pose[:3, :3].T
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        hits = self._scene.intersect(origin[None], directions, 0.0, self.cutoff_dist, threads=self.threads)
        distances = hits.t.astype(float)
        for geom in self._planes:
            turn, middle = self._data.geom_xmat[geom].reshape(3, 3), self._data.geom_xpos[geom]
            distances = np.minimum(distances, _to_plane(turn, middle, self.mj_model.geom_size[geom], origin, directions))
        self._distances = np.where(distances <= self.cutoff_dist, distances, -1.0)
        self._points = local * np.maximum(self._distances, 0)[:, None]

    def get_hit_points(self):
        """Where they hit, in the sensor's space; its origin where they missed."""
        return self._points

    def get_distances(self):
        """How far that is; -1 where they missed."""
        return self._distances


def install():
    """Makes MuJoCo-LiDAR's backend "cpu" this one."""
    from mujoco_lidar.core_cpu import mjlidar_cpu

    mjlidar_cpu.MjLidarCPU = MjLidarGnurt


def _is_seen(model, geom, geomgroup, bodyexclude):
    material = int(model.geom_matid[geom])
    alpha = model.geom_rgba[geom][3] if material < 0 else model.mat_rgba[material][3]
    if alpha == 0 or model.geom_bodyid[geom] == bodyexclude:
        return False
    return geomgroup is None or bool(geomgroup[min(max(int(model.geom_group[geom]), 0), 5)])


def _to_plane(turn, middle, size, origin, directions):
    """Distances to a plane's upper side; infinity beyond its edges."""
    start, ways = (origin - middle) @ turn, directions @ turn
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -start[2] / ways[:, 2]
        places = start[:2] + t[:, None] * ways[:, :2]
    is_hit = (ways[:, 2] < 0) & (t >= 0)
    for k in (0, 1):
        if size[k] > 0:
            is_hit &= np.abs(places[:, k]) <= size[k]
    return np.where(is_hit, t, np.inf)


def _shape(model, geom, kind):
    """Triangles of a geom in its own space."""
    size = np.asarray(model.geom_size[geom], float)
    if kind == 1:
        return _field(model, int(model.geom_dataid[geom]))
    if kind in (7, 8):
        mesh = int(model.geom_dataid[geom])
        if mesh < 0:
            return np.zeros((0, 3)), np.zeros((0, 3), int)
        vertex, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
        vertices = model.mesh_vert[vertex : vertex + int(model.mesh_vertnum[mesh])]
        return np.array(vertices, float), np.array(model.mesh_face[face : face + int(model.mesh_facenum[mesh])], int)
    if kind == 6:
        corners = size * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        return corners, np.array([[a, b, c] for s in sides for a, b, c in ((s[0], s[1], s[2]), (s[0], s[2], s[3]))])
    rise = np.linspace(-np.pi / 2, np.pi / 2, _SIDES // 2 + 1)
    if kind == 2:
        profile = size[0] * np.stack((np.cos(rise), np.sin(rise)), 1)
    elif kind == 3:
        # An even number of steps: the equator is at both ends of the straight part.
        half = len(rise) // 2
        lift = np.concatenate((np.full(half + 1, -size[1]), np.full(half + 1, size[1])))
        rise = np.concatenate((rise[: half + 1], rise[half:]))
        profile = np.stack((size[0] * np.cos(rise), size[0] * np.sin(rise) + lift), 1)
    elif kind == 4:
        vertices, faces = _lathe(np.stack((np.cos(rise), np.sin(rise)), 1))
        return vertices * size, faces
    elif kind == 5:
        profile = np.array([[0, -size[1]], [size[0], -size[1]], [size[0], size[1]], [0, size[1]]])
    else:
        raise ValueError(f"geom {geom} is of type {kind}, which is not known here")
    return _lathe(profile)


def _lathe(profile):
    """What a line of radii and heights sweeps around z."""
    turn = np.arange(_SIDES) * (2 * np.pi / _SIDES)
    ring = np.stack((np.cos(turn), np.sin(turn)), 1)
    vertices = np.concatenate([np.column_stack((r * ring, np.full(_SIDES, z))) for r, z in profile])
    i, j = np.meshgrid(np.arange(len(profile) - 1), np.arange(_SIDES), indexing="ij")
    a, b = i * _SIDES + j, i * _SIDES + (j + 1) % _SIDES
    faces = np.stack((a, b, b + _SIDES, a, b + _SIDES, a + _SIDES), -1).reshape(-1, 3)
    # Those that end in a pole have no area.
    return vertices, faces[_areas(vertices, faces) > 0]


def _areas(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _field(model, field):
    """A height field: its surface, and the box below it."""
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    x, y, top, base = (float(s) for s in model.hfield_size[field])
    start = int(model.hfield_adr[field])
    heights = top * np.array(model.hfield_data[start : start + rows * columns], float)
    v, u = np.meshgrid(np.linspace(-y, y, rows), np.linspace(-x, x, columns), indexing="ij")
    surface = np.column_stack((u.ravel(), v.ravel(), heights))
    floor = np.column_stack((u.ravel(), v.ravel(), np.full(rows * columns, -base)))
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    upper = np.stack((a, b, c, a, c, d), -1).reshape(-1, 3)
    below = rows * columns
    rim = np.concatenate((number[0, :], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]))
    after = np.roll(rim, -1)
    sides = np.concatenate((np.stack((rim, below + rim, below + after), 1), np.stack((rim, below + after, after), 1)))
    e, f, g, h = (below + number[k] for k in ((0, 0), (0, -1), (-1, -1), (-1, 0)))
    return np.concatenate((surface, floor)), np.concatenate((upper, sides, [[e, g, f], [e, h, g]]))
