/* SPDX-License-Identifier: GPL-3.0-or-later
 * An object defined through immediate calls and built: million [TRIANGLES] [--rt-threads=N]. Prints the seconds of the calls and
 * of the frame of one pixel that builds it. */
#define _POSIX_C_SOURCE 200112L
#include "check.h"
#include <time.h>

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int main(int argc, char **argv)
{
    RTubyte pixel[3];
    int count, side, i, j, k;
    double start, called;
    helpers_are_used();
    rtInit(&argc, argv);
    count = argc > 1 ? atoi(argv[1]) : 20000;
    side = (int)sqrt(count / 2.0);
    constant_shader(1, 1, 1);
    rtSetFrameBuffer(pixel, 1, 1, RT_RGB_8);
    rtRender();
    start = seconds();
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_TRIANGLES);
    for (j = 0; j < side; j++)
        for (i = 0; i < side; i++)
            for (k = 0; k < 6; k++) {
                const int x = i + (k == 1 || k == 2 || k == 4), y = j + (k == 2 || k == 4 || k == 5);
                rtNormal3f(0, 0, 1);
                rtVertex3f((float)x, (float)y, (float)((x * 7 + y * 13) % 5));
            }
    rtEnd();
    rtEndObject();
    called = seconds() - start;
    rtRender();
    printf("%d triangles: %.3f s calls, %.3f s in all\n", 2 * side * side, called, seconds() - start);
    CHECK(integer(RT_TRIANGLE_COUNT) == 2 * side * side);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
    FINISH();
}
