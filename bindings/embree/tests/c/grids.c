/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Grids by the calls of Embree, against the same surface as quads; values along curves against closed forms. Runs on Embree's own
 * library as well, with an argument: errors are ours. */
#include "scenes.h"

static bool is_ours;

enum { GRIDS = 5, VERTICES = 600, STEPS = 2 };
static float vertices[STEPS][VERTICES][4];
static struct RTCGrid grids[GRIDS] = { { 0, 9, 9, 6 }, { 60, 20, 3, 3 }, { 63, 20, 2, 2 }, { 200, 31, 30, 12 }, { 575, 2, 1, 9 } };
static unsigned quads[2000][4];
static float places[2000][3];
static int quad_count;

static void fill(void)
{
    for (int i = 0; i < VERTICES; i++)
        for (int k = 0; k < 3; k++) {
            vertices[0][i][k] = number();
            vertices[1][i][k] = vertices[0][i][k] + 0.3f * number();
        }
    for (int g = 0; g < GRIDS; g++) {
        int width = grids[g].width, height = grids[g].height;
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                unsigned at = grids[g].startVertexID + y * grids[g].stride + x;
                /* A sheet of its own for each. */
                for (int step = 0; step < STEPS; step++) {
                    vertices[step][at][0] = (float)x / (width > 1 ? width - 1 : 1) + 0.02f * number();
                    vertices[step][at][1] = (float)y / (height - 1) + 0.02f * number();
                    vertices[step][at][2] = 0.2f * number() - g + step;
                }
                if (x + 1 < width && y + 1 < height) {
                    unsigned *quad = quads[quad_count];
                    quad[0] = at, quad[1] = at + 1;
                    quad[2] = at + grids[g].stride + 1, quad[3] = at + grids[g].stride;
                    places[quad_count][0] = g, places[quad_count][1] = x, places[quad_count][2] = y;
                    quad_count++;
                }
            }
    }
}

static RTCScene scene_of(bool is_grid, int steps, RTCGeometry *keep)
{
    RTCGeometry geometry = rtcNewGeometry(device, is_grid ? RTC_GEOMETRY_TYPE_GRID : RTC_GEOMETRY_TYPE_QUAD);
    rtcSetGeometryTimeStepCount(geometry, steps);
    for (int step = 0; step < steps; step++)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, vertices[step], 0, 16,
                                   VERTICES);
    if (is_grid)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, grids, 0, sizeof grids[0], GRIDS);
    else
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quads, 0, 16, quad_count);
    *keep = geometry;
    return committed_with(geometry);
}

static bool near(double a, double b, double off) { return fabs(a - b) <= off; }

static int filtered;

static void count(const struct RTCFilterFunctionNArguments *args)
{
    (void)args;
    filtered++;
}

