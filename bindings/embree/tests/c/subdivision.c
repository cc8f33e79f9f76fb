/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Subdivision surfaces by the calls of Embree, checked by closed forms: bicubic B-splines, limits by hand, boxes. Runs on Embree's
 * own library as well, with an argument: errors are ours. */
#include <gnurt/embree.h>
#include <stdint.h>

#include "scenes.h"

static bool is_ours;

static struct RTCRayHit down(RTCScene scene, float x, float y, float time)
{
    const float org[3] = { x, y, 10 }, dir[3] = { 0, 0, -1 };
    return shot_along(scene, org, dir, time);
}

static bool near(double a, double b, double off) { return fabs(a - b) <= off; }

static void between(RTCGeometry geometry, unsigned prim, float u, float v, enum RTCBufferType type, unsigned slot,
                    float jet[6][4], unsigned count)
{
    struct RTCInterpolateArguments args;
    memset(&args, 0, sizeof args);
    args.geometry = geometry, args.primID = prim, args.u = u, args.v = v;
    args.bufferType = type, args.bufferSlot = slot, args.valueCount = count;
    args.P = jet[0], args.dPdu = jet[1], args.dPdv = jet[2];
    args.ddPdudu = jet[3], args.ddPdvdv = jet[4], args.ddPdudv = jet[5];
    rtcInterpolate(&args);
}

struct mesh {
    int faces, corners, vertices;
    const unsigned *counts, *indices;
    const float (*positions)[4];
};

static RTCGeometry geometry_of(const struct mesh *mesh)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0, 16,
                               mesh->vertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, mesh->counts, 0, 4, mesh->faces);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, mesh->indices, 0, 4, mesh->corners);
    return geometry;
}

/* A sheet of 4 x 4 faces: 5 x 5 vertices. */
static float heights[25][4];
static unsigned sheet_counts[16], sheet_indices[64];
static const struct mesh sheet = { 16, 64, 25, sheet_counts, sheet_indices, (const float(*)[4])heights };

static float cube_points[8][4];
static unsigned cube_counts[6] = { 4, 4, 4, 4, 4, 4 };
/* Vertex i is at the signs of its bits. */
static unsigned cube_indices[24] = { 4, 5, 7, 6, 0, 2, 3, 1, 1, 3, 7, 5, 0, 4, 6, 2, 2, 6, 7, 3, 0, 1, 5, 4 };
static const struct mesh cube = { 6, 24, 8, cube_counts, cube_indices, (const float(*)[4])cube_points };

static void fill(void)
{
    for (int i = 0; i < 25; i++) {
        heights[i][0] = i % 5, heights[i][1] = i / 5, heights[i][2] = number();
        if (i % 5 < 4 && i / 5 < 4) {
            int face = i / 5 * 4 + i % 5, at = 4 * face;
            sheet_counts[face] = 4;
            sheet_indices[at] = i, sheet_indices[at + 1] = i + 1;
            sheet_indices[at + 2] = i + 6, sheet_indices[at + 3] = i + 5;
        }
    }
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            cube_points[i][k] = i >> k & 1 ? 1 : -1;
}

/* Weights of a uniform cubic B-spline and of its derivatives. */
static void weights(double t, double w[3][4])
{
    double s = 1 - t;
    w[0][0] = s * s * s / 6, w[0][3] = t * t * t / 6;
    w[0][1] = 2.0 / 3 - t * t + t * t * t / 2, w[0][2] = 2.0 / 3 - s * s + s * s * s / 2;
    w[1][0] = -s * s / 2, w[1][1] = -2 * t + 1.5 * t * t, w[1][2] = 2 * s - 1.5 * s * s, w[1][3] = t * t / 2;
    w[2][0] = s, w[2][1] = 3 * t - 2, w[2][2] = 3 * s - 2, w[2][3] = t;
}

/* The height above the face of column x and row y, or a derivative of it. */
static double spline(int x, int y, double u, double v, int du, int dv)
{
    double wu[3][4], wv[3][4], sum = 0;
    weights(u, wu), weights(v, wv);
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
            sum += wu[du][i] * wv[dv][j] * heights[5 * (y - 1 + j) + x - 1 + i][2];
    return sum;
}

