/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Motion by the calls of Embree, checked by closed forms and, for meshes, against a static scene at each time. Runs on
 * Embree's own library as well, with an argument: which errors there are is ours. */
#include "scenes.h"

static bool is_ours;

static struct RTCRayHit ray(float ox, float oy, float oz, float dx, float dy, float dz, float time)
{
    struct RTCRayHit all;
    memset(&all, 0, sizeof all);
    all.ray.org_x = ox, all.ray.org_y = oy, all.ray.org_z = oz;
    all.ray.dir_x = dx, all.ray.dir_y = dy, all.ray.dir_z = dz;
    all.ray.tfar = INFINITY;
    all.ray.time = time;
    all.ray.mask = -1;
    all.hit.geomID = all.hit.primID = all.hit.instID[0] = all.hit.instPrimID[0] = RTC_INVALID_GEOMETRY_ID;
    return all;
}

static struct RTCRayHit shot(RTCScene scene, struct RTCRayHit all)
{
    rtcIntersect1(scene, &all, NULL);
    return all;
}

/* How far a ray goes from (x, y, 10) downwards; infinitely far without a hit. */
static float down(RTCScene scene, float x, float y, float time)
{
    struct RTCRayHit hit = shot(scene, ray(x, y, 10, 0, 0, -1, time));
    return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? INFINITY : hit.ray.tfar;
}

static int near(double a, double b) { return (isinf(a) && isinf(b)) || fabs(a - b) < 1e-4; }

enum { STEPS = 3, TRIANGLES = 200 };
static float keys[STEPS][3 * TRIANGLES][4];
static unsigned indices[TRIANGLES][3];

static void fill(void)
{
    for (int i = 0; i < 3 * TRIANGLES; i++) {
        indices[i / 3][i % 3] = i;
        for (int k = 0; k < 3; k++) {
            keys[0][i][k] = i % 3 ? keys[0][i - 1][k] + 0.5f * (number() - 0.5f) : 2 * number() - 1;
            for (int step = 1; step < STEPS; step++)
                keys[step][i][k] = keys[step - 1][i][k] + 0.6f * (number() - 0.5f);
        }
    }
}

static RTCScene mesh_of(const float (*steps)[3 * TRIANGLES][4], int count, const float *range)
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(mesh, count);
    if (range)
        rtcSetGeometryTimeRange(mesh, range[0], range[1]);
    for (int step = 0; step < count; step++)
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, steps[step], 0, 16,
                                   3 * TRIANGLES);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12, TRIANGLES);
    return committed(mesh);
}

static void meshes(void)
{
    const float ranges[][2] = { { 0, 1 }, { 0.25f, 0.75f }, { -1, 2 } };
    const float times[] = { 0, 0.25f, 0.4f, 0.5f, 0.7f, 1 };
    fill();
    for (int r = 0; r < 3; r++) {
        RTCScene moving = mesh_of((const float (*)[3 * TRIANGLES][4])keys, STEPS, ranges[r]);
        for (int n = 0; n < 6; n++) {
            static float now[1][3 * TRIANGLES][4];
            float at = (times[n] - ranges[r][0]) / (ranges[r][1] - ranges[r][0]) * (STEPS - 1);
            int is_there = at >= 0 && at <= STEPS - 1, from = at < 1 ? 0 : 1, hits = 0;
            for (int i = 0; i < 3 * TRIANGLES; i++)
                for (int k = 0; k < 3; k++)
                    now[0][i][k] = keys[from][i][k] + (at - from) * (keys[from + 1][i][k] - keys[from][i][k]);
            RTCScene still = mesh_of((const float (*)[3 * TRIANGLES][4])now, 1, NULL);
            struct RTCRayHit4 packet;
            const int valid[4] = { -1, -1, -1, -1 };
            for (int i = 0; i < 200; i++) {
                struct RTCRayHit one = ray(2 * number() - 1, 2 * number() - 1, 3, 0.3f * (number() - 0.5f),
                                           0.3f * (number() - 0.5f), -1, times[n]);
                struct RTCRayHit found = shot(moving, one), expected = shot(still, one);
                if (!is_there)
                    expected = one;
                int is_hit = expected.hit.geomID != RTC_INVALID_GEOMETRY_ID;
                hits += is_hit;
                CHECK(found.hit.primID == expected.hit.primID && near(found.ray.tfar, expected.ray.tfar),
                      "at %g: %u at %g, not %u at %g", times[n], found.hit.primID, found.ray.tfar,
                      expected.hit.primID, expected.ray.tfar);
                CHECK(!is_hit || (near(found.hit.Ng_x, expected.hit.Ng_x) && near(found.hit.Ng_y, expected.hit.Ng_y)
                                  && near(found.hit.Ng_z, expected.hit.Ng_z)), "normals at %g", times[n]);
                CHECK(!is_hit || (near(found.hit.u, expected.hit.u) && near(found.hit.v, expected.hit.v)), "u, v");
                struct RTCRay shadow = one.ray;
                rtcOccluded1(moving, &shadow, NULL);
                CHECK((shadow.tfar < 0) == is_hit, "occluded at %g", times[n]);
                /* Lanes of a packet have times of their own. */
                int lane = i % 4;
                if (lane == 0)
                    memset(&packet, 0, sizeof packet);
                packet.ray.org_x[lane] = one.ray.org_x, packet.ray.org_y[lane] = one.ray.org_y;
                packet.ray.org_z[lane] = one.ray.org_z, packet.ray.dir_x[lane] = one.ray.dir_x;
                packet.ray.dir_y[lane] = one.ray.dir_y, packet.ray.dir_z[lane] = one.ray.dir_z;
                packet.ray.tfar[lane] = INFINITY, packet.ray.mask[lane] = -1;
                packet.ray.time[lane] = lane % 2 ? 0.5f : times[n];
                packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
                if (lane == 3) {
                    struct RTCRayHit4 before = packet;
                    rtcIntersect4(valid, moving, &packet, NULL);
                    for (int k = 0; k < 4; k++) {
                        struct RTCRayHit alone = ray(before.ray.org_x[k], before.ray.org_y[k], before.ray.org_z[k],
                                                     before.ray.dir_x[k], before.ray.dir_y[k], before.ray.dir_z[k],
                                                     before.ray.time[k]);
                        alone = shot(moving, alone);
                        CHECK(near(packet.ray.tfar[k], alone.ray.tfar), "lane %d alone and in a packet", k);
                    }
                }
            }
            CHECK(hits > 50 || !is_there, "%d hits at %g", hits, times[n]);
            rtcReleaseScene(still);
        }
        rtcReleaseScene(moving);
    }
}

