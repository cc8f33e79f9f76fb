/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A bumpy sphere as quads, as grids of 3 x 3 vertices and as one grid: memory, build and rays, for any library of Embree's names.
 *
 *   cc -O2 -I ../../bindings/embree/include grids.c -o grids -ldl -lm
 *   ./grids LIBRARY [SIDE] [RAYS] [compact]
 *
 * Processor time of one thread; millions of rays a second. Hits and sums of distances are to compare. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <gnurt/embree.h>

#define CALLS(call)                                                                                                    \
    call(rtcNewDevice) call(rtcNewScene) call(rtcNewGeometry) call(rtcSetSharedGeometryBuffer) call(rtcCommitGeometry)  \
    call(rtcAttachGeometry) call(rtcCommitScene) call(rtcIntersect1) call(rtcOccluded1) call(rtcIntersect16)            \
    call(rtcReleaseScene) call(rtcReleaseGeometry) call(rtcSetDeviceMemoryMonitorFunction) call(rtcSetSceneFlags)       \
    call(rtcReleaseDevice)
#define DECLARE(name) static __typeof__(name) *p_##name;
CALLS(DECLARE)
#define LOAD(name)                                                                                                     \
    if (!(*(void **)&p_##name = dlsym(library, #name))) {                                                              \
        fprintf(stderr, "no %s\n", #name);                                                                             \
        return 1;                                                                                                      \
    }

static long long held;

static bool monitor(void *of, ssize_t bytes, bool after)
{
    (void)of, (void)after;
    held += bytes;
    return true;
}

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

static unsigned long long state;

static float number(void)
{
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (float)(state >> 40) / (1 << 24);
}

static float (*vertices)[4];
static unsigned (*quads)[4];
static struct RTCGrid *grids;

static struct RTCRayHit make(bool coherent, int i, int side)
{
    struct RTCRayHit ray;
    memset(&ray, 0, sizeof ray);
    float *org = &ray.ray.org_x, *dir = &ray.ray.dir_x;
    for (int k = 0; k < 3; k++) {
        org[k] = coherent ? (k == 2 ? 4.0f : 0.0f) : 4 * (number() - 0.5f);
        dir[k] = coherent ? 0 : 2 * (number() - 0.5f) - org[k];
    }
    if (coherent)
        dir[0] = 0.6f * ((i % side + 0.5f) / side - 0.5f), dir[1] = 0.6f * ((i / side + 0.5f) / side - 0.5f), dir[2] = -1;
    ray.ray.tfar = INFINITY, ray.ray.mask = -1, ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return ray;
}

static int compare(const void *a, const void *b)
{
    return *(const double *)a < *(const double *)b ? -1 : 1;
}

int main(int count, char **words)
{
    void *library = count > 1 ? dlopen(words[1], RTLD_NOW) : NULL;
    if (!library) {
        fprintf(stderr, "%s\n", count > 1 ? dlerror() : "grids LIBRARY [SIDE] [RAYS] [compact]");
        return 1;
    }
    CALLS(LOAD)
    int n = count > 2 ? atoi(words[2]) : 700, across = (int)sqrt(count > 3 ? atof(words[3]) : 300000.0);
    bool compact = count > 4 && !strcmp(words[4], "compact");
    int width = n + 1;
    vertices = malloc(sizeof *vertices * width * width);
    quads = malloc(sizeof *quads * n * n);
    grids = malloc(sizeof *grids * n * n);
    for (int y = 0; y <= n; y++)
        for (int x = 0; x <= n; x++) {
            double a = 2 * M_PI * x / n, b = M_PI * y / n, r = 1 + 0.05 * sin(9 * a) * sin(11 * b) + 0.01 * sin(70 * a) * sin(60 * b);
            float *p = vertices[y * width + x];
            p[0] = (float)(r * sin(b) * cos(a)), p[1] = (float)(r * sin(b) * sin(a)), p[2] = (float)(r * cos(b));
            if (x < n && y < n) {
                unsigned at = y * width + x;
                unsigned quad[4] = { at, at + 1, at + width + 1, at + width };
                memcpy(quads[y * n + x], quad, sizeof quad);
            }
        }
    RTCDevice device = p_rtcNewDevice("threads=1");
    p_rtcSetDeviceMemoryMonitorFunction(device, monitor, NULL);
    for (int form = 0; form < 3; form++) {
        static const char *names[3] = { "quads", "grids of 3x3", "one grid" };
        size_t some = 0;
        if (form == 1)
            for (int y = 0; y < n; y += 2)
                for (int x = 0; x < n; x += 2)
                    grids[some++] = (struct RTCGrid){ (unsigned)(y * width + x), (unsigned)width, x + 1 < n ? 3 : 2, y + 1 < n ? 3 : 2 };
        else
            grids[some++] = (struct RTCGrid){ 0, (unsigned)width, (unsigned short)width, (unsigned short)width };
        double build[3], best[4] = { 0 };
        long long bytes = 0;
        unsigned hits[4] = { 0 };
        double sums[4] = { 0 };
        for (int round = 0; round < 3; round++) {
            long long before = held;
            double start = seconds();
            RTCGeometry geometry = p_rtcNewGeometry(device, form == 0 ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_GRID);
            p_rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0, 16,
                                         (size_t)width * width);
            if (form == 0)
                p_rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quads, 0, 16, (size_t)n * n);
            else
                p_rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, grids, 0, sizeof *grids, some);
            p_rtcCommitGeometry(geometry);
            RTCScene scene = p_rtcNewScene(device);
            if (compact)
                p_rtcSetSceneFlags(scene, RTC_SCENE_FLAG_COMPACT);
            p_rtcAttachGeometry(scene, geometry);
            p_rtcCommitScene(scene);
            build[round] = seconds() - start;
            bytes = held - before;
            for (int way = 0; way < 4; way++) {
                double from = seconds();
                state = 7, hits[way] = 0, sums[way] = 0;
                int rays = across * across;
                for (int i = 0; i < rays; i += 16) {
                    struct RTCRayHit some_rays[16];
                    int all = rays - i < 16 ? rays - i : 16;
                    for (int k = 0; k < all; k++)
                        some_rays[k] = make(way < 2, i + k, across);
                    if (way == 1) {
                        struct RTCRayHit16 packet;
                        memset(&packet, 0, sizeof packet);
                        int valid[16];
                        for (int k = 0; k < 16; k++) {
                            const struct RTCRayHit *ray = &some_rays[k < all ? k : 0];
                            valid[k] = k < all ? -1 : 0;
                            packet.ray.org_x[k] = ray->ray.org_x, packet.ray.org_y[k] = ray->ray.org_y;
                            packet.ray.org_z[k] = ray->ray.org_z, packet.ray.dir_x[k] = ray->ray.dir_x;
                            packet.ray.dir_y[k] = ray->ray.dir_y, packet.ray.dir_z[k] = ray->ray.dir_z;
                            packet.ray.tfar[k] = INFINITY, packet.ray.mask[k] = -1;
                            packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
                        }
                        p_rtcIntersect16(valid, scene, &packet, NULL);
                        for (int k = 0; k < all; k++)
                            if (packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID)
                                hits[way]++, sums[way] += packet.ray.tfar[k];
                    } else
                        for (int k = 0; k < all; k++)
                            if (way < 3) {
                                p_rtcIntersect1(scene, &some_rays[k], NULL);
                                if (some_rays[k].hit.geomID != RTC_INVALID_GEOMETRY_ID)
                                    hits[way]++, sums[way] += some_rays[k].ray.tfar;
                            } else {
                                p_rtcOccluded1(scene, &some_rays[k].ray, NULL);
                                hits[way] += some_rays[k].ray.tfar < 0;
                            }
                }
                double rate = rays / 1e6 / (seconds() - from);
                best[way] = rate > best[way] ? rate : best[way];
            }
            p_rtcReleaseScene(scene);
            p_rtcReleaseGeometry(geometry);
        }
        qsort(build, 3, sizeof *build, compare);
        printf("%-12s %5.1f bytes a quad, build %.3f s; camera %.2f (%u, %.6f), 16 at once %.2f (%u, %.6f), any %.2f (%u, %.6f), "
               "occluded %.2f (%u)\n",
               names[form], (double)bytes / n / n, build[1], best[0], hits[0], sums[0], best[1], hits[1], sums[1], best[2],
               hits[2], sums[2], best[3], hits[3]);
        fflush(stdout);
    }
    p_rtcReleaseDevice(device);
    return 0;
}