static void splines(void)
{
    static const int orders[6][2] = { { 0, 0 }, { 1, 0 }, { 0, 1 }, { 2, 0 }, { 0, 2 }, { 1, 1 } };
    RTCGeometry geometry = geometry_of(&sheet);
    rtcSetGeometryTessellationRate(geometry, 8);
    RTCScene scene = committed_with(geometry);
    int wrong = 0, hits = 0, places = 0;
    for (int y = 1; y < 3; y++)
        for (int x = 1; x < 3; x++)
            for (int i = 0; i < 49; i++) {
                /* Vertices of the cut surface. */
                float u = (1 + i % 7) / 8.0f, v = (1 + i / 7) / 8.0f, jet[6][4];
                between(geometry, 4 * y + x, u, v, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
                for (int o = 0; o < 6; o++)
                    wrong += !near(jet[o][2], spline(x, y, u, v, orders[o][0], orders[o][1]), 2e-5);
                wrong += !near(jet[0][0], x + u, 1e-5) || !near(jet[1][0], 1, 1e-5) || !near(jet[1][1], 0, 1e-5);
                struct RTCRayHit hit = down(scene, x + u + 1e-4f, y + v + 1e-5f, 0);
                hits += hit.hit.geomID == 0 && near(10 - hit.ray.tfar, spline(x, y, u, v, 0, 0), 1e-3);
                places += hit.hit.primID == (unsigned)(4 * y + x) && near(hit.hit.u, u, 1e-3) && near(hit.hit.v, v, 1e-3);
                double slope = hit.hit.Ng_x / hit.hit.Ng_z;
                wrong += !near(slope, -spline(x, y, u, v, 1, 0), 0.2);
            }
    CHECK(wrong == 0, "%d of 196 points differ from B-splines", wrong);
    CHECK(hits == 196 && places == 196, "%d hits and %d places of 196", hits, places);
    /* All at once, in rows. */
    unsigned prims[8] = { 5, 5, 99, 6, 9, 10, 10, 5 };
    int valid[8] = { -1, -1, 0, -1, -1, -1, -1, -1 };
    float u[8], v[8], rows[24], across[24], slopes[24];
    for (int i = 0; i < 8; i++)
        u[i] = number(), v[i] = number(), rows[i] = 77;
    rows[2] = rows[10] = rows[18] = 77;
    struct RTCInterpolateNArguments many;
    memset(&many, 0, sizeof many);
    many.geometry = geometry, many.valid = valid, many.primIDs = prims, many.u = u, many.v = v, many.N = 8;
    many.bufferType = RTC_BUFFER_TYPE_VERTEX, many.P = rows, many.dPdu = across, many.dPdv = slopes, many.valueCount = 3;
    rtcInterpolateN(&many);
    for (int i = 0; i < 8; i++)
        if (valid[i])
            CHECK(near(rows[16 + i], spline(prims[i] % 4, prims[i] / 4, u[i], v[i], 0, 0), 2e-5) &&
                      near(slopes[16 + i], spline(prims[i] % 4, prims[i] / 4, u[i], v[i], 0, 1), 2e-5),
                  "point %d of eight", i);
    CHECK(rows[2] == 77 && rows[10] == 77 && rows[18] == 77, "nothing is written for points that do not count");
    rtcReleaseScene(scene);
    rtcReleaseGeometry(geometry);
}

/* Where a hit is by its parameters. */
static double off(RTCGeometry geometry, const struct RTCRayHit *hit)
{
    float jet[6][4];
    double sum = 0;
    between(geometry, hit->hit.primID, hit->hit.u, hit->hit.v, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
    const float *org = &hit->ray.org_x, *dir = &hit->ray.dir_x;
    for (int k = 0; k < 3; k++)
        sum += pow(org[k] + hit->ray.tfar * dir[k] - jet[0][k], 2);
    return sqrt(sum);
}

/* From inside, all rays hit, and parameters are those of the place. */
static void inside(RTCGeometry geometry, const char *what, double most)
{
    RTCScene scene = committed_with(geometry);
    int hits = 0;
    double worst = 0;
    for (int i = 0; i < 4000; i++) {
        float org[3] = { 0.1f, 0.05f, -0.03f }, dir[3];
        for (int k = 0; k < 3; k++)
            dir[k] = i < 3000 ? number() - 0.5f : (float)((int)(7 * number()) - 3) / 3;
        if (dir[0] == 0 && dir[1] == 0 && dir[2] == 0)
            dir[2] = 1;
        if (i % 2)
            org[0] = org[1] = org[2] = 0;
        struct RTCRayHit hit = shot_along(scene, org, dir, 0);
        hits += hit.hit.geomID == 0;
        if (hit.hit.geomID == 0) {
            double found = off(geometry, &hit);
            worst = found > worst ? found : worst;
        }
    }
    /* Embree's may miss at the ends of edges. */
    CHECK(hits == 4000 || (!is_ours && hits > 3980), "%s: %d of 4000 rays hit", what, hits);
    CHECK(worst < most, "%s: parameters are %g off", what, worst);
    rtcReleaseScene(scene);
}

static void closed(void)
{
    float jet[6][4];
    RTCGeometry geometry = geometry_of(&cube);
    rtcSetGeometryTessellationRate(geometry, 32);
    rtcCommitGeometry(geometry);
    between(geometry, 0, 0, 0, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
    CHECK(near(jet[0][0], -0.5, 1e-5) && near(jet[0][1], -0.5, 1e-5) && near(jet[0][2], 0.5, 1e-5),
          "the limit of a cube's corner is half of it: %g %g %g", jet[0][0], jet[0][1], jet[0][2]);
    inside(geometry, "a cube", 3e-3);
    /* Levels by edge: of the edge's direction. */
    float levels[24];
    for (int i = 0; i < 24; i++) {
        unsigned a = cube_indices[i], b = cube_indices[i % 4 == 3 ? i - 3 : i + 1];
        levels[i] = (a ^ b) == 1 ? 5 : (a ^ b) == 2 ? 1.5f : 12;
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, levels, 0, 4, 24);
    inside(geometry, "edges of three levels", 0.5);
    rtcReleaseGeometry(geometry);
    /* A prism over a pentagon, whose ends are no quadrangles, and one over a triangle. */
    for (int n = 3; n < 6; n += 2) {
        float points[10][4];
        unsigned counts[7], indices[30];
        int at = 0;
        for (int i = 0; i < 2 * n; i++) {
            double angle = 6.283185307179586 * (i % n) / n;
            points[i][0] = (float)cos(angle), points[i][1] = (float)sin(angle), points[i][2] = i < n ? -1 : 1;
        }
        for (int i = 0; i < n; i++) {
            counts[i] = 4;
            indices[at++] = i, indices[at++] = (i + 1) % n, indices[at++] = n + (i + 1) % n, indices[at++] = n + i;
        }
        counts[n] = counts[n + 1] = n;
        for (int i = 0; i < n; i++)
            indices[at++] = n - 1 - i;
        for (int i = 0; i < n; i++)
            indices[at++] = n + i;
        const struct mesh prism = { n + 2, at, 2 * n, counts, indices, (const float(*)[4])points };
        RTCGeometry geometry = geometry_of(&prism);
        rtcSetGeometryTessellationRate(geometry, 24);
        inside(geometry, n == 3 ? "a prism over a triangle" : "a prism over a pentagon", 6e-3);
        rtcReleaseGeometry(geometry);
    }
}

static void creases(void)
{
    unsigned edges[12][2], corners[8];
    float weights[12], corner_weights[8];
    int count = 0;
    for (unsigned a = 0; a < 8; a++) {
        corners[a] = a, corner_weights[a] = INFINITY;
        for (unsigned b = a + 1; b < 8; b++)
            if ((a ^ b) == 1 || (a ^ b) == 2 || (a ^ b) == 4) {
                edges[count][0] = b, edges[count][1] = a;
                weights[count++] = INFINITY;
            }
    }
    RTCGeometry box = geometry_of(&cube);
    rtcSetSharedGeometryBuffer(box, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, 0, RTC_FORMAT_UINT2, edges, 0, 8, 12);
    rtcSetSharedGeometryBuffer(box, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT, weights, 0, 4, 12);
    RTCScene scene = committed_with(box);
    struct RTCBounds bounds;
    rtcGetSceneBounds(scene, &bounds);
    CHECK(near(bounds.upper_x, 1, 1e-4) && near(bounds.lower_y, -1, 1e-4), "sharp edges keep a box");
    CHECK(near(down(scene, 0.9f, 0.85f, 0).ray.tfar, 9, is_ours ? 1e-5 : 0.1), "its top is flat");
    rtcReleaseScene(scene);
    rtcReleaseGeometry(box);
    box = geometry_of(&cube);
    rtcSetSharedGeometryBuffer(box, RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, 0, RTC_FORMAT_UINT, corners, 0, 4, 7);
    rtcSetSharedGeometryBuffer(box, RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT, corner_weights, 0, 4, 7);
    scene = committed_with(box);
    float jet[6][4];
    between(box, 0, 0, 0, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
    CHECK(near(jet[0][0], -1, 1e-4) && near(jet[0][2], 1, 1e-4), "a sharp vertex stays");
    between(box, 0, 1, 1, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
    CHECK(near(jet[0][0], 0.5, 0.1) && jet[0][0] < 0.9f, "the eighth does not: %g", jet[0][0]);
    rtcReleaseScene(scene);
    rtcReleaseGeometry(box);
}

static void modes(void)
{
    static const unsigned counts[1] = { 4 }, indices[4] = { 0, 1, 2, 3 };
    static const float points[4][4] = { { 0, 0, 0, 0 }, { 3, 0, 0, 0 }, { 3, 3, 0, 0 }, { 0, 3, 1.5f, 0 } };
    const struct mesh quad = { 1, 4, 4, counts, indices, points };
    /* The limit of the first corner along x; that of the middle of the last edge along z. */
    static const double corner[5] = { 0, 0.5, 0, 0, 0 };
    for (int mode = 1; mode < 5; mode++) {
        RTCGeometry geometry = geometry_of(&quad);
        rtcSetGeometrySubdivisionMode(geometry, 0, (enum RTCSubdivisionMode)mode);
        rtcSetGeometryTessellationRate(geometry, 8);
        RTCScene scene = committed_with(geometry);
        float jet[6][4];
        between(geometry, 0, 0, 0, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
        CHECK(near(jet[0][0], corner[mode], 1e-4), "mode %d: the corner is at %g", mode, jet[0][0]);
        between(geometry, 0, 0, 0.25f, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
        CHECK((mode == 1) == !near(jet[0][1], 0.75, 1e-3), "mode %d: a quarter of an edge is at %g", mode, jet[0][1]);
        CHECK(down(scene, 1.5f, 1.6f, 0).hit.geomID == 0, "mode %d is seen", mode);
        rtcReleaseScene(scene);
        rtcReleaseGeometry(geometry);
    }
    RTCGeometry geometry = geometry_of(&sheet);
    rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_NO_BOUNDARY);
    RTCScene scene = committed_with(geometry);
    CHECK(down(scene, 0.5f, 1.5f, 0).hit.geomID != 0 && down(scene, 1.5f, 1.6f, 0).hit.primID == 5,
          "faces at the boundary are not seen, others are");
    rtcReleaseScene(scene);
    /* Without a face in the middle. */
    unsigned holes[1] = { 5 };
    rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_HOLE, 0, RTC_FORMAT_UINT, holes, 0, 4, 1);
    scene = committed_with(geometry);
    CHECK(down(scene, 1.5f, 1.5f, 0).hit.geomID != 0 && down(scene, 2.5f, 1.6f, 0).hit.primID == 6, "a hole");
    rtcReleaseScene(scene);
    rtcReleaseGeometry(geometry);
}

static RTCGeometry displaced;
static int calls, bad_calls;

static void displace(const struct RTCDisplacementFunctionNArguments *args)
{
    bool good = args->geometry == displaced && args->geometryUserPtr == heights && args->primID < 6 && args->timeStep < 2;
    const void *arrays[8] = { args->u, args->v, args->Ng_x, args->Ng_y, args->Ng_z, args->P_x, args->P_y, args->P_z };
    for (int i = 0; i < 8; i++)
        good = good && (uintptr_t)arrays[i] % 64 == 0;
    for (unsigned i = 0; i < args->N; i++) {
        float normal[3] = { args->Ng_x[i], args->Ng_y[i], args->Ng_z[i] }, jet[6][4];
        float *p[3] = { args->P_x + i, args->P_y + i, args->P_z + i };
        between(args->geometry, args->primID, args->u[i], args->v[i], RTC_BUFFER_TYPE_VERTEX, args->timeStep, jet, 3);
        double length = 0;
        for (int k = 0; k < 3; k++) {
            good = good && near(*p[k], jet[0][k], 1e-3);
            length += normal[k] * normal[k];
            *p[k] += 0.25f * normal[k];
        }
        good = good && near(length, 1, 1e-3);
        /* Outwards, as the surface is about the origin, or about (0, 0, 3). */
        double middle = args->timeStep ? 3 : 0;
        good = good && normal[0] * jet[0][0] + normal[1] * jet[0][1] + normal[2] * (jet[0][2] - middle) > 0;
    }
    __atomic_fetch_add(good ? &calls : &bad_calls, 1, __ATOMIC_RELAXED);
}

static void moved(void)
{
    float later[8][4];
    memcpy(later, cube_points, sizeof later);
    for (int i = 0; i < 8; i++)
        later[i][2] += 3;
    RTCGeometry geometry = displaced = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    rtcSetGeometryTimeStepCount(geometry, 2);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, cube_points, 0, 16, 8);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, later, 0, 16, 8);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, cube_counts, 0, 4, 6);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, cube_indices, 0, 4, 24);
    rtcSetGeometryTessellationRate(geometry, 8);
    rtcSetGeometryUserData(geometry, heights);
    RTCScene scene = committed_with(geometry);
    float jet[6][4];
    between(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX, 0, jet, 3);
    double top = jet[0][2];
    for (int i = 0; i < 3; i++) {
        float time = 0.5f * i;
        CHECK(near(10 - down(scene, 0.001f, 0.002f, time).ray.tfar, top + 3 * time, 1e-3), "at time %g", time);
    }
    rtcSetGeometryDisplacementFunction(geometry, displace);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    CHECK(bad_calls == 0 && calls >= 12, "%d calls are wrong, %d right", bad_calls, calls);
    CHECK(near(10 - down(scene, 0.001f, 0.002f, 0.5f).ray.tfar, top + 1.75, 2e-3), "moved by the program");
    /* Another commit, without it, and one with it as it is. */
    int before = calls;
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_COMPACT);
    rtcCommitScene(scene);
    CHECK(!is_ours || calls == before, "a surface that was not edited is cut once");
    CHECK(near(10 - down(scene, 0.001f, 0.002f, 0.5f).ray.tfar, top + 1.75, 2e-3), "and is still there");
    rtcSetGeometryDisplacementFunction(geometry, NULL);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    CHECK(near(10 - down(scene, 0.001f, 0.002f, 0.5f).ray.tfar, top + 1.5, 2e-3), "not moved by the program");
    rtcReleaseScene(scene);
    rtcReleaseGeometry(geometry);
}

