/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene that shows another, which was committed anew, with other arrays, and whose old arrays are gone. */
#include <gnurt/embree.h>

#include "check.h"

static RTCDevice device;

static float (*corners(float slope))[3]
{
    float(*p)[3] = malloc(4 * sizeof *p);
    float at[4][3] = { { -1, -1, -slope }, { 1, -1, slope }, { 1, 1, slope }, { -1, 1, -slope } };
    memcpy(p, at, sizeof at);
    return p;
}

static struct RTCRayHit down(RTCScene scene)
{
    struct RTCRayHit r;
    memset(&r, 0, sizeof r);
    r.ray.org_x = 0.25f, r.ray.org_z = 9, r.ray.dir_z = -1, r.ray.tfar = INFINITY, r.ray.mask = -1;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &r, NULL);
    return r;
}

int main(void)
{
    static const unsigned quad[4] = { 0, 1, 2, 3 };
    device = rtcNewDevice("threads=1");
    RTCScene child = rtcNewScene(device), middle = rtcNewScene(device), parent = rtcNewScene(device);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD), instance[2];
    float(*old)[3] = corners(0);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, old, 0, 12, 4);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quad, 0, 16, 1);
    rtcCommitGeometry(mesh);
    rtcAttachGeometryByID(child, mesh, 5);
    rtcCommitScene(child);
    RTCScene shows[3] = { child, middle, parent };
    for (int i = 0; i < 2; i++) {
        instance[i] = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance[i], shows[i]);
        rtcCommitGeometry(instance[i]);
        rtcAttachGeometry(shows[i + 1], instance[i]);
        rtcCommitScene(shows[i + 1]);
        CHECK(down(shows[i + 1]).hit.Ng_z == 4, "a flat floor");
    }
    float(*new)[3] = corners(1);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, new, 0, 12, 4);
    rtcCommitGeometry(mesh);
    rtcCommitScene(child);
    memset(old, 0xff, 4 * sizeof *old);
    free(old);
    for (int i = 1; i < 3; i++) {
        struct RTCRayHit r = down(shows[i]);
        CHECK(r.hit.geomID == 5 && r.hit.Ng_x == -4 && r.hit.Ng_z == 4, "level %d: a normal of the new floor: %g, %g", i,
              r.hit.Ng_x, r.hit.Ng_z);
    }
    rtcDetachGeometry(child, 5);
    rtcCommitScene(child);
    memset(new, 0xff, 4 * sizeof *new);
    for (int i = 1; i < 3; i++)
        CHECK(down(shows[i]).hit.Ng_z == 0, "level %d: the floor is gone, and its normal with it", i);
    free(new);
    rtcCommitScene(middle);
    CHECK(down(middle).hit.geomID == RTC_INVALID_GEOMETRY_ID, "committed, its parent sees it, too");
    CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE, "no error");
    rtcReleaseGeometry(mesh);
    for (int i = 0; i < 2; i++)
        rtcReleaseGeometry(instance[i]);
    for (int i = 0; i < 3; i++)
        rtcReleaseScene(shows[i]);
    rtcReleaseDevice(device);
    return finish();
}
