/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the calls of Embree do, checked by the definition. Runs on Embree's own library as well, with an argument: which errors
 * there are, and when, is ours. */
#include "scenes.h"

static int reported;

static void on_error(void *user, enum RTCError code, const char *message)
{
    CHECK(user == &reported && code != RTC_ERROR_NONE && message[0], "an error is told with its pointer and a message");
    reported++;
}

/* The next error is expected. */
static void expect(enum RTCError code, const char *what)
{
    enum RTCError found = rtcGetDeviceError(device);
    CHECK(found == code, "%s: %s", what, rtcGetErrorString(found));
    CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE, "%s: it is told once", what);
}

static struct RTCRayHit ray(float ox, float oy, float oz, float dx, float dy, float dz)
{
    struct RTCRayHit all;
    memset(&all, 0, sizeof all);
    all.ray.org_x = ox, all.ray.org_y = oy, all.ray.org_z = oz;
    all.ray.dir_x = dx, all.ray.dir_y = dy, all.ray.dir_z = dz;
    all.ray.tfar = INFINITY;
    all.ray.mask = -1;
    all.hit.geomID = all.hit.primID = all.hit.instID[0] = all.hit.instPrimID[0] = RTC_INVALID_GEOMETRY_ID;
    return all;
}

enum { TRIANGLES = 300, RAYS = 600 };
static float soup[3 * TRIANGLES + 2][4];
static unsigned soup_indices[TRIANGLES][3];

static RTCGeometry new_soup(void)
{
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    for (int i = 0; i < TRIANGLES; i++) {
        float at[3] = { number(), number(), number() };
        for (int corner = 0; corner < 3; corner++) {
            for (int k = 0; k < 3; k++)
                soup[3 * i + corner][k] = at[k] + 0.3f * (number() - 0.5f);
            soup_indices[i][corner] = 3 * i + corner;
        }
    }
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, soup, 0, 16, 3 * TRIANGLES);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, soup_indices, 0, 12, TRIANGLES);
    rtcSetGeometryMask(mesh, 0x6);
    return mesh;
}

static double brute(const struct RTCRay *r, int *prim)
{
    double best = INFINITY;
    for (int i = 0; i < TRIANGLES; i++) {
        double t = meets(soup[3 * i], soup[3 * i + 1], soup[3 * i + 2], &r->org_x, &r->dir_x);
        if (t >= r->tnear && t <= r->tfar && t < best)
            best = t, *prim = i;
    }
    return best;
}

static struct RTCRayHit random_ray(void)
{
    struct RTCRayHit r = ray(3 * number() - 1, 3 * number() - 1, -1, 0, 0, 0);
    r.ray.dir_x = number() - r.ray.org_x, r.ray.dir_y = number() - r.ray.org_y, r.ray.dir_z = number() + 1;
    return r;
}