/* A second topology, in which all faces have vertices of their own. */
static void attributes(void)
{
    float uvs[64][2], doubles[25][2];
    unsigned own[64];
    for (int i = 0; i < 64; i++) {
        own[i] = 63 - i;
        uvs[63 - i][0] = i % 4 == 1 || i % 4 == 2, uvs[63 - i][1] = i % 4 > 1;
    }
    for (int i = 0; i < 25; i++)
        doubles[i][0] = 2 * heights[i][0], doubles[i][1] = 2 * heights[i][2];
    RTCGeometry geometry = geometry_of(&sheet);
    rtcSetGeometryTopologyCount(geometry, 2);
    rtcSetGeometryVertexAttributeCount(geometry, 2);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 1, RTC_FORMAT_UINT, own, 0, 4, 64);
    rtcSetGeometrySubdivisionMode(geometry, 1, RTC_SUBDIVISION_MODE_PIN_ALL);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, RTC_FORMAT_FLOAT2, doubles, 0, 8, 25);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 1, RTC_FORMAT_FLOAT2, uvs, 0, 8, 64);
    rtcSetGeometryVertexAttributeTopology(geometry, 1, 1);
    rtcCommitGeometry(geometry);
    RTCScene scene = committed_with(geometry);
    for (int i = 0; i < 40; i++) {
        float u = number(), v = number(), jet[6][4], position[6][4];
        unsigned prim = i % 16;
        between(geometry, prim, u, v, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 1, jet, 2);
        CHECK(near(jet[0][0], u, 1e-5) && near(jet[0][1], v, 1e-5) && near(jet[1][0], 1, 1e-5) && near(jet[1][1], 0, 1e-5),
              "face %u at %g, %g: %g, %g", prim, u, v, jet[0][0], jet[0][1]);
        between(geometry, prim, u, v, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, jet, 2);
        between(geometry, prim, u, v, RTC_BUFFER_TYPE_VERTEX, 0, position, 3);
        CHECK(near(jet[0][0], 2 * position[0][0], 1e-4) && near(jet[2][1], 2 * position[2][2], 1e-3), "twice the position");
    }
    CHECK(rtcGetGeometryOppositeHalfEdge(geometry, 0, 1) == 7 && rtcGetGeometryOppositeHalfEdge(geometry, 1, 1) == 1,
          "faces meet in one topology");
    rtcReleaseScene(scene);
    rtcReleaseGeometry(geometry);
}

