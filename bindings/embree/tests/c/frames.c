/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What callbacks get: packets as wide as the call's, in memory as the header has it; and what they may change. */
#include <gnurt/embree.h>

#include <stdalign.h>
#include <stdint.h>

#include "scenes.h"

#define LAYOUT(type, size, alignment)                                                                                 \
    _Static_assert(sizeof(struct type) == size && alignof(struct type) == alignment, #type)
LAYOUT(RTCRay, 48, 16);
LAYOUT(RTCHit, 48, 16);
LAYOUT(RTCRayHit, 96, 16);
LAYOUT(RTCHit4, 144, 16);
LAYOUT(RTCRayHit4, 336, 16);
LAYOUT(RTCHit8, 288, 32);
LAYOUT(RTCRayHit8, 672, 32);
LAYOUT(RTCHit16, 576, 64);
LAYOUT(RTCRayHit16, 1344, 64);
LAYOUT(RTCRayQueryContext, 8, 4);
LAYOUT(RTCIntersectArguments, 32, 8);
LAYOUT(RTCFilterFunctionNArguments, 48, 8);
LAYOUT(RTCIntersectFunctionNArguments, 48, 8);
LAYOUT(RTCBounds, 32, 16);
LAYOUT(RTCBoundsFunctionArguments, 24, 8);
LAYOUT(RTCPointQuery, 32, 16);
LAYOUT(RTCPointQueryContext, 144, 16);
LAYOUT(RTCPointQueryFunctionArguments, 48, 16);
LAYOUT(RTCInterpolateArguments, 88, 8);


static struct RTCRayHit ray(float x, float y, float z)
{
    struct RTCRayHit r;
    memset(&r, 0, sizeof r);
    r.ray.org_x = x, r.ray.org_y = y, r.ray.org_z = z;
    r.ray.dir_z = 1, r.ray.tfar = INFINITY, r.ray.mask = -1;
    r.hit.geomID = r.hit.primID = r.hit.instID[0] = r.hit.instPrimID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

/* Floors at heights 1, 2, ..., each as large as the one before. */
static RTCGeometry floors(int count)
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float(*p)[3] = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count);
    unsigned *indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count);
    for (int i = 0; i < 3 * count; i++) {
        p[i][0] = i % 3 == 1 ? 90 : -30, p[i][1] = i % 3 == 2 ? 90 : -30, p[i][2] = 1 + i / 3;
        indices[i] = i;
    }
    return mesh;
}

/* Rows of a packet of N. */
static float *row(void *packet, unsigned row, unsigned n, unsigned lane)
{
    return (float *)packet + row * n + lane;
}
enum { TFAR = 8, MASK = 9, ID = 10, NG = 12, PRIM = 17, GEOM = 18 };

/* What the call under way has; a ray's id is its lane, and its mask 2 + lane. */
static unsigned width, calls;

/* Whether filters see the program's own packet: not from user geometry. */
static int is_own;

/* The lane that counts. All of the packet is read, as by programs that work on all lanes at once. */
static unsigned lane_of(const int *valid, unsigned n, void *rays, int has_rays_of_others)
{
    unsigned lane = n, sum = 0;
    CHECK(n == width, "N is %u, not %u", n, width);
    CHECK((uintptr_t)valid % (n == 1 ? 4 : 4 * n) == 0 && (uintptr_t)rays % (n == 1 ? 16 : 4 * n) == 0, "aligned for %u lanes", n);
    for (unsigned i = 0; i < n; i++) {
        sum += valid[i] != 0;
        if (valid[i])
            lane = i;
    }
    CHECK(sum == 1, "%u lanes count", sum);
    CHECK(*(unsigned *)row(rays, ID, n, lane) == lane && *(unsigned *)row(rays, MASK, n, lane) == 2 + lane, "lane %u is in its place", lane);
    for (unsigned i = 0; i < n && has_rays_of_others; i++)
        CHECK(*(unsigned *)row(rays, ID, n, i) == i, "lane %u is that of the program", i);
    calls++;
    return lane;
}

/* Lets floors pass from that on which has the number of the lane. */
static void from_own_floor(const struct RTCFilterFunctionNArguments *args)
{
    unsigned n = args->N, lane = lane_of(args->valid, n, args->ray, is_own);
    CHECK((uintptr_t)args->hit % (n == 1 ? 16 : 4 * n) == 0, "the hit is aligned");
    float *hits = (float *)args->hit - NG * n;
    unsigned prim = *(unsigned *)row(hits, PRIM, n, lane);
    CHECK(*row(args->ray, TFAR, n, lane) == prim + 1, "the distance of floor %u", prim);
    for (unsigned k = 0, i; k < 9; k++)
        for (i = 0; i < n; i++)
            *row(args->hit, k, n, i) += 0;
    if (prim < lane)
        args->valid[lane] = 0;
    else
        *row(hits, NG, n, lane) = 100 + prim;
}

