# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's hair: 100,000 strands on a head, by the Python package. Usage: python hair.py PICTURE [SAMPLES]

Strands begin on an egg, fall along it, and gather in locks. Their colour is that of melanin by Chiang's model [CBTB16].
"""

import sys

import gnurt
import numpy as np

STRANDS, POINTS, SIZE = 100_000, 28, 480
HEAD = np.array([0.78, 1.0, 0.9])

HAIR = """
surface hair(float eumelanin = 0.55, float pheomelanin = 0.25) {
    color absorbed = eumelanin * color(0.419, 0.697, 1.37) + pheomelanin * color(0.187, 0.4, 1.05);
    Ci = chiang_hair_bsdf(N, dPdu, color(1), color(1), color(1), 1.55, 0.05, 0.0125, 0.2, 0.19, 0.19, 0.19, 0.51, absorbed);
}
"""


def roots(rng):
    """Places on the scalp: the upper and rear part of the head."""
    found = np.empty((0, 3))
    while len(found) < STRANDS:
        p = rng.normal(size=(STRANDS, 3))
        p /= np.linalg.norm(p, axis=1, keepdims=True)
        forehead = 0.32 + 0.75 * np.clip(p[:, 2], 0, 1) - 0.5 * np.clip(-p[:, 2], 0, 1)
        found = np.concatenate([found, p[p[:, 1] > forehead]])
    return found[:STRANDS]


def strands(rng):
    """Points of all strands, (STRANDS, POINTS, 3)."""
    way = roots(rng)
    place = way * HEAD
    normal = way / HEAD
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # Locks: strands nearest to one of some thousand guides lean towards it.
    guides = rng.choice(STRANDS, 900, replace=False)
    near = np.concatenate([np.argmax(part @ way[guides].T, axis=1) for part in np.array_split(way, 50)])
    part = np.sign(way[:, :1] + 0.12)
    direction = normal + 0.35 * part * np.array([1.0, 0, 0]) + 0.08 * rng.normal(size=way.shape)
    phase = rng.uniform(0, 2 * np.pi, len(guides))[near]
    length = (2.1 + 0.25 * rng.normal(size=len(guides))[near] + 0.1 * rng.normal(size=STRANDS)) / POINTS
    points = [place]
    for step in range(1, POINTS):
        wave = 0.16 * np.sin(0.55 * step + phase)[:, None] * np.cross(normal, [0, 1.0, 0]) + 0.02 * rng.normal(size=way.shape)
        direction = direction + np.array([0, -0.22, 0]) + wave
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        place = place + direction * length[:, None]
        place += 0.035 * (place[guides][near] - place) * min(step / 8, 1)
        # Hair lies on the head, and on itself: the outer strands farther out.
        out = np.linalg.norm(place / HEAD, axis=1, keepdims=True)
        least = 1.02 + 0.12 * rng.random((STRANDS, 1)) * min(step / 10, 1)
        place = np.where(out < least, place * (least / out), place)
        points.append(place)
    return np.stack(points, axis=1)


def main():
    rng = np.random.default_rng(7)
    points = strands(rng).astype(np.float32)
    radii = np.linspace(0.0016, 0.0006, POINTS, dtype=np.float32)
    scene = gnurt.Scene()
    hair = scene.add_material("hair", shader=HAIR)
    scene.add_curves(
        points.reshape(-1, 3), np.tile(radii, STRANDS), counts=np.full(STRANDS, POINTS), basis="catmull-rom", form="round", material=hair
    )
    skin = scene.add_material("head", color=(0.55, 0.38, 0.3), roughness=0.6)
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 97), np.linspace(0, np.pi, 49))
    ball = np.stack([np.sin(v) * np.cos(u), np.cos(v), np.sin(v) * np.sin(u)], axis=-1) * HEAD
    corner = (np.arange(48)[:, None] * 97 + np.arange(96)).reshape(-1)
    faces = np.concatenate([np.stack([corner, corner + 1, corner + 98], 1), np.stack([corner, corner + 98, corner + 97], 1)])
    scene.add_mesh(ball.reshape(-1, 3), faces, normals=(ball / HEAD**2).reshape(-1, 3), material=skin)
    wall = scene.add_material("wall", color=(0.23, 0.25, 0.29), roughness=0.9)
    scene.add_mesh([[-30, -20, 6], [-30, 20, 6], [30, 20, 6], [30, -20, 6]], [[0, 1, 2], [0, 2, 3]], material=wall)
    for corner, right, up, light in (
        ((2.5, 2.0, -4.5), (1.6, 0, 1.2), (0, 2.2, 0), 14.0),
        ((-5.5, -0.5, -2.5), (1.4, 0, -2.2), (0, 2.6, 0), 3.0),
        ((-2.0, 3.4, 3.0), (3.5, 0, 0), (0, 0.9, -1.2), 5.0),
    ):
        lamp = scene.add_material("lamp", color=(0, 0, 0), emission=(light, 0.95 * light, 0.88 * light))
        a, b, c = np.array(corner), np.array(right), np.array(up)
        if np.cross(b, c) @ a > 0:
            # Lamps shine to their front, which is to look at the head.
            a, b = a + b, -b
        scene.add_mesh([a, a + b, a + b + c, a + c], [[0, 1, 2], [0, 2, 3]], material=lamp)
    scene.add_camera(gnurt.Camera((-1.6, 0.5, -6.4), (0.0, -0.3, 0), fov=32))
    samples = int(sys.argv[2]) if len(sys.argv) > 2 else 64
    scene.render(SIZE, SIZE, spp=samples).save(sys.argv[1])


if __name__ == "__main__":
    main()
