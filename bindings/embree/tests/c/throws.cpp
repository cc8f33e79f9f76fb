// SPDX-License-Identifier: GPL-3.0-or-later
// Exceptions that functions of the program throw: those of error functions reach the program, others end in the library.
#include <atomic>
#include <gnurt/embree.h>
#include <gnurt/rays.h>

#include <exception>
#include <stdexcept>
#include <string>

#include "scenes.h"

// Counts its copies; threads of the pool throw it at the same time.
static std::atomic<int> alive { 0 };
struct Trouble : std::runtime_error {
    Trouble() : std::runtime_error("trouble") { alive++; }
    Trouble(const Trouble &other) : std::runtime_error(other) { alive++; }
    ~Trouble() override { alive--; }
};

static void told(void *, RTCError code, const char *message)
{
    throw std::invalid_argument(std::to_string(code) + message);
}

static void ended(RTCError code, const char *what)
{
    RTCError found = rtcGetDeviceError(device);
    CHECK(found == code, "%s: %s", what, rtcGetErrorString(found));
    CHECK(std::uncaught_exceptions() == 0 && alive == 0, "%s: the exception is gone (%d)", what, alive.load());
}

static void error_functions()
{
    rtcSetDeviceErrorFunction(device, told, nullptr);
    RTCScene scene = rtcNewScene(device);
    int caught = 0;
    for (int i = 0; i < 3; i++) {
        try {
            if (i == 0)
                rtcNewGeometry(device, RTCGeometryType(77));
            else if (i == 1)
                rtcGetGeometry(scene, 9);
            else
                rtcSetSceneBuildQuality(scene, RTCBuildQuality(9));
            CHECK(0, "call %d goes on", i);
        } catch (const std::invalid_argument &error) {
            CHECK(error.what()[0] == (i == 2 ? '3' : '2'), "%s", error.what());
            caught++;
        }
    }
    // A query that goes wrong.
    RTCRayHit ray = {};
    try {
        rtcIntersect1(scene, &ray);
        CHECK(0, "it goes on");
    } catch (const std::invalid_argument &) {
        caught++;
    }
    CHECK(caught == 4, "caught: %d", caught);
    rtcSetDeviceErrorFunction(device, nullptr, nullptr);
    rtcReleaseScene(scene);
    ended(RTC_ERROR_INVALID_ARGUMENT, "the first of them is remembered");
}

static int calls;
static void filter(const RTCFilterFunctionNArguments *)
{
    calls++;
    throw Trouble();
}
static void intersect(const RTCIntersectFunctionNArguments *)
{
    calls++;
    throw Trouble();
}
static void occluded(const RTCOccludedFunctionNArguments *)
{
    calls++;
    throw 7;
}
static bool bad_bounds;
static void bounds(const RTCBoundsFunctionArguments *args)
{
    if (bad_bounds)
        throw Trouble();
    *args->bounds_o = { -9, -9, 0, 0, 9, 9, 9, 0 };
}
static bool near(RTCPointQueryFunctionArguments *) { throw Trouble(); }
static bool progress(void *, double) { throw Trouble(); }
static bool memory(void *, ssize_t bytes, bool)
{
    if (bytes > 0)
        throw Trouble();
    return true;
}

// Several floors, so that there would be more hits to ask about.
static RTCGeometry floors()
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto *p = static_cast<float *>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 9));
    auto *of = static_cast<unsigned *>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 3));
    for (unsigned i = 0; i < 9; i++) {
        p[3 * i] = i % 3 == 1 ? 9 : -3, p[3 * i + 1] = i % 3 == 2 ? 9 : -3, p[3 * i + 2] = float(1 + i / 3);
        of[i] = i;
    }
    return mesh;
}

static RTCGeometry user(unsigned count = 1)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, count);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occluded);
    return geometry;
}

static RTCRayHit up()
{
    RTCRayHit ray = {};
    ray.ray.dir_z = 1, ray.ray.tfar = INFINITY, ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    return ray;
}

