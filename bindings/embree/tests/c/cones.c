/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Cones by the calls of Embree, against points along rays: whether each is inside says where the ray goes in and out. Runs on Embree's own
 * library as well, with an argument. */
#include "scenes.h"

static bool is_ours;

enum { CONES = 12 };
static float ends[2][2 * CONES][4];
static unsigned indices[CONES];

static bool near(double a, double b, double off) { return fabs(a - b) <= off; }

static RTCScene scene_of(int steps, int count, const unsigned char *flags)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_CONE_LINEAR_CURVE);
    rtcSetGeometryTimeStepCount(geometry, steps);
    for (int step = 0; step < steps; step++)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4, ends[step], 0, 16, 2 * CONES);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices, 0, 4, count);
    if (flags)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR, flags, 0, 1, count);
    return committed(geometry);
}

/* How deep a point is in a cone at a time: negative outside; and how far along. */
static double depth(int cone, const double p[3], float time, double *along)
{
    double a[4], b[4], axis[3], offset[3], beside = 0;
    for (int k = 0; k < 4; k++) {
        a[k] = (1 - time) * ends[0][indices[cone]][k] + time * ends[1][indices[cone]][k];
        b[k] = (1 - time) * ends[0][indices[cone] + 1][k] + time * ends[1][indices[cone] + 1][k];
    }
    for (int k = 0; k < 3; k++)
        axis[k] = b[k] - a[k], offset[k] = p[k] - a[k];
    double length = sqrt(dot(axis, axis));
    *along = dot(offset, axis) / length / length;
    for (int k = 0; k < 3; k++)
        beside += pow(offset[k] - *along * axis[k], 2);
    double of_side = a[3] + *along * (b[3] - a[3]) - sqrt(beside), of_ends = length * fmin(*along, 1 - *along);
    return fmin(of_side, of_ends);
}

static bool is_inside(const double p[3], float time)
{
    double along;
    for (int cone = 0; cone < CONES; cone++)
        if (depth(cone, p, time, &along) > 0)
            return true;
    return false;
}

