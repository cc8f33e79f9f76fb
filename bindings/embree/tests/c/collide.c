/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pairs of rtcCollide against all pairs of boxes, and against all triangles that meet. Runs on Embree's own library as well,
 * with an argument: triangles and errors are ours, and it may name pairs whose boxes are only near. */
#include <gnurt/embree.h>

#include "check.h"

static RTCDevice device;
static bool is_ours;

enum { MOST = 700, GEOMETRIES = 2 };

struct body {
    int count;
    struct RTCBounds boxes[MOST];
    float triangles[MOST][3][4];
};

static struct body bodies[2][GEOMETRIES];

static void fill(struct body *body, int count, float size)
{
    body->count = count;
    for (int i = 0; i < count; i++) {
        float corner[3][3];
        for (int k = 0; k < 3; k++) {
            float at = number();
            for (int c = 0; c < 3; c++)
                corner[c][k] = at + size * (number() - 0.5f);
        }
        struct RTCBounds *box = &body->boxes[i];
        float *low = &box->lower_x, *high = &box->upper_x;
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(fminf(corner[0][k], corner[1][k]), corner[2][k]);
            high[k] = fmaxf(fmaxf(corner[0][k], corner[1][k]), corner[2][k]);
            for (int c = 0; c < 3; c++)
                body->triangles[i][c][k] = corner[c][k];
        }
    }
}

static void bounds(const struct RTCBoundsFunctionArguments *arguments)
{
    const struct body *body = arguments->geometryUserPtr;
    *arguments->bounds_o = body->boxes[arguments->primID];
}

static RTCScene scene_of(struct body *all, bool is_mesh)
{
    RTCScene scene = rtcNewScene(device);
    for (int g = 0; g < GEOMETRIES; g++) {
        RTCGeometry geometry =
            rtcNewGeometry(device, is_mesh ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_USER);
        if (is_mesh) {
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, all[g].triangles, 0, 16,
                                       3 * all[g].count);
            unsigned *index =
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, all[g].count);
            for (int i = 0; i < 3 * all[g].count; i++)
                index[i] = i;
        } else {
            rtcSetGeometryUserPrimitiveCount(geometry, all[g].count);
            rtcSetGeometryUserData(geometry, &all[g]);
            rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
        }
        rtcCommitGeometry(geometry);
        /* Ids with gaps. */
        rtcAttachGeometryByID(scene, geometry, 3 + 4 * g);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);
    return scene;
}

/* How often each pair came. */
static unsigned char seen[GEOMETRIES][MOST][GEOMETRIES][MOST];
static int blocks, largest;

static void collided(void *user, struct RTCCollision *pairs, unsigned int count)
{
    CHECK(user == seen, "the program's pointer");
    blocks++;
    largest = (int)count > largest ? (int)count : largest;
    for (unsigned i = 0; i < count; i++) {
        unsigned g0 = (pairs[i].geomID0 - 3) / 4, g1 = (pairs[i].geomID1 - 3) / 4;
        CHECK(pairs[i].geomID0 % 4 == 3 && pairs[i].geomID1 % 4 == 3 && g0 < GEOMETRIES && g1 < GEOMETRIES, "ids");
        if (g0 < GEOMETRIES && g1 < GEOMETRIES && pairs[i].primID0 < MOST && pairs[i].primID1 < MOST)
            seen[g0][pairs[i].primID0][g1][pairs[i].primID1]++;
    }
}

static bool overlap(const struct RTCBounds *a, const struct RTCBounds *b)
{
    const float *low0 = &a->lower_x, *high0 = &a->upper_x, *low1 = &b->lower_x, *high1 = &b->upper_x;
    for (int k = 0; k < 3; k++)
        if (!(low0[k] <= high1[k] && low1[k] <= high0[k]))
            return false;
    return true;
}

/* Whether an edge of one triangle goes through the other. */
static bool pierces(float (*a)[4], float (*b)[4])
{
    for (int i = 0; i < 3; i++) {
        float dir[3];
        for (int k = 0; k < 3; k++)
            dir[k] = a[(i + 1) % 3][k] - a[i][k];
        double t = meets(b[0], b[1], b[2], a[i], dir);
        if (t >= 0 && t <= 1)
            return true;
    }
    return false;
}