/* Single rays and packets of all sizes against brute force, with a hole in each packet. */
static void triangles(void)
{
    RTCScene scene = committed(new_soup());
    int hits = 0;
    struct RTCRayHit all[RAYS];
    for (int i = 0; i < RAYS; i++) {
        struct RTCRayHit r = random_ray();
        int prim = -1;
        double t = brute(&r.ray, &prim);
        struct RTCRay shadow = r.ray;
        all[i] = r;
        rtcIntersect1(scene, &r, NULL);
        rtcOccluded1(scene, &shadow, NULL);
        CHECK((t < INFINITY) == (r.hit.geomID == 0), "ray %d: %g, %g", i, t, r.ray.tfar);
        CHECK((t < INFINITY) == (shadow.tfar == -INFINITY), "shadow %d: %g", i, shadow.tfar);
        if (t == INFINITY)
            continue;
        hits++;
        CHECK(fabs(t - r.ray.tfar) < 1e-5 * t, "ray %d: %g, not %g", i, r.ray.tfar, t);
        CHECK((int)r.hit.primID == prim && r.hit.instID[0] == RTC_INVALID_GEOMETRY_ID, "ray %d", i);
        float *p0 = soup[3 * prim], *p1 = soup[3 * prim + 1], *p2 = soup[3 * prim + 2];
        double e1[3], e2[3], n[3];
        for (int k = 0; k < 3; k++)
            e1[k] = p1[k] - p0[k], e2[k] = p2[k] - p0[k];
        cross(e1, e2, n);
        CHECK(fabs(n[0] - r.hit.Ng_x) + fabs(n[1] - r.hit.Ng_y) + fabs(n[2] - r.hit.Ng_z) < 1e-6, "normal %d", i);
        double x = p0[0] + r.hit.u * e1[0] + r.hit.v * e2[0];
        CHECK(fabs(x - (r.ray.org_x + r.ray.tfar * r.ray.dir_x)) < 1e-5, "u, v of %d", i);
        /* Seen by masks with a bit in common only. */
        struct RTCRayHit masked = all[i];
        masked.ray.mask = 0x9;
        rtcIntersect1(scene, &masked, NULL);
        CHECK(masked.hit.geomID == RTC_INVALID_GEOMETRY_ID && masked.ray.tfar == INFINITY, "mask of %d", i);
    }
    CHECK(hits > RAYS / 4 && hits < RAYS, "%d of %d rays hit", hits, RAYS);
#define PACKETS(n, seen, hidden)                                                                                      \
    for (int first = 0; first + n <= RAYS; first += n) {                                                              \
        struct RTCRayHit##n packet;                                                                                   \
        struct RTCRay##n shadows;                                                                                     \
        int valid[n] __attribute__((aligned(64)));                                                                    \
        memset(&packet, 0xff, sizeof packet);                                                                         \
        for (int i = 0; i < n; i++) {                                                                                 \
            struct RTCRay *r = &all[first + i].ray;                                                                   \
            valid[i] = i == 2 ? 0 : -1;                                                                               \
            packet.ray.org_x[i] = r->org_x, packet.ray.org_y[i] = r->org_y, packet.ray.org_z[i] = r->org_z;          \
            packet.ray.dir_x[i] = r->dir_x, packet.ray.dir_y[i] = r->dir_y, packet.ray.dir_z[i] = r->dir_z;          \
            packet.ray.tnear[i] = 0, packet.ray.tfar[i] = INFINITY, packet.ray.time[i] = 0;                           \
        }                                                                                                             \
        shadows = packet.ray;                                                                                         \
        rtcIntersect##n(valid, scene, &packet, seen);                                                                 \
        rtcOccluded##n(valid, scene, &shadows, hidden);                                                               \
        for (int i = 0; i < n; i++) {                                                                                 \
            struct RTCRayHit one = all[first + i];                                                                    \
            if (valid[i])                                                                                             \
                rtcIntersect1(scene, &one, NULL);                                                                     \
            CHECK(fabsf(one.ray.tfar - packet.ray.tfar[i]) < 1e-5f || one.ray.tfar == packet.ray.tfar[i], "t " #n);  \
            CHECK(one.hit.primID == packet.hit.primID[i] && one.hit.geomID == packet.hit.geomID[i], "ids " #n);      \
            CHECK((one.hit.geomID == 0) == (shadows.tfar[i] == -INFINITY), "shadow " #n);                             \
        }                                                                                                             \
    }
    struct RTCIntersectArguments together;
    struct RTCOccludedArguments also;
    rtcInitIntersectArguments(&together);
    rtcInitOccludedArguments(&also);
    together.flags = also.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    PACKETS(4, NULL, NULL)
    PACKETS(8, NULL, NULL)
    PACKETS(16, NULL, NULL)
    PACKETS(4, &together, &also)
    PACKETS(8, &together, &also)
    PACKETS(16, &together, &also)
    rtcReleaseScene(scene);
}

static int seen;
static void every_second(const struct RTCFilterFunctionNArguments *args)
{
    struct RTCHit *hit = (struct RTCHit *)args->hit;
    struct RTCRay *r = (struct RTCRay *)args->ray;
    CHECK(args->N == 1 && args->valid[0] == -1 && args->geometryUserPtr == &seen, "a filter of one ray");
    CHECK(args->context->instID[0] == RTC_INVALID_GEOMETRY_ID && r->tfar < INFINITY, "with its context and distance");
    seen++;
    if (hit->primID % 2)
        args->valid[0] = 0;
}

static void of_arguments(const struct RTCFilterFunctionNArguments *args)
{
    if (((struct RTCHit *)args->hit)->primID % 3)
        args->valid[0] = 0;
}

/* Asked of each hit once, however leaves list triangles. */
static int asked_of[TRIANGLES];
static void none(const struct RTCFilterFunctionNArguments *args)
{
    asked_of[((struct RTCHit *)args->hit)->primID]++;
    args->valid[0] = 0;
}

static void filters_once(void)
{
    RTCGeometry mesh = new_soup();
    rtcSetGeometryOccludedFilterFunction(mesh, none);
    RTCScene scene = committed(mesh);
    for (int i = 0; i < RAYS; i++) {
        struct RTCRay r = random_ray().ray;
        memset(asked_of, 0, sizeof asked_of);
        rtcOccluded1(scene, &r, NULL);
        for (int p = 0; p < TRIANGLES; p++) {
            double t = meets(soup[3 * p], soup[3 * p + 1], soup[3 * p + 2], &r.org_x, &r.dir_x);
            CHECK(asked_of[p] == (t >= 0 && t < INFINITY), "ray %d, triangle %d: asked %d times", i, p, asked_of[p]);
        }
    }
    rtcReleaseScene(scene);
}

static void filters(void)
{
    RTCGeometry mesh = new_soup();
    rtcSetGeometryIntersectFilterFunction(mesh, every_second);
    rtcSetGeometryOccludedFilterFunction(mesh, every_second);
    rtcSetGeometryUserData(mesh, &seen);
    RTCScene scene = committed(mesh);
    int hits = 0;
    for (int i = 0; i < RAYS; i++) {
        struct RTCRayHit r = random_ray(), again = r;
        struct RTCRay shadow = r.ray;
        double t = INFINITY, both = INFINITY;
        for (int p = 0; p < TRIANGLES; p += 2) {
            double at = meets(soup[3 * p], soup[3 * p + 1], soup[3 * p + 2], &r.ray.org_x, &r.ray.dir_x);
            if (at >= 0 && at < t)
                t = at;
            if (p % 3 == 0 && at >= 0 && at < both)
                both = at;
        }
        rtcIntersect1(scene, &r, NULL);
        rtcOccluded1(scene, &shadow, NULL);
        CHECK((t < INFINITY) == (r.hit.geomID == 0), "ray %d: %g, %g", i, t, r.ray.tfar);
        CHECK(t == INFINITY || fabs(t - r.ray.tfar) < 1e-5 * t, "ray %d: %g, not %g", i, r.ray.tfar, t);
        CHECK((t < INFINITY) == (shadow.tfar < 0), "shadow %d", i);
        hits += t < INFINITY;
        struct RTCIntersectArguments args;
        rtcInitIntersectArguments(&args);
        args.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
        args.filter = of_arguments;
        rtcIntersect1(scene, &again, &args);
        CHECK((both < INFINITY) == (again.hit.geomID == 0), "both filters, ray %d", i);
        CHECK(both == INFINITY || fabs(both - again.ray.tfar) < 1e-5 * both, "both filters, ray %d", i);
    }
    CHECK(hits > 50 && seen > hits, "%d hits, %d asked for", hits, seen);
    rtcReleaseScene(scene);
}

/* Balls of the program's. */
static const float balls[3][4] = { { 0, 0, 0, 1 }, { 5, 0, 0, 2 }, { 0, 5, 0, 0.5f } };

static void ball_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const float *b = ((const float(*)[4])args->geometryUserPtr)[args->primID];
    struct RTCBounds *out = args->bounds_o;
    out->lower_x = b[0] - b[3], out->lower_y = b[1] - b[3], out->lower_z = b[2] - b[3];
    out->upper_x = b[0] + b[3], out->upper_y = b[1] + b[3], out->upper_z = b[2] + b[3];
}

static float ball_t(const struct RTCRay *r, const float *b)
{
    float o[3] = { r->org_x - b[0], r->org_y - b[1], r->org_z - b[2] };
    float a = r->dir_x * r->dir_x + r->dir_y * r->dir_y + r->dir_z * r->dir_z;
    float h = o[0] * r->dir_x + o[1] * r->dir_y + o[2] * r->dir_z;
    float c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - b[3] * b[3];
    float d = h * h - a * c;
    return d < 0 ? INFINITY : (-h - sqrtf(d)) / a;
}

static void ball_intersect(const struct RTCIntersectFunctionNArguments *args)
{
    if (!args->valid[0])
        return;
    const float *b = ((const float(*)[4])args->geometryUserPtr)[args->primID];
    struct RTCRayHit *all = (struct RTCRayHit *)args->rayhit;
    float t = ball_t(&all->ray, b);
    if (!(t > all->ray.tnear && t < all->ray.tfar))
        return;
    all->ray.tfar = t;
    all->hit.Ng_x = all->ray.org_x + t * all->ray.dir_x - b[0];
    all->hit.Ng_y = all->ray.org_y + t * all->ray.dir_y - b[1];
    all->hit.Ng_z = all->ray.org_z + t * all->ray.dir_z - b[2];
    all->hit.u = 0.25f, all->hit.v = 0.5f;
    all->hit.primID = args->primID, all->hit.geomID = args->geomID;
    all->hit.instID[0] = args->context->instID[0];
    all->hit.instPrimID[0] = args->context->instPrimID[0];
}

static void ball_occluded(const struct RTCOccludedFunctionNArguments *args)
{
    struct RTCRay *r = (struct RTCRay *)args->ray;
    float t = ball_t(r, ((const float(*)[4])args->geometryUserPtr)[args->primID]);
    if (args->valid[0] && t > r->tnear && t < r->tfar)
        r->tfar = -INFINITY;
}

static RTCGeometry new_balls(void)
{
    RTCGeometry user = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(user, 3);
    rtcSetGeometryUserData(user, (void *)balls);
    rtcSetGeometryBoundsFunction(user, ball_bounds, NULL);
    rtcSetGeometryIntersectFunction(user, ball_intersect);
    rtcSetGeometryOccludedFunction(user, ball_occluded);
    return user;
}

/* The same balls as user geometry and as spheres, alone, in an instance, and in an array of instances. */
static void balls_of_all_kinds(void)
{
    RTCGeometry points = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(points, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, balls, 0, 16, 3);
    RTCScene both[2] = { committed(new_balls()), committed(points) };
    for (int kind = 0; kind < 2; kind++) {
        /* Twice as large, and 10 to the right. */
        float matrix[12] = { 2, 0, 0, 0, 2, 0, 0, 0, 2, 10, 0, 0 };
        RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, both[kind]);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
        rtcCommitGeometry(instance);
        RTCGeometry array = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE_ARRAY);
        rtcSetGeometryInstancedScene(array, both[kind]);
        float(*places)[12] = rtcSetNewGeometryBuffer(array, RTC_BUFFER_TYPE_TRANSFORM, 0,
                                                     RTC_FORMAT_FLOAT3X4_ROW_MAJOR, sizeof(float[12]), 2);
        for (int i = 0; i < 2; i++) {
            float place[12] = { 1, 0, 0, -20 - 20.0f * i, 0, 1, 0, 0, 0, 0, 1, 0 };
            memcpy(places[i], place, sizeof place);
        }
        rtcCommitGeometry(array);
        RTCScene scene = rtcNewScene(device);
        rtcAttachGeometryByID(scene, instance, 7);
        rtcAttachGeometryByID(scene, array, 3);
        rtcReleaseGeometry(instance);
        rtcReleaseGeometry(array);
        rtcCommitScene(scene);
        struct {
            RTCScene scene;
            float x, t;
            unsigned prim, inst, inst_prim;
        } asked[] = {
            { both[kind], 0, 9, 0, -1, -1 },   { both[kind], 5, 8, 1, -1, -1 }, { both[kind], 8, INFINITY, -1, -1, -1 },
            { scene, 10, 8, 0, 7, -1 },        { scene, 20, 6, 1, 7, -1 },      { scene, -20, 9, 0, 3, 0 },
            { scene, -35, 8, 1, 3, 1 },        { scene, 0, INFINITY, -1, -1, -1 },
        };
        for (unsigned i = 0; i < sizeof asked / sizeof *asked; i++) {
            struct RTCRayHit r = ray(asked[i].x, 0, -10, 0, 0, 1);
            struct RTCRay shadow = r.ray;
            rtcIntersect1(asked[i].scene, &r, NULL);
            rtcOccluded1(asked[i].scene, &shadow, NULL);
            CHECK(fabsf(r.ray.tfar - asked[i].t) < 1e-4f || r.ray.tfar == asked[i].t, "%d.%u: %g", kind, i, r.ray.tfar);
            CHECK(r.hit.primID == asked[i].prim && r.hit.instID[0] == asked[i].inst, "%d.%u: %u", kind, i, r.hit.primID);
            CHECK((asked[i].t < INFINITY) == (shadow.tfar < 0), "%d.%u: shadow", kind, i);
            if (asked[i].inst_prim != -1u)
                CHECK(r.hit.instPrimID[0] == asked[i].inst_prim, "%d.%u: %u", kind, i, r.hit.instPrimID[0]);
            if (asked[i].t == INFINITY)
                continue;
            /* In the space of the instance. */
            float radius = balls[asked[i].prim][3];
            CHECK(fabsf(r.hit.Ng_z + radius) < 1e-3f && fabsf(r.hit.Ng_x) < 1e-3f, "%d.%u: %g", kind, i, r.hit.Ng_z);
            CHECK(kind == 1 || (r.hit.u == 0.25f && r.hit.v == 0.5f), "%d.%u: u, v", kind, i);
        }
        float back[16];
        rtcGetGeometryTransformFromScene(scene, 7, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, back);
        CHECK(back[0] == 2 && back[12] == 10 && back[15] == 1, "the place comes back");
        rtcGetGeometryTransformEx(rtcGetGeometry(scene, 3), 1, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, back);
        CHECK(back[3] == -40, "and that of one of an array");
        struct RTCBounds bounds;
        rtcGetSceneBounds(scene, &bounds);
        CHECK(fabsf(bounds.lower_x + 41) < 1e-3f && fabsf(bounds.upper_x - 24) < 1e-3f, "bounds: %g, %g", bounds.lower_x,
              bounds.upper_x);
        rtcReleaseScene(scene);
    }
    rtcReleaseScene(both[0]);
    rtcReleaseScene(both[1]);
}