static void rays(int steps)
{
    for (int i = 0; i < 2 * CONES; i++)
        for (int k = 0; k < 4; k++) {
            ends[0][i][k] = k < 3 ? 2 * number() - 1 : 0.02f + 0.2f * number();
            if (i % 6 == 5 && k == 3)
                ends[0][i][k] = 0;
            ends[1][i][k] = steps == 1 ? ends[0][i][k] : ends[0][i][k] + (k < 3 ? 0.5f * number() : 0);
        }
    for (int i = 0; i < CONES; i++)
        indices[i] = 2 * i;
    RTCScene scene = scene_of(steps, CONES, NULL);
    int wrong = 0, hits = 0, places = 0;
    for (int i = 0; i < 1500; i++) {
        float org[3], dir[3], time = number();
        for (int k = 0; k < 3; k++)
            org[k] = 4 * number() - 2, dir[k] = 2 * number() - 1 - 0.5f * org[k];
        if (!is_ours) {
            /* Embree's cones are larger where directions are not of unit length. */
            float length = sqrtf(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
            for (int k = 0; k < 3; k++)
                dir[k] /= length;
        }
        struct RTCRayHit hit = shot_along(scene, org, dir, time);
        bool is_hit = hit.hit.geomID == 0, first = true, start = false;
        double change = INFINITY;
        for (int step = 0; step <= 3000 && isinf(change); step++) {
            double t = step * 0.002, p[3];
            for (int k = 0; k < 3; k++)
                p[k] = org[k] + t * dir[k];
            bool now = is_inside(p, time);
            if (first)
                start = now, first = false;
            else if (now != start)
                change = t;
        }
        /* Inside of one, rays go on to other walls; outside, they meet the first. */
        if (start)
            continue;
        double t = is_hit ? hit.ray.tfar : INFINITY;
        /* Steps may go over what is thin. */
        wrong += !(isinf(change) ? isinf(t) || t > 0 : t <= change + 1e-4 && (t >= change - 0.0021 || t < change));
        if (!is_hit)
            continue;
        hits++;
        double p[3], along;
        for (int k = 0; k < 3; k++)
            p[k] = org[k] + t * dir[k];
        double off = depth((int)hit.hit.primID, p, time, &along);
        places += near(off, 0, 2e-4) && near(hit.hit.u, along, 2e-4) && hit.hit.v == 0;
        /* Along the normal it is deeper. */
        double length = sqrt(pow(hit.hit.Ng_x, 2) + pow(hit.hit.Ng_y, 2) + pow(hit.hit.Ng_z, 2)), facing = 0;
        for (int k = 0; k < 3; k++) {
            p[k] -= 1e-3 * (&hit.hit.Ng_x)[k] / length;
            facing += (&hit.hit.Ng_x)[k] * dir[k];
        }
        places -= !near(depth((int)hit.hit.primID, p, time, &along), 1e-3, 4e-4) || facing > 0;
    }
    CHECK(wrong == 0 && hits > 200, "%d of %d rays wrong", wrong, hits);
    CHECK(places >= hits - 4, "%d of %d places", places, hits);
    rtcReleaseScene(scene);
}

/* Ends that go on in a neighbour have no cap. */
static void caps(void)
{
    static const float row[4][4] = { { 0, 0, 0, 1 }, { 2, 0, 0, 0.5f }, { 4, 0, 0, 2 }, { 6, 0, 0, 1 } };
    static const float axis[3] = { 1, 0, 0 }, back[3] = { -1, 0, 0 }, middle[3] = { 1, 0.1f, 0.2f };
    memcpy(ends[0], row, sizeof row);
    indices[0] = 0, indices[1] = 1, indices[2] = 2;
    for (unsigned char flag = 0; flag < 4; flag++) {
        RTCScene scene = scene_of(1, 1, &flag);
        CHECK(near(shot_along(scene, middle, back, 0).ray.tfar, 1, 1e-5) == !(flag & 1), "flags %d: the first end", flag);
        CHECK(near(shot_along(scene, middle, axis, 0).ray.tfar, 1, 1e-5) == !(flag & 2), "flags %d: the second end", flag);
        rtcReleaseScene(scene);
    }
    RTCScene scene = scene_of(1, 3, NULL);
    struct RTCRayHit hit = shot_along(scene, middle, axis, 0);
    CHECK(near(hit.ray.tfar, 5, 1e-5) && hit.hit.primID == 2 && hit.hit.u == 1 && hit.hit.Ng_x > 0, "the last end of three");
    hit = shot_along(scene, middle, back, 0);
    CHECK(near(hit.ray.tfar, 1, 1e-5) && hit.hit.primID == 0 && hit.hit.u == 0 && hit.hit.Ng_x < 0, "the first");
    struct RTCBounds bounds;
    rtcGetSceneBounds(scene, &bounds);
    CHECK((near(bounds.lower_x, 0, 1e-4) || !is_ours) && near(bounds.upper_y, 2, 1e-4), "the box: %g, %g", bounds.lower_x, bounds.upper_y);
    rtcReleaseScene(scene);
    if (!is_ours)
        return;
    /* Bad ones are left out. */
    ends[0][0][3] = -1, ends[0][2][0] = NAN, indices[2] = 4000000000u;
    scene = scene_of(1, 3, NULL);
    CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE, "no error");
    CHECK(shot_along(scene, middle, axis, 0).hit.geomID != 0, "nothing is left");
    rtcReleaseScene(scene);
}

int main(int count, char **values)
{
    (void)values;
    device = rtcNewDevice(NULL);
    is_ours = count == 1;
    rays(1);
    rays(2);
    caps();
    rtcReleaseDevice(device);
    return finish();
}