static void user_bounds(const struct RTCBoundsFunctionArguments *args)
{
    struct RTCBounds out = { -30, -30, 0, 0, 90, 90, 20, 0 };
    *args->bounds_o = out;
}

static void user_intersect(const struct RTCIntersectFunctionNArguments *args)
{
    unsigned n = args->N, lane = lane_of(args->valid, n, args->rayhit, 0);
    float t = 1 + lane;
    for (unsigned i = 0; i < n; i++)
        if (args->valid[i] && t < *row(args->rayhit, TFAR, n, i)) {
            *row(args->rayhit, TFAR, n, i) = t;
            *row(args->rayhit, NG, n, i) = 100 + lane;
            *(unsigned *)row(args->rayhit, PRIM, n, i) = lane;
            *(unsigned *)row(args->rayhit, GEOM, n, i) = args->geomID;
        }
}

static void user_occluded(const struct RTCOccludedFunctionNArguments *args)
{
    unsigned n = args->N, lane = lane_of(args->valid, n, args->ray, 0);
    *row(args->ray, TFAR, n, lane) = -INFINITY;
}

/* Sends rays on into the floors, in packets. */
static RTCScene shown;
static void window_intersect(const struct RTCIntersectFunctionNArguments *args)
{
    unsigned n = args->N;
    lane_of(args->valid, n, args->rayhit, 0);
    if (n == 1) {
        struct RTCRay r = *(struct RTCRay *)args->rayhit;
        rtcForwardIntersect1(args, shown, &r, 6);
    } else if (n == 4) {
        struct RTCRay4 r = *(struct RTCRay4 *)args->rayhit;
        rtcForwardIntersect4(args->valid, args, shown, &r, 6);
    } else if (n == 8) {
        struct RTCRay8 r = *(struct RTCRay8 *)args->rayhit;
        rtcForwardIntersect8(args->valid, args, shown, &r, 6);
    } else {
        struct RTCRay16 r = *(struct RTCRay16 *)args->rayhit;
        rtcForwardIntersect16Ex(args->valid, args, shown, &r, 6, 5);
    }
}

static void window_occluded(const struct RTCOccludedFunctionNArguments *args)
{
    unsigned n = args->N;
    lane_of(args->valid, n, args->ray, 0);
    if (n == 1) {
        struct RTCRay r = *(struct RTCRay *)args->ray;
        rtcForwardOccluded1(args, shown, &r, 6);
    } else if (n == 4) {
        struct RTCRay4 r = *(struct RTCRay4 *)args->ray;
        rtcForwardOccluded4(args->valid, args, shown, &r, 6);
    } else if (n == 8) {
        struct RTCRay8 r = *(struct RTCRay8 *)args->ray;
        rtcForwardOccluded8(args->valid, args, shown, &r, 6);
    } else {
        struct RTCRay16 r = *(struct RTCRay16 *)args->ray;
        rtcForwardOccluded16(args->valid, args, shown, &r, 6);
    }
}

static RTCScene user(RTCIntersectFunctionN intersect, RTCOccludedFunctionN occluded)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, 1);
    rtcSetGeometryBoundsFunction(geometry, user_bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occluded);
    rtcSetGeometryMask(geometry, -1);
    return committed(geometry);
}