/* Instances made by the program: a user geometry that sends its rays on. */
static RTCScene shown;

static void window_bounds(const struct RTCBoundsFunctionArguments *args)
{
    struct RTCBounds out = { 98, -9, -9, 0, 110, 9, 9, 0 };
    *args->bounds_o = out;
}

static void window_intersect(const struct RTCIntersectFunctionNArguments *args)
{
    struct RTCRay inner = *(struct RTCRay *)args->rayhit;
    inner.org_x -= 100;
    rtcForwardIntersect1(args, shown, &inner, args->geomID);
}

static void window_occluded(const struct RTCOccludedFunctionNArguments *args)
{
    struct RTCRay inner = *(struct RTCRay *)args->ray;
    inner.org_x -= 100;
    rtcForwardOccluded1(args, shown, &inner, args->geomID);
}

static void instances_of_the_program(void)
{
    shown = committed(new_balls());
    RTCGeometry window = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(window, 1);
    rtcSetGeometryBoundsFunction(window, window_bounds, NULL);
    rtcSetGeometryIntersectFunction(window, window_intersect);
    rtcSetGeometryOccludedFunction(window, window_occluded);
    rtcCommitGeometry(window);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometryByID(scene, window, 4);
    rtcReleaseGeometry(window);
    rtcCommitScene(scene);
    struct RTCRayHit r = ray(105, 0, -10, 0, 0, 1), miss = ray(108, 0, -10, 0, 0, 1);
    struct RTCRay shadow = r.ray, light = miss.ray;
    rtcIntersect1(scene, &r, NULL);
    CHECK(r.ray.tfar == 8 && r.hit.geomID == 0 && r.hit.primID == 1 && r.hit.instID[0] == 4, "t %g, geometry %u, instance %u",
          r.ray.tfar, r.hit.geomID, r.hit.instID[0]);
    CHECK(r.ray.org_x == 105, "the ray is as it was");
    rtcIntersect1(scene, &miss, NULL);
    CHECK(miss.hit.geomID == RTC_INVALID_GEOMETRY_ID && miss.ray.tfar == INFINITY, "nothing there");
    rtcOccluded1(scene, &shadow, NULL);
    rtcOccluded1(scene, &light, NULL);
    CHECK(shadow.tfar < 0 && light.tfar == INFINITY, "shadows");
    rtcReleaseScene(scene);
    rtcReleaseScene(shown);
}