/* A quad, a sphere, a disc and a curve that fall by 4 and grow. */
static void others(void)
{
    const float quad[2][4][3] = { { { -1, -1, 4 }, { 1, -1, 4 }, { 1, 1, 4 }, { -1, 1, 4 } },
                                  { { -1, -1, 0 }, { 1, -1, 0 }, { 1, 1, 0 }, { -1, 1, 0 } } };
    const unsigned corners[4] = { 0, 1, 2, 3 }, first = 0;
    const float balls[2][4] = { { 0, 0, 4, 1 }, { 0, 0, 0, 2 } };
    const float lines[2][4][4] = { { { -3, 0, 4, 1 }, { -1, 0, 4, 1 }, { 1, 0, 4, 1 }, { 3, 0, 4, 1 } },
                                   { { -3, 0, 0, 2 }, { -1, 0, 0, 2 }, { 1, 0, 0, 2 }, { 3, 0, 0, 2 } } };
    const enum RTCGeometryType types[] = { RTC_GEOMETRY_TYPE_QUAD, RTC_GEOMETRY_TYPE_SPHERE_POINT,
                                           RTC_GEOMETRY_TYPE_DISC_POINT, RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE,
                                           RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE };
    for (int kind = 0; kind < 6; kind++) {
        RTCGeometry geometry = rtcNewGeometry(device, types[kind]);
        rtcSetGeometryTimeStepCount(geometry, 2);
        for (int step = 0; step < 2; step++) {
            if (kind == 0)
                rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, quad[step], 0, 12, 4);
            else if (kind < 3)
                rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4, balls[step], 0, 16, 1);
            else
                rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4, lines[step], 0, 16, 4);
        }
        if (kind == 0)
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, corners, 0, 16, 1);
        if (kind > 2)
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, &first, 0, 4, 1);
        RTCScene scene = committed(geometry);
        for (float time = 0; time <= 1; time += 0.125f) {
            int is_round = kind == 1 || kind == 3;
            float x = kind == 5 ? -2 : 0.25f, y = is_round ? 0.5f : 0, radius = 1 + time;
            float height = is_round ? sqrtf(radius * radius - y * y) : 0;
            if (kind == 1)
                height = sqrtf(radius * radius - y * y - x * x);
            float expected = 10 - (4 - 4 * time) - height, found = down(scene, x, y, time);
            CHECK(near(found, expected), "kind %d at %g: %g, not %g", kind, time, found, expected);
            if (kind == 1) {
                struct RTCRayHit hit = shot(scene, ray(x, y, 10, 0, 0, -1, time));
                CHECK(near(hit.hit.Ng_x, x) && near(hit.hit.Ng_y, y) && near(hit.hit.Ng_z, height), "normal of a sphere");
            }
        }
        rtcReleaseScene(scene);
    }
}