static void rays(int steps)
{
    RTCGeometry grid, quad;
    RTCScene scene = scene_of(true, steps, &grid), other = scene_of(false, steps, &quad);
    struct RTCBounds a, b;
    rtcGetSceneBounds(scene, &a);
    rtcGetSceneBounds(other, &b);
    CHECK(near(a.lower_z, b.lower_z, 1e-5) && near(a.upper_x, b.upper_x, 1e-5), "the same box");
    int wrong = 0, found = 0, off = 0;
    for (int i = 0; i < 3000; i++) {
        struct RTCRayHit hits[2];
        memset(hits, 0, sizeof hits);
        for (int k = 0; k < 3; k++) {
            (&hits[0].ray.org_x)[k] = k < 2 ? 1.4f * number() - 0.2f : 3 - 6.5f * number();
            (&hits[0].ray.dir_x)[k] = k < 2 ? 0.4f * (number() - 0.5f) : -1;
        }
        hits[0].ray.tfar = INFINITY, hits[0].ray.mask = -1, hits[0].ray.time = number();
        hits[0].hit.geomID = hits[0].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        hits[1] = hits[0];
        rtcIntersect1(scene, &hits[0], NULL);
        rtcIntersect1(other, &hits[1], NULL);
        if (hits[0].hit.geomID != hits[1].hit.geomID || (hits[0].hit.geomID == 0 && !near(hits[0].ray.tfar, hits[1].ray.tfar, 1e-4))) {
            wrong++;
            continue;
        }
        if (hits[0].hit.geomID)
            continue;
        found++;
        const float *place = places[hits[1].hit.primID];
        const struct RTCGrid *g = &grids[(int)place[0]];
        bool same = hits[0].hit.primID == (unsigned)place[0] &&
                    near(hits[0].hit.u, (place[1] + hits[1].hit.u) / (g->width - 1), 2e-4) &&
                    near(hits[0].hit.v, (place[2] + hits[1].hit.v) / (g->height - 1), 2e-4) &&
                    near(hits[0].hit.Ng_x / hits[0].hit.Ng_z, hits[1].hit.Ng_x / hits[1].hit.Ng_z, 1e-3);
        off += !same;
        /* Where the parameters are. */
        if (steps == 1) {
            float p[4], du[4], dv[4];
            struct RTCInterpolateArguments args;
            memset(&args, 0, sizeof args);
            args.geometry = grid, args.primID = hits[0].hit.primID, args.u = hits[0].hit.u, args.v = hits[0].hit.v;
            args.bufferType = RTC_BUFFER_TYPE_VERTEX, args.P = p, args.dPdu = du, args.dPdv = dv, args.valueCount = 3;
            rtcInterpolate(&args);
            for (int k = 0; k < 3; k++)
                off += !near(p[k], (&hits[0].ray.org_x)[k] + hits[0].ray.tfar * (&hits[0].ray.dir_x)[k], 1e-3);
            off += is_ours && (!near(du[0], 1, 0.7) || !near(dv[1], 1, 0.3));
        }
    }
    /* Rays along an edge may fall to either side. */
    CHECK(wrong == 0 && found > 1000 && off <= (is_ours ? 0 : 6), "%d hits are wrong, %d of %d places", wrong, off, found);
    rtcSetGeometryIntersectFilterFunction(grid, count);
    rtcCommitGeometry(grid);
    rtcCommitScene(scene);
    struct RTCRayHit hit;
    memset(&hit, 0, sizeof hit);
    hit.ray.org_x = 0.41f, hit.ray.org_y = 0.53f, hit.ray.org_z = 9, hit.ray.dir_z = -1;
    hit.ray.tfar = INFINITY, hit.ray.mask = -1, filtered = 0;
    rtcIntersect1(scene, &hit, NULL);
    CHECK(filtered > 0 && hit.hit.primID == 0, "filters see grids");
    rtcReleaseGeometry(grid);
    rtcReleaseGeometry(quad);
    rtcReleaseScene(scene);
    rtcReleaseScene(other);
}

static unsigned near_grids, near_calls;

static bool look(struct RTCPointQueryFunctionArguments *args)
{
    near_grids |= 1u << args->primID;
    near_calls++;
    return false;
}

static void points(void)
{
    RTCGeometry grid;
    RTCScene scene = scene_of(true, 1, &grid);
    struct RTCPointQuery query = { 0.5f, 0.5f, -3, 0, 0.5f };
    struct RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, look, NULL);
    /* Embree shows parts of grids. */
    CHECK(near_grids == 8 && (near_calls == 1 || !is_ours), "grid 3 alone is near, once: %u, %u", near_grids, near_calls);
    rtcReleaseGeometry(grid);
    rtcReleaseScene(scene);
}

/* x goes from 0 to 3 evenly, y is a parabola: of B-splines, Bezier and Catmull-Rom curves. */
static void curves(void)
{
    static const enum RTCGeometryType types[5] = { RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE, RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE,
                                                   RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE,
                                                   RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE,
                                                   RTC_GEOMETRY_TYPE_ROUND_HERMITE_CURVE };
    float points[4][4], tangents[4][4];
    unsigned first[1] = { 0 };
    for (int i = 0; i < 4; i++) {
        points[i][0] = i, points[i][1] = i * i, points[i][2] = 0, points[i][3] = 0.1f;
        tangents[i][0] = 1, tangents[i][1] = 2 * i, tangents[i][2] = tangents[i][3] = 0;
    }
    for (int c = 0; c < 5; c++) {
        RTCGeometry curve = rtcNewGeometry(device, types[c]);
        rtcSetSharedGeometryBuffer(curve, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, points, 0, 16, 4);
        rtcSetSharedGeometryBuffer(curve, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, first, 0, 4, 1);
        if (c == 4)
            rtcSetSharedGeometryBuffer(curve, RTC_BUFFER_TYPE_TANGENT, 0, RTC_FORMAT_FLOAT4, tangents, 0, 16, 4);
        rtcCommitGeometry(curve);
        for (int i = 0; i <= 8; i++) {
            double t = i / 8.0;
            /* The place on the parabola: x and its derivative; how far the curve is above it. */
            double x = c == 0 ? 3 * t : c == 1 || c == 2 ? 1 + t : t, dx = c == 0 ? 3 : 1;
            double y = c == 0 ? 6 * t * t + 3 * t : c == 1 ? x * x + 1.0 / 3 : c == 3 ? t : x * x;
            double dy = c == 0 ? 12 * t + 3 : c == 3 ? 1 : 2 * x, ddy = c == 0 ? 12 : c == 3 ? 0 : 2;
            float p[4], du[4], dv[4], uu[4], vv[4], uv[4];
            struct RTCInterpolateArguments args;
            memset(&args, 0, sizeof args);
            args.geometry = curve, args.u = (float)t, args.bufferType = RTC_BUFFER_TYPE_VERTEX, args.valueCount = 4;
            args.P = p, args.dPdu = du, args.dPdv = dv, args.ddPdudu = uu, args.ddPdvdv = vv, args.ddPdudv = uv;
            rtcInterpolate(&args);
            CHECK(near(p[0], x, 1e-5) && near(p[1], y, 1e-5) && near(p[3], 0.1, 1e-5),
                  "curve %d at %g: %g %g %g", c, t, p[0], p[1], p[3]);
            /* Embree's writes no derivatives of straight curves. */
            CHECK((c == 3 && !is_ours) || (near(du[0], dx, 1e-5) && near(du[1], dy, 1e-5) && near(uu[1], ddy, 1e-4) && near(uu[0], 0, 1e-4)),
                  "derivatives of curve %d at %g: %g %g %g", c, t, du[0], du[1], uu[1]);
            CHECK(!is_ours || (dv[1] == 0 && vv[1] == 0 && uv[1] == 0), "nothing changes across");
        }
        rtcReleaseGeometry(curve);
    }
}