struct nearest {
    double distance;
    unsigned prim, inst;
};

static bool nearer(struct RTCPointQueryFunctionArguments *args)
{
    struct nearest *best = args->userPtr;
    float p[3] = { args->query->x, args->query->y, args->query->z };
    float scale = 1;
    if (args->context->instStackSize) {
        float *m = args->context->world2inst[args->context->instStackSize - 1], q[3];
        for (int k = 0; k < 3; k++)
            q[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
        memcpy(p, q, sizeof p);
        scale = args->similarityScale;
        CHECK(fabsf(scale - 0.5f) < 1e-5f, "half as large inside: %g", scale);
    }
    const float *b = balls[args->primID];
    float dx = p[0] - b[0], dy = p[1] - b[1], dz = p[2] - b[2];
    double d = fabs(sqrtf(dx * dx + dy * dy + dz * dz) - b[3]) / scale;
    if (d >= args->query->radius)
        return false;
    best->distance = d, best->prim = args->primID, best->inst = args->context->instID[0];
    args->query->radius = d;
    return true;
}

static void points(void)
{
    RTCGeometry user = new_balls();
    RTCScene scene = committed(user), outer = rtcNewScene(device);
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    float matrix[12] = { 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 100 };
    rtcSetGeometryInstancedScene(instance, scene);
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
    rtcCommitGeometry(instance);
    rtcAttachGeometry(outer, instance);
    rtcReleaseGeometry(instance);
    rtcCommitScene(outer);
    for (int i = 0; i < 100; i++) {
        float x = 12 * number() - 3, y = 8 * number() - 2;
        struct RTCPointQuery query = { x, y, 0, 0, INFINITY }, far = { 2 * x, 2 * y, 100, 0, INFINITY };
        struct RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        struct nearest best = { 0, 0, 0 }, inside = best;
        CHECK(rtcPointQuery(scene, &query, &context, nearer, &best), "something is near");
        CHECK(rtcPointQuery(outer, &far, &context, nearer, &inside), "something is near");
        double least = INFINITY;
        for (int b = 0; b < 3; b++)
            least = fmin(least, fabs(hypot(x - balls[b][0], y - balls[b][1]) - balls[b][3]));
        CHECK(fabs(best.distance - least) < 1e-4 && best.inst == RTC_INVALID_GEOMETRY_ID, "%g, not %g", best.distance,
              least);
        CHECK(fabs(inside.distance - 2 * least) < 1e-3 && inside.inst == 0 && inside.prim == best.prim, "%g, not %g",
              inside.distance, 2 * least);
        CHECK(context.instStackSize == 0, "the stack is empty again");
    }
    rtcReleaseScene(outer);
    rtcReleaseScene(scene);
}

static bool counts(struct RTCPointQueryFunctionArguments *args)
{
    ++*(int *)args->userPtr;
    return false;
}

/* How often the program is shown primitives of a geometry around the origin; takes the geometry. */
static int shown_near(RTCGeometry geometry)
{
    RTCScene scene = committed(geometry);
    struct RTCPointQuery query = { 0, 0, 0, 0, INFINITY };
    struct RTCPointQueryContext context;
    int count = 0;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, counts, &count);
    rtcReleaseScene(scene);
    return count;
}