static void instances(void)
{
    const float vertices[4][3] = { { -1, -1, 0 }, { 1, -1, 0 }, { 1, 1, 0 }, { -1, 1, 0 } };
    const unsigned corners[4] = { 0, 1, 2, 3 };
    RTCGeometry quad = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    rtcSetSharedGeometryBuffer(quad, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0, 12, 4);
    rtcSetSharedGeometryBuffer(quad, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, corners, 0, 16, 1);
    RTCScene shown = committed(quad);

    /* Entries of matrices go straight: half way of a quarter turn the quad is smaller by the root of a half. */
    const float places[2][12] = { { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 }, { 0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0, 4 } };
    RTCGeometry straight = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(straight, shown);
    rtcSetGeometryTimeStepCount(straight, 2);
    for (int step = 0; step < 2; step++)
        rtcSetGeometryTransform(straight, step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, places[step]);
    rtcRetainGeometry(straight);
    RTCScene scene = committed(straight);
    CHECK(near(down(scene, 0.9f, 0.05f, 0), 10) && near(down(scene, 0.9f, 0.05f, 1), 6), "both ends");
    CHECK(near(down(scene, 0.9f, 0.05f, 0.5f), 8) && isinf(down(scene, 0.9f, 0.2f, 0.5f)), "half way it is a rhombus");
    float matrix[16];
    rtcGetGeometryTransform(straight, 0.5f, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, matrix);
    CHECK(near(matrix[0], 0.5) && near(matrix[1], 0.5) && near(matrix[14], 2), "the transform half way");
    rtcGetGeometryTransformFromScene(scene, 0, 0.25f, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, matrix);
    CHECK(near(matrix[0], 0.75) && near(matrix[14], 1), "the transform of a quarter");
    rtcReleaseGeometry(straight);
    rtcReleaseScene(scene);

    /* Quaternions turn: it stays as large as it is. */
    struct RTCQuaternionDecomposition turned[2];
    memset(turned, 0, sizeof turned);
    RTCGeometry turning = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(turning, shown);
    rtcSetGeometryTimeStepCount(turning, 2);
    for (int step = 0; step < 2; step++) {
        float *numbers = (float *)&turned[step];
        numbers[0] = numbers[1] = numbers[2] = 1;
        /* A quarter around z. */
        numbers[9] = step ? sqrtf(0.5f) : 1, numbers[12] = step ? sqrtf(0.5f) : 0;
        numbers[15] = 4.0f * step;
        rtcSetGeometryTransformQuaternion(turning, step, &turned[step]);
    }
    rtcSetGeometryTimeRange(turning, 0.25f, 0.75f);
    scene = committed(turning);
    CHECK(near(down(scene, 1.3f, 0, 0.5f), 8) && isinf(down(scene, 1.3f, 0, 0.25f)), "half way its corner is there");
    /* Embree does not show the last moment itself. */
    CHECK(near(down(scene, 0, 0, 0.25f), 10) && near(down(scene, 0, 0, 0.7f), 6.4), "within the range");
    CHECK(isinf(down(scene, 0, 0, 0.2f)) && isinf(down(scene, 0, 0, 0.8f)), "not there before and after");
    rtcReleaseScene(scene);
    rtcReleaseScene(shown);
}

static float seen_time;
static int told_steps;

static void bounds(const struct RTCBoundsFunctionArguments *arguments)
{
    float z = 4.0f * arguments->timeStep;
    struct RTCBounds box = { -1, -1, z, 0, 1, 1, z, 0 };
    *arguments->bounds_o = box;
    told_steps |= 1 << arguments->timeStep;
}

static void meet(const struct RTCIntersectFunctionNArguments *arguments)
{
    struct RTCRayHit *all = (struct RTCRayHit *)arguments->rayhit;
    float z = 8 * all->ray.time, t = (z - all->ray.org_z) / all->ray.dir_z;
    seen_time = all->ray.time;
    if (!arguments->valid[0] || t < all->ray.tnear || t > all->ray.tfar)
        return;
    all->ray.tfar = t;
    all->hit.geomID = arguments->geomID, all->hit.primID = arguments->primID;
}

static bool look(struct RTCPointQueryFunctionArguments *arguments)
{
    (*(int *)arguments->userPtr)++;
    return false;
}