static void half_edges(void)
{
    /* A quadrangle, a triangle, a quadrangle in a row. */
    static const unsigned counts[3] = { 4, 3, 4 }, indices[11] = { 0, 1, 2, 3, 1, 4, 2, 4, 5, 6, 2 };
    static const float points[7][4] = { { 0, 0, 0, 0 }, { 1, 0, 0, 0 }, { 1, 1, 0, 0 }, { 0, 1, 0, 0 },
                                        { 2, 0, 0, 0 }, { 3, 0, 0, 0 }, { 3, 1, 0, 0 } };
    const struct mesh row = { 3, 11, 7, counts, indices, points };
    RTCGeometry geometry = geometry_of(&row);
    RTCScene scene = committed_with(geometry);
    static const unsigned first[3] = { 0, 4, 7 }, opposite[11] = { 0, 6, 2, 3, 4, 10, 1, 7, 8, 9, 5 };
    for (unsigned face = 0; face < 3; face++)
        CHECK(rtcGetGeometryFirstHalfEdge(geometry, face) == first[face], "the first of face %u", face);
    for (unsigned edge = 0; edge < 11; edge++) {
        unsigned face = edge < 4 ? 0 : edge < 7 ? 1 : 2, end = first[face] + counts[face];
        CHECK(rtcGetGeometryFace(geometry, edge) == face, "the face of %u", edge);
        CHECK(rtcGetGeometryNextHalfEdge(geometry, edge) == (edge + 1 == end ? first[face] : edge + 1), "behind %u", edge);
        CHECK(rtcGetGeometryPreviousHalfEdge(geometry, edge) == (edge == first[face] ? end - 1 : edge - 1), "before %u",
              edge);
        CHECK(rtcGetGeometryOppositeHalfEdge(geometry, 0, edge) == opposite[edge], "opposite of %u: %u", edge,
              rtcGetGeometryOppositeHalfEdge(geometry, 0, edge));
    }
    rtcReleaseScene(scene);
    rtcReleaseGeometry(geometry);
}