/* What Embree's own tests ask of odd arrays, and of what point queries show. */
static void odd_arrays(void)
{
    static const float rows[5][4] = { { -1, 0, -1, 1 }, { 1, 0, -1, 1 }, { 0, 0, 1, 1 }, { 5, 5, 5, 1 } };
    static const unsigned corners[2][3] = { { 0, 1, 2 } }, lines[2] = { 0, 1 };
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, rows, 0, 16, 3);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, corners, 0, 12, 1);
    rtcSetGeometryVertexAttributeCount(mesh, 1);
    /* Rows of five numbers, four apart. */
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, (enum RTCFormat)(RTC_FORMAT_FLOAT + 4), rows, 0, 16, 3);
    expect(RTC_ERROR_NONE, "rows may overlap");
    rtcCommitGeometry(mesh);
    float values[2];
    struct RTCInterpolateArguments args = { 0 };
    args.geometry = mesh, args.v = 1, args.bufferType = RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE;
    args.P = values, args.valueCount = 2;
    rtcInterpolate(&args);
    CHECK(values[0] == 0 && values[1] == 0, "of the third row: %g, %g", values[0], values[1]);
    CHECK(shown_near(mesh) == 1, "a triangle is shown once");
    RTCGeometry balls = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(balls, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, rows, 0, 16, 4);
    CHECK(shown_near(balls) == 0, "spheres are not shown");
    RTCGeometry ribbons = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE);
    rtcSetSharedGeometryBuffer(ribbons, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, rows, 0, 16, 4);
    rtcSetSharedGeometryBuffer(ribbons, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, lines, 0, 4, 2);
    CHECK(shown_near(ribbons) == 0, "lines are not shown");
    RTCGeometry nothing = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    CHECK(shown_near(nothing) == 0, "nothing is there");
    expect(RTC_ERROR_NONE, "without arrays a geometry is empty");
}

