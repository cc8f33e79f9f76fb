/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checks that count: a program ends with finish(). */
#ifndef CHECK_H
#define CHECK_H
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Not all programs need all of these. */
#define MAYBE_UNUSED __attribute__((unused))

static int failures;

#define CHECK(condition, ...)                                                                                         \
    do {                                                                                                              \
        if (!(condition) && ++failures < 20) {                                                                        \
            fprintf(stderr, "%s:%d: %s: ", __FILE__, __LINE__, #condition);                                          \
            fprintf(stderr, __VA_ARGS__);                                                                             \
            fputc('\n', stderr);                                                                                      \
        }                                                                                                             \
    } while (0)

MAYBE_UNUSED static int finish(void)
{
    if (failures)
        fprintf(stderr, "%d checks failed\n", failures);
    return failures ? 1 : 0;
}

/* Numbers from 0 to 1, the same everywhere. */
static unsigned long long random_state = 1;
MAYBE_UNUSED static float number(void)
{
    random_state = random_state * 6364136223846793005ull + 1442695040888963407ull;
    return (float)(random_state >> 40) / 16777216.0f;
}

MAYBE_UNUSED static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

MAYBE_UNUSED static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Where a ray meets a triangle, by the definition; INFINITY where it does not. */
MAYBE_UNUSED static double meets(const float *p0, const float *p1, const float *p2, const float *org, const float *dir)
{
    double e1[3], e2[3], o[3], d[3], p[3], q[3];
    for (int k = 0; k < 3; k++) {
        e1[k] = (double)p1[k] - p0[k];
        e2[k] = (double)p2[k] - p0[k];
        o[k] = (double)org[k] - p0[k];
        d[k] = dir[k];
    }
    cross(d, e2, p);
    double det = dot(e1, p);
    if (det == 0)
        return INFINITY;
    cross(o, e1, q);
    double u = dot(o, p) / det, v = dot(d, q) / det;
    if (u < 0 || v < 0 || u + v > 1)
        return INFINITY;
    return dot(e2, q) / det;
}
#endif