static void expect(enum RTCError code, const char *what)
{
    enum RTCError found = rtcGetDeviceError(device);
    CHECK(found == code, "%s: %s", what, rtcGetErrorString(found));
}

static void errors(void)
{
    expect(RTC_ERROR_NONE, "so far");
    RTCGeometry geometry = geometry_of(&cube), mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometrySubdivisionMode(geometry, 0, (enum RTCSubdivisionMode)9);
    expect(RTC_ERROR_INVALID_ARGUMENT, "a mode that is none");
    rtcSetGeometrySubdivisionMode(geometry, 1, RTC_SUBDIVISION_MODE_PIN_ALL);
    expect(RTC_ERROR_INVALID_OPERATION, "a second topology of one");
    rtcSetGeometryTopologyCount(geometry, 0);
    expect(RTC_ERROR_INVALID_OPERATION, "no topology");
    rtcSetGeometryVertexAttributeTopology(geometry, 0, 0);
    expect(RTC_ERROR_INVALID_OPERATION, "an attribute of none");
    rtcSetGeometryTopologyCount(mesh, 2);
    expect(RTC_ERROR_INVALID_OPERATION, "topologies of triangles");
    rtcSetGeometryDisplacementFunction(mesh, displace);
    expect(RTC_ERROR_INVALID_OPERATION, "displacement of triangles");
    rtcSetGeometryTessellationRate(mesh, 4);
    expect(RTC_ERROR_INVALID_OPERATION, "a rate of triangles");
    CHECK(rtcGetGeometryFace(mesh, 0) == RTC_INVALID_GEOMETRY_ID, "no half edge");
    expect(RTC_ERROR_INVALID_OPERATION, "half edges of triangles");
    CHECK(rtcGetGeometryNextHalfEdge(geometry, 24) == RTC_INVALID_GEOMETRY_ID, "behind the last");
    expect(RTC_ERROR_INVALID_ARGUMENT, "a half edge out of range");
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_FLOAT, cube_points, 0, 4, 6);
    expect(RTC_ERROR_INVALID_OPERATION, "counts as floats");
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, 0, RTC_FORMAT_UINT2, cube_indices, 0, 8, 2);
    rtcReleaseScene(committed_with(geometry));
    expect(RTC_ERROR_INVALID_OPERATION, "creases without weights");
    rtcReleaseGeometry(geometry);
    geometry = geometry_of(&cube);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, cube_indices, 0, 4, 23);
    rtcReleaseScene(committed_with(geometry));
    expect(RTC_ERROR_INVALID_OPERATION, "fewer corners than the faces have");
    rtcReleaseGeometry(geometry);
    geometry = geometry_of(&sheet);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, sheet_counts, 0, 4, 6);
    rtcReleaseScene(committed_with(geometry));
    expect(RTC_ERROR_NONE, "more corners than the faces have");
    rtcReleaseGeometry(geometry);
    /* Faces that cannot be are left out. */
    unsigned counts[6] = { 4, 4, 4, 2, 2, 8 }, indices[24];
    memcpy(indices, cube_indices, sizeof indices);
    indices[5] = 77, indices[9] = indices[8];
    const struct mesh bad = { 6, 24, 8, counts, indices, (const float(*)[4])cube_points };
    geometry = geometry_of(&bad);
    RTCScene scene = committed_with(geometry);
    expect(RTC_ERROR_NONE, "bad faces");
    CHECK(down(scene, 0.1f, 0.05f, 0).hit.primID == 0, "one face of six");
    rtcReleaseScene(scene);
    rtcReleaseGeometry(geometry);
    rtcReleaseGeometry(mesh);
}

int main(int count, char **arguments)
{
    (void)arguments;
    device = rtcNewDevice(NULL);
    is_ours = count == 1;
    CHECK(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_SUBDIVISION_GEOMETRY_SUPPORTED) == 1, "the device says so");
    fill();
    splines();
    closed();
    creases();
    modes();
    moved();
    attributes();
    half_edges();
    if (is_ours)
        errors();
    rtcReleaseDevice(device);
    return finish();
}