static void expect(enum RTCError code, const char *what)
{
    enum RTCError found = rtcGetDeviceError(device);
    CHECK(found == code, "%s: %s", what, rtcGetErrorString(found));
}

static void errors(void)
{
    expect(RTC_ERROR_NONE, "so far");
    RTCGeometry grid = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    rtcSetSharedGeometryBuffer(grid, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quads, 0, 16, 1);
    expect(RTC_ERROR_INVALID_OPERATION, "indices of grids");
    rtcSetSharedGeometryBuffer(grid, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_UINT3, grids, 0, 12, 1);
    expect(RTC_ERROR_INVALID_OPERATION, "grids of another format");
    rtcSetSharedGeometryBuffer(grid, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices[0], 0, 16, VERTICES);
    RTCScene scene = rtcNewScene(device);
    rtcCommitGeometry(grid);
    rtcAttachGeometry(scene, grid);
    rtcCommitScene(scene);
    expect(RTC_ERROR_INVALID_OPERATION, "no grid buffer");
    /* Vertices that are not there: such cells are left out. */
    struct RTCGrid far[2] = { { 595, 20, 5, 2 }, { 4000000000u, 4000000000u, 40, 30 } };
    rtcSetSharedGeometryBuffer(grid, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, far, 0, sizeof far[0], 2);
    rtcCommitGeometry(grid);
    rtcCommitScene(scene);
    expect(RTC_ERROR_NONE, "grids beyond the vertices");
    struct RTCBounds bounds;
    rtcGetSceneBounds(scene, &bounds);
    CHECK(bounds.lower_x > bounds.upper_x, "and nothing is seen");
    struct RTCInterpolateArguments args;
    float p[4];
    memset(&args, 0, sizeof args);
    args.geometry = grid, args.primID = 7, args.bufferType = RTC_BUFFER_TYPE_VERTEX, args.P = p, args.valueCount = 3;
    rtcInterpolate(&args);
    expect(RTC_ERROR_INVALID_ARGUMENT, "a grid out of range");
    args.primID = 1;
    rtcInterpolate(&args);
    expect(RTC_ERROR_INVALID_ARGUMENT, "a vertex out of range");
    struct RTCGrid many[5];
    for (int i = 0; i < 5; i++)
        many[i] = (struct RTCGrid){ 0, 0, 32767, 32767 };
    rtcSetSharedGeometryBuffer(grid, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, many, 0, sizeof many[0], 5);
    rtcCommitGeometry(grid);
    rtcCommitScene(scene);
    expect(RTC_ERROR_INVALID_OPERATION, "five thousand million cells");
    rtcReleaseGeometry(grid);
    rtcReleaseScene(scene);
}

int main(int arguments, char **values)
{
    (void)values;
    device = rtcNewDevice(NULL);
    is_ours = arguments == 1;
    fill();
    rays(1);
    rays(2);
    points();
    curves();
    if (is_ours)
        errors();
    rtcReleaseDevice(device);
    return finish();
}
