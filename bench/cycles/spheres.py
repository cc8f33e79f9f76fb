# SPDX-License-Identifier: GPL-3.0-or-later
"""How exact the hits of spheres are: distances and normals of libraries of Embree's names beside double precision.

    python spheres.py LIBRARY ...

600 spheres of radius 0.06, seen from six units away, as the points of judge.py are. Needs numpy. Errors of distances are in units in the
last place of a float.
"""
import ctypes
import random
import sys

import numpy

COUNT, RADIUS = 600, float(numpy.float32(0.06))


class RayHit(ctypes.Structure):
    _fields_ = [
        ("org", ctypes.c_float * 3),
        ("near", ctypes.c_float),
        ("dir", ctypes.c_float * 3),
        ("time", ctypes.c_float),
        ("far", ctypes.c_float),
        ("mask", ctypes.c_uint),
        ("id", ctypes.c_uint),
        ("flags", ctypes.c_uint),
        ("normal", ctypes.c_float * 3),
        ("u", ctypes.c_float),
        ("v", ctypes.c_float),
        ("prim", ctypes.c_uint),
        ("geom", ctypes.c_uint),
        ("instances", ctypes.c_uint * 2),
        ("pad", ctypes.c_uint * 16),
    ]


def scene_of(library, centres):
    for name in ("rtcNewDevice", "rtcNewGeometry", "rtcNewScene", "rtcSetNewGeometryBuffer"):
        getattr(library, name).restype = ctypes.c_void_p
    pointer, unsigned = ctypes.c_void_p, ctypes.c_uint
    device = pointer(library.rtcNewDevice(None))
    spheres = pointer(library.rtcNewGeometry(device, 50))  # RTC_GEOMETRY_TYPE_SPHERE_POINT
    size = ctypes.c_size_t
    # RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4
    at = library.rtcSetNewGeometryBuffer(spheres, unsigned(1), unsigned(0), unsigned(0x9004), size(16), size(COUNT))
    rows = numpy.ctypeslib.as_array(ctypes.cast(at, ctypes.POINTER(ctypes.c_float)), (COUNT, 4))
    rows[:, :3], rows[:, 3] = centres, RADIUS
    library.rtcCommitGeometry(spheres)
    scene = pointer(library.rtcNewScene(device))
    library.rtcSetSceneFlags(scene, 4)  # RTC_SCENE_FLAG_ROBUST, as Cycles asks
    library.rtcAttachGeometry(scene, spheres)
    library.rtcCommitScene(scene)
    return scene


def rays(count):
    pick = random.Random(1)
    for _ in range(count):
        to = (pick.uniform(-1, 1), 6 + pick.uniform(-1, 1), pick.uniform(0, 2) - 2.2)
        yield numpy.float32([0, -6, 2.2]), numpy.float32(to / numpy.linalg.norm(to))


def errors(library, centres):
    scene = scene_of(library, centres)
    room = ctypes.create_string_buffer(ctypes.sizeof(RayHit) + 64)
    ray = RayHit.from_address(ctypes.addressof(room) + -ctypes.addressof(room) % 64)
    off, turned = [], []
    for org, direction in rays(40000):
        ray.org[:], ray.dir[:] = org, direction
        ray.near, ray.far, ray.time, ray.mask, ray.flags = 0, float("inf"), 0, 0xFFFFFFFF, 0
        ray.geom = ray.instances[0] = ray.instances[1] = 0xFFFFFFFF
        library.rtcIntersect1(scene, ctypes.byref(ray), None)
        if ray.geom == 0xFFFFFFFF:
            continue
        centre, org, direction = centres[ray.prim].astype(float), org.astype(float), direction.astype(float)
        a, b = direction @ direction, (org - centre) @ direction
        square = b * b - a * ((org - centre) @ (org - centre) - RADIUS**2)
        if square <= 0:
            continue
        t = (-b - square**0.5) / a
        off.append((ray.far - t) / float(numpy.spacing(numpy.float32(t))))
        normal, exact = numpy.array(ray.normal, dtype=float), (org + t * direction - centre) / RADIUS
        turned.append(float(numpy.linalg.norm(normal / numpy.linalg.norm(normal) - exact)))
    return numpy.abs(off), numpy.array(turned)


def main():
    pick = random.Random(5)
    centres = numpy.float32([(pick.gauss(0, 0.6), pick.gauss(0, 0.6), 1 + pick.gauss(0, 0.5)) for _ in range(COUNT)])
    for file in sys.argv[1:]:
        off, turned = errors(ctypes.CDLL(file), centres)
        print(f"{file}: {len(off)} hits; distances: median {numpy.median(off):.2f}, 99 % {numpy.percentile(off, 99):.1f}, "
              f"most {off.max():.1f}; normals: median {numpy.median(turned):.1e}, most {turned.max():.1e}")


if __name__ == "__main__":
    main()