static void quads_and_values(void)
{
    static const float corners[6][3] = { { 0, 0, 0 }, { 2, 0, 0 }, { 2, 2, 0 }, { 0, 2, 0 } };
    static const unsigned quad[1][4] = { { 0, 1, 2, 3 } };
    static const float colours[4] = { 0, 10, 30, 20 };
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, corners, 0, 12, 4);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quad, 0, 16, 1);
    rtcSetGeometryVertexAttributeCount(mesh, 1);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, RTC_FORMAT_FLOAT, colours, 0, 4, 4);
    rtcRetainGeometry(mesh);
    RTCScene scene = committed(mesh);
    for (int i = 0; i < 50; i++) {
        float x = 2 * number(), y = 2 * number(), value, du, dv;
        struct RTCRayHit r = ray(x, y, 1, 0, 0, -1);
        rtcIntersect1(scene, &r, NULL);
        CHECK(fabsf(r.hit.u - x / 2) < 1e-5f && fabsf(r.hit.v - y / 2) < 1e-5f, "u, v are %g, %g", r.hit.u, r.hit.v);
        CHECK(r.hit.Ng_z == 4 && r.hit.Ng_x == 0, "the normal is that of a half: %g", r.hit.Ng_z);
        struct RTCInterpolateArguments args = { mesh, 0, r.hit.u, r.hit.v, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, &value, &du, &dv,
                                                NULL, NULL, NULL, 1 };
        rtcInterpolate(&args);
        CHECK(fabsf(value - 5 * x - 10 * y) < 1e-4f && du == 10 && dv == 20, "%g %g %g", value, du, dv);
    }
    rtcReleaseGeometry(mesh);
    rtcReleaseScene(scene);
}

