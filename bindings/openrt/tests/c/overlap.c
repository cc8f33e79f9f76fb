/* SPDX-License-Identifier: GPL-3.0-or-later
 * Overlap: the time of a frame that is rendered while the next scene is edited, beside the times of either alone. Give the
 * renderer a core less than there are: overlap --rt-threads=1 on two cores. With an argument left over, that many frames
 * and no check of the times: "overlap --rt-threads=1 5". Prints one line. */
#define _POSIX_C_SOURCE 200112L
#include "check.h"
#include <time.h>

#define SIZE 256
#define GRID 160
#define OBJECTS 4
/* Objects that a frame's edit defines, the same four again and again: about as long as the rendering takes. */
#define ROUNDS 40

static RTubyte pixels[2][SIZE * SIZE * 3];
static RTuint objects[OBJECTS];

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The program's own work on scene n + 1: waves on a grid, sent vertex by vertex. */
static void edit(int n, int rounds)
{
    int i, j, k, round;
    for (round = 0; round < rounds; round++) {
        rtNewObject(objects[round % OBJECTS], RT_DEFINE);
        for (j = 0; j < GRID; j++) {
            rtBegin(RT_QUAD_STRIP);
            for (i = 0; i <= GRID; i++)
                for (k = 1; k >= 0; k--) {
                    const float x = 2.f * i / GRID - 1, y = 2.f * (j + k) / GRID - 1;
                    rtNormal3f(0, 0, 1);
                    rtVertex3f(x, y, 0.1f * (float)sin(9 * x + n) * (float)cos(7 * y + round));
                }
            rtEnd();
        }
        rtEndObject();
    }
}

static double frames(int count, int rounds, int renders)
{
    double start;
    int n;
    start = seconds();
    for (n = 0; n < count; n++) {
        if (renders) {
            rtSetFrameBuffer(pixels[n % 2], SIZE, SIZE, RT_RGB_8);
            rtStartRendering();
        }
        edit(n, rounds);
        if (renders)
            rtEndRendering();
    }
    return (seconds() - start) / count;
}

int main(int argc, char **argv)
{
    int i, count = 5;
    double render, editing, both, longer;
    helpers_are_used();
    rtInit(&argc, argv);
    if (argc > 1)
        count = atoi(argv[1]);
    rtGenNewShaderClass("InfiniteLightShader", NULL);
    rtUseLight(rtGenNewShader());
    rtGenNewShaderClass("TexturedDiffuseShader", NULL);
    rtGenNewShader();
    for (i = 0; i < OBJECTS; i++)
        objects[i] = rtGenObjects(1);
    edit(0, OBJECTS);
    for (i = 0; i < OBJECTS; i++) {
        rtLoadIdentity();
        rtTranslatef(0.1f * i, 0.1f * i, -0.3f * i);
        rtInstantiateObject(objects[i]);
    }
    rtLoadIdentity();
    look_at_square();
    rtSetSamplesPerPixel(4);
    frames(1, 1, 1);
    editing = frames(count, ROUNDS, 0);
    /* What the edits cost the renderer, new trees, belongs to the rendering: the same edits, then nothing beside it. */
    render = 0;
    for (i = 0; i < count; i++) {
        edit(i, ROUNDS);
        render += frames(1, 0, 1) / count;
    }
    both = frames(count, ROUNDS, 1);
    longer = render > editing ? render : editing;
    printf("render %.1f ms, edit %.1f ms, both %.1f ms: %.2f of the longer one\n", 1e3 * render, 1e3 * editing,
           1e3 * both, both / longer);
    CHECK(rtGetError() == RT_NO_ERROR);
    CHECK(argc > 1 || both <= 1.1 * longer);
    rtExit();
    FINISH();
}
