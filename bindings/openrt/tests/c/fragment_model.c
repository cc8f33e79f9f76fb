/* SPDX-License-Identifier: GPL-3.0-or-later
 * The fragment rule once more, on random objects, against a model that only counts. */
#include "check.h"

static unsigned state = 12345;

static int below(int n)
{
    state = state * 1664525u + 1013904223u;
    return (int)((state >> 8) % (unsigned)n);
}

/* Triangles of a block in OpenGL's manner. */
static int triangles_of(RTenum mode, int n)
{
    switch (mode) {
    case RT_TRIANGLES: return n / 3;
    case RT_QUADS: return n / 4 * 2;
    case RT_QUAD_STRIP: return n < 4 ? 0 : (n / 2 - 1) * 2;
    default: return n < 3 ? 0 : n - 2;
    }
}

/* What waits in the open object. */
static struct {
    int count, shader;
    RTenum mode;
} waiting;

/* Triangles that the model expects of a block in the open object. */
static int model(RTenum mode, int shader, int n)
{
    const int size = mode == RT_TRIANGLES ? 3 : mode == RT_QUADS ? 4 : 0;
    int complete;
    if (n == 0)
        return 0;
    if (n >= size) {
        waiting.count = 0;
        return triangles_of(mode, n);
    }
    if (waiting.mode != mode || waiting.shader != shader)
        waiting.count = 0;
    waiting.mode = mode, waiting.shader = shader, waiting.count += n;
    complete = waiting.count >= size;
    waiting.count -= complete * size;
    return complete * (mode == RT_QUADS ? 2 : 1);
}

int main(void)
{
    RTuint shaders[2];
    int round;
    helpers_are_used();
    shaders[0] = constant_shader(1, 0, 0);
    shaders[1] = constant_shader(0, 1, 0);
    for (round = 0; round < 2000; round++) {
        const int before = integer(RT_TRIANGLE_COUNT), blocks = 1 + below(8);
        int wanted = 0, vertex = 0, shader = 0, block;
        waiting.count = 0;
        rtBindShader(shaders[0]);
        rtCreateObject(RT_DEFINE);
        for (block = 0; block < blocks; block++) {
            const RTenum often[3] = { RT_TRIANGLES, RT_TRIANGLES, RT_QUADS };
            const RTenum mode = below(3) ? often[below(3)] : RT_TRIANGLES + (RTenum)below(6);
            const int end = vertex + below(7);
            if (below(4) == 0)
                rtBindShader(shaders[shader = below(2)]);
            wanted += model(mode, shader, end - vertex);
            rtBegin(mode);
            /* On a moment curve no three points are in line. */
            for (; vertex < end; vertex++)
                rtVertex3i(vertex, vertex * vertex, vertex * vertex * vertex);
            rtEnd();
        }
        rtEndObject();
        if (integer(RT_TRIANGLE_COUNT) - before != wanted)
            printf("round %d: %d triangles, not %d\n", round, integer(RT_TRIANGLE_COUNT) - before, wanted);
        CHECK(integer(RT_TRIANGLE_COUNT) - before == wanted);
    }
    FINISH();
}