/* Curves of each form and discs: values measured with Embree 4.4. */
static void curves_and_discs(void)
{
    static const float along[4][4] = { { 0, 0, 0, .2f }, { 1, 0, 0, .2f }, { 2, 0, 0, .2f }, { 3, 0, 0, .2f } };
    static const float up[4][3] = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } };
    static const unsigned first[1] = { 0 };
    static const struct {
        enum RTCGeometryType type;
        float t, u, v, ng[3];
    } expected[] = {
        { RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE, 5, .5f, .5f, { 1, 0, 0 } },
        { RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE, 4.8268f, .5f, 0, { 0, .5f, -.866f } },
        { RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BEZIER_CURVE, 5, .5f, .75f, { 0, 0, 1 } },
        { RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE, 4.8268f, .5f, 0, { 0, .5f, -.866f } },
    };
    for (int i = 0; i < 4; i++) {
        int is_line = expected[i].type == RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE;
        RTCGeometry curve = rtcNewGeometry(device, expected[i].type);
        /* A line takes the first vertex and the last one. */
        size_t stride = is_line ? 48 : 16;
        rtcSetSharedGeometryBuffer(curve, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, along, 0, stride, is_line ? 2 : 4);
        rtcSetSharedGeometryBuffer(curve, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, first, 0, 4, 1);
        if (expected[i].type == RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BEZIER_CURVE)
            rtcSetSharedGeometryBuffer(curve, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3, up, 0, 12, 4);
        RTCScene scene = committed(curve);
        struct RTCRayHit r = ray(1.5f, .1f, -5, 0, 0, 1);
        rtcIntersect1(scene, &r, NULL);
        float n = sqrtf(r.hit.Ng_x * r.hit.Ng_x + r.hit.Ng_y * r.hit.Ng_y + r.hit.Ng_z * r.hit.Ng_z);
        CHECK(fabsf(r.ray.tfar - expected[i].t) < 1e-4f, "curve %d is met at %g", i, r.ray.tfar);
        CHECK(fabsf(r.hit.u - expected[i].u) < 1e-4f && fabsf(r.hit.v - expected[i].v) < 1e-4f, "curve %d: u, v are %g, %g", i,
              r.hit.u, r.hit.v);
        CHECK(fabsf(r.hit.Ng_x / n - expected[i].ng[0]) < 1e-3f && fabsf(r.hit.Ng_y / n - expected[i].ng[1]) < 1e-3f,
              "curve %d: the normal is %g, %g, %g", i, r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z);
        r = ray(1.5f, 0, 0, 0, 0, 1);
        rtcIntersect1(scene, &r, NULL);
        /* Builds of Embree differ in whether a ray meets a ribbon that it starts on; here it does not. */
        CHECK(i == 0 || (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) != (i == 1 || i == 2), "from inside of curve %d", i);
        rtcReleaseScene(scene);
    }
    RTCGeometry disc = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
    static const float center[1][4] = { { 0, 0, 0, 1 } }, leaning[1][3] = { { 0, .6f, .8f } };
    rtcSetSharedGeometryBuffer(disc, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, center, 0, 16, 1);
    rtcSetSharedGeometryBuffer(disc, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3, leaning, 0, 12, 1);
    RTCScene scene = committed(disc);
    struct RTCRayHit r = ray(.5f, .2f, -3, 0, 0, 2);
    rtcIntersect1(scene, &r, NULL);
    CHECK(fabsf(r.ray.tfar - 1.425f) < 1e-5f && r.hit.Ng_z == .8f, "the disc is met at %g", r.ray.tfar);
    rtcReleaseScene(scene);
    expect(RTC_ERROR_NONE, "curves and discs are supported");
}

/* Vertices that move, geometries that come and go. */
static void edits(void)
{
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_DYNAMIC | RTC_SCENE_FLAG_COMPACT);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
    RTCGeometry meshes[2];
    for (int i = 0; i < 2; i++) {
        meshes[i] = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        float(*p)[3] = rtcSetNewGeometryBuffer(meshes[i], RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3);
        unsigned *indices = rtcSetNewGeometryBuffer(meshes[i], RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 1);
        float z = (float)i;
        float at[3][3] = { { -9, -9, z }, { 9, -9, z }, { 0, 9, z } };
        memcpy(p, at, sizeof at);
        indices[0] = 0, indices[1] = 1, indices[2] = 2;
        rtcSetGeometryBuildQuality(meshes[i], RTC_BUILD_QUALITY_REFIT);
        rtcCommitGeometry(meshes[i]);
        CHECK(rtcAttachGeometry(scene, meshes[i]) == (unsigned)i, "ids are given from 0 on");
    }
    struct RTCRayHit r;
    float wanted[] = { 5, 4.5f, 5, 4, 4.5f };
    unsigned ids[] = { 0, 0, 0, 1, 0 };
    for (int step = 0; step < 5; step++) {
        float(*p)[3] = rtcGetGeometryBufferData(meshes[0], RTC_BUFFER_TYPE_VERTEX, 0);
        switch (step) {
        case 1:
        case 4:
            p[0][2] = p[1][2] = p[2][2] = -0.5f;
            rtcUpdateGeometryBuffer(meshes[0], RTC_BUFFER_TYPE_VERTEX, 0);
            rtcCommitGeometry(meshes[0]);
            rtcEnableGeometry(meshes[0]);
            break;
        case 2:
            p[0][2] = p[1][2] = p[2][2] = 0;
            rtcUpdateGeometryBuffer(meshes[0], RTC_BUFFER_TYPE_VERTEX, 0);
            rtcCommitGeometry(meshes[0]);
            break;
        case 3:
            rtcDisableGeometry(meshes[0]);
            break;
        }
        rtcCommitScene(scene);
        r = ray(0, 0, -5, 0, 0, 1);
        if (step == 3)
            r.ray.dir_z = 1.5f, wanted[3] = 4;
        rtcIntersect1(scene, &r, NULL);
        CHECK(fabsf(r.ray.tfar - wanted[step]) < 1e-5f && r.hit.geomID == ids[step], "step %d: %g, %u", step, r.ray.tfar, r.hit.geomID);
    }
    rtcDetachGeometry(scene, 0);
    CHECK(rtcAttachGeometry(scene, meshes[0]) == 0, "an id is given again");
    for (int i = 0; i < 2; i++)
        rtcReleaseGeometry(meshes[i]);
    rtcReleaseScene(scene);
}