static void queries()
{
    RTCGeometry mesh = floors();
    rtcSetGeometryIntersectFilterFunction(mesh, filter);
    rtcSetGeometryOccludedFilterFunction(mesh, filter);
    RTCScene scenes[2] = { committed(mesh), committed(user(5)) };
    for (RTCScene scene : scenes) {
        RTCRayHit ray = up();
        RTCRay shadow = ray.ray;
        calls = 0;
        rtcIntersect1(scene, &ray);
        ended(RTC_ERROR_UNKNOWN, "a query");
        CHECK(ray.hit.geomID == RTC_INVALID_GEOMETRY_ID && ray.ray.tfar == INFINITY, "it has no hit");
        rtcOccluded1(scene, &shadow);
        ended(RTC_ERROR_UNKNOWN, "a shadow");
        CHECK(shadow.tfar == INFINITY && calls == 2, "nobody else is asked: %d calls", calls);
        RTCRayHit8 packet = {};
        int valid[8] __attribute__((aligned(64)));
        for (int i = 0; i < 8; i++)
            valid[i] = -1, packet.ray.dir_z[i] = 1, packet.ray.tfar[i] = INFINITY, packet.ray.mask[i] = ~0u;
        rtcIntersect8(valid, scene, &packet);
        ended(RTC_ERROR_UNKNOWN, "a packet");
    }
    // The next query is as if nothing had been.
    RTCScene plain = committed(floors());
    RTCRayHit ray = up();
    rtcIntersect1(plain, &ray);
    CHECK(ray.ray.tfar == 1, "others are answered: %g", ray.ray.tfar);
    RTCPointQuery query = { 0, 0, 0, 0, 100 };
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(plain, &query, &context, near, nullptr);
    ended(RTC_ERROR_UNKNOWN, "a point");
    rtcReleaseScene(plain);
    for (RTCScene scene : scenes)
        rtcReleaseScene(scene);
}

static void commits()
{
    for (int i = 0; i < 3; i++) {
        bad_bounds = i == 0;
        RTCScene scene = rtcNewScene(device);
        RTCGeometry geometry = i == 0 ? user() : floors();
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        if (i == 1)
            rtcSetSceneProgressMonitorFunction(scene, progress, nullptr);
        if (i == 2)
            rtcSetDeviceMemoryMonitorFunction(device, memory, nullptr);
        rtcCommitScene(scene);
        ended(RTC_ERROR_UNKNOWN, i == 0 ? "bounds" : i == 1 ? "progress" : "memory");
        rtcSetDeviceMemoryMonitorFunction(device, nullptr, nullptr);
        rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
        bad_bounds = false;
        rtcCommitScene(scene);
        ended(RTC_ERROR_NONE, "it can be built afterwards");
        rtcReleaseScene(scene);
    }
}

static bool bad;
static void own_bounds(void *, uint32_t, uint32_t count, float (*boxes)[6])
{
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 6; k++)
            boxes[i][k] = k < 3 ? -1.0f : 1.0f;
    if (bad)
        throw Trouble();
}
static void own_intersect(void *, size_t, const gnurt_user_ray *, gnurt_user_hit *hit)
{
    if (bad)
        throw Trouble();
    hit->t = 1;
}
static void own_filter(void *, size_t, const gnurt_candidate *, int *)
{
    if (bad)
        throw Trouble();
}

// By one thread and by several, whose exceptions would have nowhere to go.
static void calls_of_our_own()
{
    enum { RAYS = 500 };
    static float origins[RAYS][3], t[RAYS];
    const float dir[3] = { 0, 0, 1 };
    gnurt_user balls = { nullptr, 1, own_bounds, own_intersect };
    gnurt_scene *scene = gnurt_scene_new();
    bad = true;
    CHECK(gnurt_add_user(scene, &balls, 1, nullptr) == -1 && strstr(gnurt_last_error(), "bounds"), "%s", gnurt_last_error());
    bad = false;
    CHECK(gnurt_add_user(scene, &balls, 1, nullptr) == 0 && gnurt_commit(scene) == 0, "%s", gnurt_last_error());
    gnurt_rays rays = {};
    rays.count = RAYS;
    rays.origins = { origins, RAYS, 0, GNURT_F32 };
    rays.directions = { dir, 1, 0, GNURT_F32 };
    gnurt_hits hits = {};
    hits.t = t;
    for (unsigned threads = 1; threads < 4; threads++)
        for (int filters = 0; filters < 2; filters++) {
            gnurt_query query = { threads, 0, filters ? own_filter : nullptr, nullptr };
            bad = true;
            CHECK(gnurt_intersect(scene, &rays, &query, &hits) == -1 && strstr(gnurt_last_error(), "exception"), "%u threads: %s",
                  threads, gnurt_last_error());
            ended(RTC_ERROR_NONE, "by threads");
            bad = false;
            CHECK(gnurt_intersect(scene, &rays, &query, &hits) == 0 && t[9] == 1, "%u threads: %s", threads, gnurt_last_error());
        }
    gnurt_scene_free(scene);
}

int main()
{
    device = rtcNewDevice("threads=2");
    error_functions();
    queries();
    commits();
    calls_of_our_own();
    rtcReleaseDevice(device);
    return finish();
}