#define PACKETS(n)                                                                                                    \
    for (int kind = 0; kind < 3; kind++) {                                                                            \
        struct RTCRayHit##n packet;                                                                                   \
        int valid[n] __attribute__((aligned(64)));                                                                    \
        for (unsigned i = 0; i < n; i++) {                                                                            \
            packet.ray.org_x[i] = packet.ray.org_y[i] = packet.ray.org_z[i] = packet.ray.tnear[i] = 0;                \
            packet.ray.dir_x[i] = packet.ray.dir_y[i] = packet.ray.time[i] = 0, packet.ray.dir_z[i] = 1;              \
            packet.ray.tfar[i] = INFINITY, packet.ray.mask[i] = 2 + i, packet.ray.id[i] = i, packet.ray.flags[i] = 0; \
            packet.hit.geomID[i] = packet.hit.instID[0][i] = packet.hit.instPrimID[0][i] = -1;                        \
            valid[i] = i == 2 ? 0 : -1;                                                                               \
        }                                                                                                             \
        struct RTCRay##n shadows = packet.ray;                                                                        \
        width = n, calls = 0, is_own = kind == 0;                                                                                         \
        rtcIntersect##n(valid, scenes[kind], &packet, NULL);                                                          \
        rtcOccluded##n(valid, scenes[kind], &shadows, NULL);                                                          \
        CHECK(calls >= 2u * (n - 1), "%d: %u calls for %d rays", kind, calls, n);                                      \
        for (unsigned i = 0; i < n; i++) {                                                                            \
            int hit = valid[i] != 0;                                                                                  \
            CHECK((packet.hit.geomID[i] == 0) == hit && (shadows.tfar[i] < 0) == hit, "%d: lane %u of " #n, kind, i); \
            CHECK(!hit || packet.ray.tfar[i] == 1 + i, "%d: lane %u of " #n " at %g", kind, i, packet.ray.tfar[i]);   \
            CHECK(!hit || (packet.hit.Ng_x[i] == 100 + i && packet.hit.primID[i] == i), "%d: hit %u of " #n, kind, i); \
            CHECK(!hit || packet.hit.instID[0][i] == (kind == 2 ? 6 : -1u), "%d: instance %u", kind, packet.hit.instID[0][i]); \
            CHECK(packet.ray.id[i] == i && shadows.id[i] == i && shadows.org_z[i] == 0, "rays are as they were");     \
        }                                                                                                             \
        if (n == 16 && kind == 2)                                                                                     \
            CHECK(packet.hit.instPrimID[0][3] == 5, "a place in an array: %u", packet.hit.instPrimID[0][3]);          \
    }

static void packets(void)
{
    for (int property = 32; property < 35; property++)
        CHECK(rtcGetDeviceProperty(device, (enum RTCDeviceProperty)property) == 1, "packets keep their size: property %d", property);
    RTCGeometry mesh = floors(16);
    rtcSetGeometryIntersectFilterFunction(mesh, from_own_floor);
    rtcSetGeometryOccludedFilterFunction(mesh, from_own_floor);
    rtcSetGeometryMask(mesh, -1);
    shown = committed(mesh);
    RTCScene scenes[3] = { shown, user(user_intersect, user_occluded), user(window_intersect, window_occluded) };
    PACKETS(4)
    PACKETS(8)
    PACKETS(16)
    for (int kind = 0; kind < 3; kind++) {
        struct RTCRayHit r = ray(0, 0, 0);
        r.ray.mask = 2;
        struct RTCRay shadow = r.ray;
        width = 1, is_own = 0;
        rtcIntersect1(scenes[kind], &r, NULL);
        rtcOccluded1(scenes[kind], &shadow, NULL);
        CHECK(r.ray.tfar == 1 && r.hit.Ng_x == 100 && shadow.tfar < 0, "%d: alone: %g, %g", kind, r.ray.tfar, r.hit.Ng_x);
    }
    CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE, "%s", rtcGetDeviceLastErrorMessage(device));
    for (int kind = 2; kind >= 0; kind--)
        rtcReleaseScene(scenes[kind]);
}

/* Takes a copy of all of the hit, as compilers may: by moves of sixteen bytes. */
static struct RTCHit copied;
static __attribute__((optimize("O2"))) void copies(const struct RTCFilterFunctionNArguments *args)
{
    CHECK((uintptr_t)args->hit % 16 == 0, "the hit is at a multiple of 16");
    copied = *(struct RTCHit *)args->hit;
    struct RTCHit back = copied;
    back.u = 0.125f;
    *(struct RTCHit *)args->hit = back;
}

static void copies_of_hits(void)
{
    RTCGeometry mesh = floors(1);
    rtcSetGeometryIntersectFilterFunction(mesh, copies);
    RTCScene scene = committed(mesh);
    for (int i = 0; i < 10; i++) {
        struct RTCRayHit r = ray(i, i, 0);
        r.ray.mask = 1;
        rtcIntersect1(scene, &r, NULL);
        CHECK(r.hit.u == 0.125f && copied.geomID == 0 && copied.instPrimID[0] == RTC_INVALID_GEOMETRY_ID, "a copy: %g", r.hit.u);
    }
    rtcReleaseScene(scene);
}

/* Numbers of an earlier hit do not stay. */
static bool look(struct RTCPointQueryFunctionArguments *args)
{
    unsigned *found = args->userPtr;
    found[args->context->instID[0] == 3] = args->context->instPrimID[0];
    return false;
}

static void numbers_of_instances(void)
{
    RTCScene floor = committed(floors(1)), scene = rtcNewScene(device);
    RTCGeometry array = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE_ARRAY), one = floors(1);
    rtcSetGeometryInstancedScene(array, floor);
    float(*places)[12] = rtcSetNewGeometryBuffer(array, RTC_BUFFER_TYPE_TRANSFORM, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                                                 sizeof(float[12]), 8);
    for (int i = 0; i < 8; i++) {
        float place[12] = { 1, 0, 0, 200 * (i + 1), 0, 1, 0, 0, 0, 0, 1, 0 };
        memcpy(places[i], place, sizeof place);
    }
    rtcCommitGeometry(array);
    rtcCommitGeometry(one);
    rtcAttachGeometryByID(scene, array, 3);
    rtcAttachGeometryByID(scene, one, 1);
    rtcReleaseGeometry(array);
    rtcReleaseGeometry(one);
    rtcCommitScene(scene);
    struct RTCRayHit r = ray(1600, 0, 0);
    for (int i = 0; i < 4; i++) {
        RTCScene asked[4] = { scene, scene, scene, floor };
        r.ray.org_x = i % 2 ? 0 : 1600, r.ray.tfar = INFINITY;
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(asked[i], &r, NULL);
        CHECK(r.hit.geomID == (i == 1) && r.hit.instPrimID[0] == (i % 2 ? -1u : 7), "query %d: %u", i, r.hit.instPrimID[0]);
    }
    struct RTCPointQueryContext context;
    struct RTCPointQuery query = { 0, 0, 0, 0, INFINITY };
    unsigned found[2] = { 99, 99 };
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, look, found);
    CHECK(found[0] == -1u && found[1] < 8, "of a point: %u, %u", found[0], found[1]);
    CHECK(context.instPrimID[0] == -1u && context.instID[0] == -1u, "nothing stays in its context");
    /* Who sends rays through arrays of his own says so in the context. */
    struct RTCRayQueryContext own = { { 8 }, { 9 } };
    struct RTCIntersectArguments args;
    rtcInitIntersectArguments(&args);
    args.context = &own;
    r = ray(0, 0, 0);
    rtcIntersect1(floor, &r, &args);
    CHECK(r.hit.instID[0] == 8 && r.hit.instPrimID[0] == 9, "of the context: %u, %u", r.hit.instID[0], r.hit.instPrimID[0]);
    rtcReleaseScene(scene);
    rtcReleaseScene(floor);
}