static ssize_t held, most;
static bool count_memory(void *user, ssize_t bytes, bool post)
{
    (void)post;
    CHECK(user == &held, "the monitor's pointer");
    held += bytes;
    most = held > most ? held : most;
    return true;
}

static double last_progress;
static bool progress(void *user, double done)
{
    CHECK(user == &last_progress && done >= last_progress && done <= 1, "progress grows: %g", done);
    last_progress = done;
    return true;
}

static bool stop(void *user, double done)
{
    (void)done;
    (void)user;
    return false;
}

static void monitors(void)
{
    rtcSetDeviceMemoryMonitorFunction(device, count_memory, &held);
    RTCGeometry mesh = new_soup();
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcSetSceneProgressMonitorFunction(scene, progress, &last_progress);
    rtcCommitScene(scene);
    CHECK(last_progress == 1 && most > 0, "progress %g, memory %zd", last_progress, most);
    rtcReleaseScene(scene);
    CHECK(held == 0, "all is given back: %zd", held);
    rtcSetDeviceMemoryMonitorFunction(device, NULL, NULL);
    expect(RTC_ERROR_NONE, "monitors");
    scene = rtcNewScene(device);
    mesh = new_soup();
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcSetSceneProgressMonitorFunction(scene, stop, NULL);
    rtcCommitScene(scene);
    expect(RTC_ERROR_CANCELLED, "a build that is stopped");
    rtcReleaseScene(scene);
}

static void errors(void)
{
    CHECK(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION) / 10000 == 4, "version 4");
    CHECK(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) == 1, "filters");
    expect(RTC_ERROR_NONE, "properties");
    rtcSetDeviceErrorFunction(device, on_error, &reported);
    RTCScene scene = rtcNewScene(device);
    CHECK(rtcNewGeometry(device, (enum RTCGeometryType)77) == NULL, "no such kind");
    expect(RTC_ERROR_INVALID_ARGUMENT, "no such kind");
    CHECK(strstr(rtcGetDeviceLastErrorMessage(device), "77"), "the message names it: %s", rtcGetDeviceLastErrorMessage(device));
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT2, soup, 0, 16, 3);
    expect(RTC_ERROR_INVALID_OPERATION, "a wrong format");
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, (char *)soup + 2, 0, 16, 3);
    expect(RTC_ERROR_INVALID_OPERATION, "a wrong alignment");
    rtcSetGeometryInstancedScene(mesh, scene);
    expect(RTC_ERROR_INVALID_OPERATION, "no instance");
    rtcAttachGeometry(scene, mesh);
    rtcCommitScene(scene);
    expect(RTC_ERROR_INVALID_OPERATION, "not committed");
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, soup, 0, 16, 3);
    rtcCommitGeometry(mesh);
    rtcCommitScene(scene);
    expect(RTC_ERROR_INVALID_OPERATION, "with vertices alone");
    rtcAttachGeometryByID(scene, mesh, 0);
    expect(RTC_ERROR_INVALID_OPERATION, "an id that is taken");
    CHECK(rtcGetGeometry(scene, 9) == NULL, "no such geometry");
    expect(RTC_ERROR_INVALID_ARGUMENT, "no such geometry");
    RTCBuffer buffer = rtcNewBuffer(device, 100);
    rtcSetGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, 0, 12, 9);
    expect(RTC_ERROR_INVALID_ARGUMENT, "behind the end of a buffer");
    rtcSetGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, 4, 12, 8);
    expect(RTC_ERROR_NONE, "up to the end of a buffer");
    rtcReleaseBuffer(buffer);
    struct RTCRayHit r = ray(0, 0, 0, 0, 0, 1);
    rtcIntersect1(scene, &r, NULL);
    expect(RTC_ERROR_INVALID_OPERATION, "a scene that was never committed");
    CHECK(rtcNewScene(NULL) == NULL && rtcGetDeviceError(NULL) == RTC_ERROR_INVALID_ARGUMENT, "no device");
    CHECK(reported == 10, "errors are told: %d", reported);
    rtcReleaseGeometry(mesh);
    rtcReleaseScene(scene);
}

int main(int count, char **arguments)
{
    (void)arguments;
    device = rtcNewDevice("threads=1");
    CHECK(device != NULL, "a device");
    triangles();
    filters();
    filters_once();
    balls_of_all_kinds();
    instances_of_the_program();
    points();
    odd_arrays();
    quads_and_values();
    curves_and_discs();
    edits();
    monitors();
    expect(RTC_ERROR_NONE, "all that went before");
    if (count == 1)
        errors();
    rtcReleaseDevice(device);
    return finish();
}