static void programs(void)
{
    RTCGeometry user = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(user, 1);
    rtcSetGeometryTimeStepCount(user, 3);
    rtcSetGeometryBoundsFunction(user, bounds, NULL);
    rtcSetGeometryIntersectFunction(user, meet);
    RTCScene scene = committed(user);
    CHECK(told_steps == 7, "bounds of three steps: %d", told_steps);
    for (float time = 0; time <= 1; time += 0.25f)
        CHECK(near(down(scene, 0, 0, time), 10 - 8 * time) && seen_time == time, "user geometry at %g", time);
    rtcReleaseScene(scene);

    const float vertices[2][3][3] = { { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, { { 0, 0, 9 }, { 1, 0, 9 }, { 0, 1, 9 } } };
    const unsigned corners[3] = { 0, 1, 2 };
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(mesh, 2);
    for (int step = 0; step < 2; step++)
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, vertices[step], 0, 12, 3);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, corners, 0, 12, 1);
    rtcRetainGeometry(mesh);
    scene = committed(mesh);
    int found[2] = { 0, 0 };
    for (int i = 0; i < 2; i++) {
        struct RTCPointQuery query = { 0.2f, 0.2f, 9, (float)i, 1 };
        struct RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(scene, &query, &context, look, &found[i]);
    }
    /* Embree shows more at other times. */
    CHECK((found[0] == 0 || !is_ours) && found[1] == 1, "near the triangle at time 1: %d, %d", found[0], found[1]);
    float value[3];
    struct RTCInterpolateArguments between;
    memset(&between, 0, sizeof between);
    between.geometry = mesh, between.u = between.v = 0.25f, between.P = value, between.valueCount = 3;
    between.bufferType = RTC_BUFFER_TYPE_VERTEX, between.bufferSlot = 1;
    rtcInterpolate(&between);
    CHECK(near(value[0], 0.25) && near(value[2], 9), "interpolation of a time step");
    rtcReleaseGeometry(mesh);
    rtcReleaseScene(scene);
}

/* A triangle along x: boxes that go straight from the first to the second hold it at all times. */
static void boxes(void)
{
    static const float x[3] = { 0, 5, 3 };
    static const unsigned corners[3] = { 0, 1, 2 };
    float points[3][3][3];
    for (int step = 0; step < 3; step++)
        for (int i = 0; i < 3; i++)
            points[step][i][0] = x[step] + i % 2, points[step][i][1] = i / 2, points[step][i][2] = 0;
    for (int steps = 1; steps < 4; steps++) {
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryTimeStepCount(mesh, steps);
        for (int step = 0; step < steps; step++)
            rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, points[step], 0, 12, 3);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, corners, 0, 12, 1);
        RTCScene scene = committed(mesh);
        struct RTCLinearBounds both;
        rtcGetSceneLinearBounds(scene, &both);
        const struct RTCBounds *a = &both.bounds0, *b = &both.bounds1;
        if (steps < 3)
            CHECK(near(a->lower_x, 0) && near(a->upper_x, 1) && near(b->lower_x, x[steps - 1]) &&
                      near(b->upper_x, x[steps - 1] + 1),
                  "%d steps: from %g to %g", steps, a->lower_x, b->upper_x);
        for (int i = 0; i <= 20; i++) {
            float t = i / 20.0f, share = steps == 3 ? 2 * t - (t >= 0.5f) : t;
            int step = steps == 3 && t >= 0.5f, next = steps == 1 ? 0 : step + 1;
            float at = x[step] + share * (x[next] - x[step]);
            CHECK(a->lower_x + t * (b->lower_x - a->lower_x) < at + 1e-4f &&
                      a->upper_x + t * (b->upper_x - a->upper_x) > at + 1 - 1e-4f,
                  "%d steps at %g", steps, t);
        }
        rtcReleaseScene(scene);
    }
}

static void expect(enum RTCError code, const char *what)
{
    enum RTCError found = rtcGetDeviceError(device);
    CHECK(found == code, "%s: %s", what, rtcGetErrorString(found));
}

static void errors(void)
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(mesh, 0);
    expect(RTC_ERROR_INVALID_OPERATION, "no time step");
    rtcSetGeometryTimeStepCount(mesh, 130);
    expect(RTC_ERROR_INVALID_OPERATION, "more steps than Embree has");
    rtcSetGeometryTimeRange(mesh, 1, 0);
    expect(RTC_ERROR_INVALID_ARGUMENT, "a range that ends before it starts");
    rtcSetGeometryTimeStepCount(mesh, 2);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 2, RTC_FORMAT_FLOAT3, keys[0], 0, 16, 3);
    expect(RTC_ERROR_INVALID_OPERATION, "a third of two steps");
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, keys[0], 0, 16, 3);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12, 1);
    rtcReleaseScene(committed(mesh));
    expect(RTC_ERROR_INVALID_OPERATION, "a step without vertices");
    mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(mesh, 2);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, keys[0], 0, 16, 3);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, keys[0], 0, 16, 4);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12, 1);
    rtcReleaseScene(committed(mesh));
    expect(RTC_ERROR_INVALID_OPERATION, "steps of different numbers of vertices");
}

int main(int count, char **arguments)
{
    (void)arguments;
    device = rtcNewDevice(NULL);
    is_ours = count == 1;
    meshes();
    boxes();
    others();
    instances();
    programs();
    if (is_ours)
        errors();
    rtcReleaseDevice(device);
    return finish();
}
