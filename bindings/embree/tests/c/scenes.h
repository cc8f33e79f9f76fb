/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the programs have in common: a device, scenes of one geometry, single rays. */
#ifndef SCENES_H
#define SCENES_H
#include <gnurt/embree.h>

#include "check.h"

static RTCDevice device;

/* A committed scene of a geometry, which goes with it. */
MAYBE_UNUSED static RTCScene committed(RTCGeometry geometry)
{
    RTCScene scene = rtcNewScene(device);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

/* The same; the program keeps the geometry. */
MAYBE_UNUSED static RTCScene committed_with(RTCGeometry geometry)
{
    rtcRetainGeometry(geometry);
    return committed(geometry);
}

/* The nearest hit of a ray without an end. */
MAYBE_UNUSED static struct RTCRayHit shot_along(RTCScene scene, const float org[3], const float dir[3], float time)
{
    struct RTCRayHit all;
    memset(&all, 0, sizeof all);
    memcpy(&all.ray.org_x, org, 12);
    memcpy(&all.ray.dir_x, dir, 12);
    all.ray.tfar = INFINITY;
    all.ray.time = time;
    all.ray.mask = -1;
    all.hit.geomID = all.hit.primID = all.hit.instID[0] = all.hit.instPrimID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &all, NULL);
    return all;
}
#endif