/* Filters may shorten the ray of a hit that they let pass. */
static void shorten(const struct RTCFilterFunctionNArguments *args)
{
    struct RTCRay *r = (struct RTCRay *)args->ray;
    if (((struct RTCHit *)args->hit)->primID != 9)
        args->valid[0] = 0;
    r->tfar = 0.5f;
}

static void shorter_rays(void)
{
    RTCGeometry mesh = floors(10);
    rtcSetGeometryIntersectFilterFunction(mesh, shorten);
    RTCScene scene = committed(mesh);
    struct RTCRayHit r = ray(0, 0, 0);
    rtcIntersect1(scene, &r, NULL);
    CHECK(r.hit.primID == 9 && r.ray.tfar == 0.5f, "the ray ends where the filter says: %u, %g", r.hit.primID, r.ray.tfar);
    rtcReleaseScene(scene);
}

/* Inside of instances filters see the ray in the space of the geometry. */
static int inside;
static void looks_around(const struct RTCFilterFunctionNArguments *args)
{
    struct RTCRay *r = (struct RTCRay *)args->ray;
    struct RTCHit *hit = (struct RTCHit *)args->hit;
    CHECK(r->org_x == 1 && r->org_y == 2 && r->org_z == -4 && r->dir_x == 0 && r->dir_z == 0.5f, "the ray begins at %g %g %g, goes %g %g",
          r->org_x, r->org_y, r->org_z, r->dir_x, r->dir_z);
    CHECK(r->tfar == 10 && hit->instID[0] == 7 && args->context->instID[0] == 7, "t %g, instance %u, %u", r->tfar, hit->instID[0],
          args->context->instID[0]);
    inside++;
}

static void filters_inside_of_instances(void)
{
    RTCGeometry mesh = floors(1), instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryIntersectFilterFunction(mesh, looks_around);
    RTCScene floor = committed(mesh), scene = rtcNewScene(device);
    float place[12] = { 2, 0, 0, 0, 2, 0, 0, 0, 2, 100, 0, 0 };
    rtcSetGeometryInstancedScene(instance, floor);
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, place);
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(scene, instance, 7);
    rtcReleaseGeometry(instance);
    rtcCommitScene(scene);
    struct RTCRayHit r = ray(102, 4, -8);
    rtcIntersect1(scene, &r, NULL);
    CHECK(inside > 0 && r.ray.tfar == 10 && r.hit.instID[0] == 7, "%d calls, t %g", inside, r.ray.tfar);
    CHECK(r.ray.org_x == 102 && r.ray.org_z == -8 && r.ray.dir_z == 1, "the ray is as it was");
    rtcReleaseScene(scene);
    rtcReleaseScene(floor);
}

int main(void)
{
    device = rtcNewDevice("threads=1");
    copies_of_hits();
    packets();
    numbers_of_instances();
    shorter_rays();
    filters_inside_of_instances();
    rtcReleaseDevice(device);
    return finish();
}
