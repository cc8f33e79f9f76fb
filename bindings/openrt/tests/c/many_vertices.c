/* SPDX-License-Identifier: GPL-3.0-or-later
 * Submission time. Usage: many_vertices [VERTICES]; 300,000 without. Prints seconds per 10 million. */
#include "check.h"
#include <time.h>

int main(int argc, char **argv)
{
    const int count = argc > 1 ? atoi(argv[1]) : 300000;
    int i;
    clock_t start;
    double seconds;
    helpers_are_used();
    constant_shader(1, 1, 1);
    rtCreateObject(RT_DEFINE);
    start = clock();
    rtBegin(RT_TRIANGLES);
    for (i = 0; i < count; i++) {
        rtNormal3f(0, 0, 1);
        rtVertex3f((float)(i % 3), (float)(i % 2), (float)i);
    }
    rtEnd();
    seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    rtEndObject();
    printf("%.3f s per 10 million\n", seconds * 1e7 / count);
    CHECK(integer(RT_TRIANGLE_COUNT) == count / 3);
    FINISH();
}
