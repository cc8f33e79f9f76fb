/* SPDX-License-Identifier: GPL-3.0-or-later
 * Eight threads call at random, frames among the calls: nothing is corrupted. What single threads see between their own
 * calls is anybody's; in the end the counts are those that all calls together make. Usage: threads [CALLS PER THREAD] */
#define _POSIX_C_SOURCE 200112L
#include "check.h"
#include <pthread.h>

#define THREADS 8
#define SIZE 16

static RTubyte pixels[SIZE * SIZE * 3];
static int calls = 2000;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void one_call(unsigned n, unsigned x)
{
    static const RTenum modes[] = { RT_TRIANGLES, RT_QUADS, RT_TRIANGLE_STRIP, RT_POLYGON, 0x17 };
    RTfloat matrix[16];
    switch (n % 20) {
    case 0: rtBegin(modes[x % 5]); break;
    case 1: case 2: case 3: case 4: rtVertex3f((float)(x % 7), (float)(x % 5), (float)(x % 3)); break;
    case 5: rtEnd(); break;
    case 6: rtNormal3f(0, 0, 1); break;
    case 7: rtGenNewShaderClass(x % 2 ? "DiffuseShader" : "sample", NULL); break;
    case 8: rtGenNewShader(); break;
    case 9: rtCreateObject(RT_DEFINE_AND_INSTANTIATE); break;
    case 10: rtEndObject(); break;
    case 11: rtInstantiateObject(x % 9); break;
    case 12: rtUpdateInstance(x % 9); break;
    case 13: rtPushMatrix(); break;
    case 14: rtPopMatrix(); break;
    case 15: if (x % 8 == 0) rtStartRendering(); break;
    case 16: if (x % 4 == 0) rtEndRendering(); break;
    case 17: rtGetFloatv(RT_MODELVIEW_MATRIX, matrix); break;
    case 18: if (x % 64 == 0) rtClearInstances(); break;
    default: rtGetError(); break;
    }
}

static void *work(void *seed)
{
    unsigned state = *(unsigned *)seed;
    int i;
    for (i = 0; i < calls; i++) {
        state = state * 1664525u + 1013904223u;
        one_call(state >> 16, state >> 8);
    }
    return NULL;
}

/* Whole objects, each under the program's own lock: none of them is lost. */
static void *define(void *seed)
{
    int i, j;
    (void)seed;
    for (i = 0; i < 50; i++) {
        pthread_mutex_lock(&lock);
        rtCreateObject(RT_DEFINE);
        rtBegin(RT_TRIANGLES);
        for (j = 0; j < 3; j++)
            rtVertex3f(j == 1, j == 2, 0);
        rtEnd();
        rtEndObject();
        pthread_mutex_unlock(&lock);
        rtGetError();
    }
    return NULL;
}

static void run(void *(*job)(void *))
{
    pthread_t threads[THREADS];
    unsigned seeds[THREADS];
    int i;
    for (i = 0; i < THREADS; i++) {
        seeds[i] = (unsigned)i * 77777u + 1;
        pthread_create(&threads[i], NULL, job, &seeds[i]);
    }
    for (i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
}

int main(int argc, char **argv)
{
    if (argc > 1)
        calls = atoi(argv[1]);
    helpers_are_used();
    rtSetFrameBuffer(pixels, SIZE, SIZE, RT_RGB_8);
    run(work);
    rtEnd();
    rtExit();
    constant_shader(1, 1, 1);
    run(define);
    CHECK(integer(RT_OBJECT_COUNT) == THREADS * 50);
    CHECK(integer(RT_TRIANGLE_COUNT) == THREADS * 50);
    rtGetError();
    rtExit();
    FINISH();
}