static void pairs(const int counts[2][GEOMETRIES], float size, bool is_mesh)
{
    for (int s = 0; s < 2; s++)
        for (int g = 0; g < GEOMETRIES; g++)
            fill(&bodies[s][g], counts[s][g], size);
    RTCScene first = scene_of(bodies[0], is_mesh), second = scene_of(bodies[1], is_mesh);
    memset(seen, 0, sizeof seen);
    blocks = largest = 0;
    rtcCollide(first, second, collided, seen);
    int found = 0, boxes = 0, met = 0, wrong = 0;
    for (int g = 0; g < GEOMETRIES; g++)
        for (int i = 0; i < bodies[0][g].count; i++)
            for (int h = 0; h < GEOMETRIES; h++)
                for (int j = 0; j < bodies[1][h].count; j++) {
                    int times = seen[g][i][h][j];
                    bool touch = overlap(&bodies[0][g].boxes[i], &bodies[1][h].boxes[j]);
                    float(*a)[4] = bodies[0][g].triangles[i], (*b)[4] = bodies[1][h].triangles[j];
                    bool must = is_mesh ? pierces(a, b) || pierces(b, a) : touch;
                    found += times, boxes += touch, met += must;
                    wrong += times > 1 || times < must || (is_ours && times > touch);
                }
    CHECK(wrong == 0 && met > 0, "%d pairs wrong; %d found, %d boxes, %d must be there", wrong, found, boxes, met);
    CHECK(largest > 1 || found < 2 || !is_ours, "pairs come in blocks: %d calls for %d", blocks, found);
    rtcReleaseScene(first);
    rtcReleaseScene(second);
}

static void expect(enum RTCError code, const char *what)
{
    enum RTCError found = rtcGetDeviceError(device);
    CHECK(found == code, "%s: %s", what, rtcGetErrorString(found));
}

static void errors(void)
{
    RTCScene scene = scene_of(bodies[0], false), empty = rtcNewScene(device);
    expect(RTC_ERROR_NONE, "so far");
    rtcCollide(scene, scene, NULL, NULL);
    expect(RTC_ERROR_INVALID_ARGUMENT, "no function");
    rtcCollide(scene, NULL, collided, seen);
    expect(RTC_ERROR_INVALID_ARGUMENT, "no second scene");
    rtcCollide(scene, empty, collided, seen);
    expect(RTC_ERROR_INVALID_OPERATION, "an uncommitted scene");
    rtcCommitScene(empty);
    blocks = 0;
    rtcCollide(scene, empty, collided, seen);
    rtcCollide(empty, scene, collided, seen);
    expect(RTC_ERROR_NONE, "an empty scene");
    CHECK(blocks == 0, "nothing meets nothing");
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, scene);
    rtcCommitGeometry(instance);
    rtcAttachGeometry(empty, instance);
    rtcReleaseGeometry(instance);
    rtcCommitScene(empty);
    rtcCollide(scene, empty, collided, seen);
    expect(RTC_ERROR_INVALID_OPERATION, "instances");
    rtcReleaseScene(empty);
    rtcReleaseScene(scene);
    scene = rtcNewScene(device);
    RTCGeometry points = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(points, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, bodies[0][0].triangles, 0, 16, 3);
    rtcCommitGeometry(points);
    rtcAttachGeometry(scene, points);
    rtcReleaseGeometry(points);
    rtcCommitScene(scene);
    rtcCollide(scene, scene, collided, seen);
    expect(RTC_ERROR_INVALID_OPERATION, "spheres");
    rtcReleaseScene(scene);
    scene = rtcNewScene(device);
    RTCGeometry user = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryTimeStepCount(user, 2);
    rtcSetGeometryUserPrimitiveCount(user, 1);
    rtcSetGeometryUserData(user, &bodies[0][0]);
    rtcSetGeometryBoundsFunction(user, bounds, NULL);
    rtcCommitGeometry(user);
    rtcAttachGeometry(scene, user);
    rtcReleaseGeometry(user);
    rtcCommitScene(scene);
    rtcCollide(scene, scene, collided, seen);
    expect(RTC_ERROR_INVALID_OPERATION, "two time steps");
    rtcReleaseScene(scene);
}

int main(int count, char **arguments)
{
    (void)arguments;
    device = rtcNewDevice(NULL);
    is_ours = count == 1;
    const int sizes[][2][GEOMETRIES] = { { { 500, 200 }, { 300, 40 } }, { { 3, 0 }, { 600, 100 } }, { { 4, 3 }, { 5, 1 } } };
    for (int i = 0; i < 3; i++)
        for (int is_mesh = 0; is_mesh < (is_ours ? 2 : 1); is_mesh++)
            pairs(sizes[i], i == 0 ? 0.1f + 0.2f * is_mesh : 0.5f * i * i, is_mesh);
    if (is_ours)
        errors();
    rtcReleaseDevice(device);
    return finish();
}
