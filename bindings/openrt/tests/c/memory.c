/* SPDX-License-Identifier: GPL-3.0-or-later
 * Memory runs out where the program says how much it wants: an error, nothing else changes, and the program goes on. */
#define _GNU_SOURCE
#include "check.h"
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#define MIB ((size_t)1 << 20)

/* From now on the process may take so many bytes more. */
static void allow(size_t more)
{
    struct rlimit limit;
    unsigned long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    CHECK(file != NULL && fscanf(file, "%lu", &pages) == 1);
    if (file != NULL)
        fclose(file);
    CHECK(getrlimit(RLIMIT_AS, &limit) == 0);
    limit.rlim_cur = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + more;
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
}

static void allow_all(void)
{
    struct rlimit limit;
    CHECK(getrlimit(RLIMIT_AS, &limit) == 0);
    limit.rlim_cur = limit.rlim_max;
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
}

static void textures(void)
{
    static const RTubyte green[3] = { 0, 255, 0 };
    const size_t bytes = 4096 * (size_t)4096 * 16;
    void *texels = mmap(NULL, bytes, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    CHECK(texels != MAP_FAILED);
    rtBindTexture(RT_TEXTURE_2D, rtGenTextures(1));
    EXPECT(rtTexImage2D(RT_TEXTURE_2D, 0, 3, 1, 1, 0, RT_RGB, RT_UNSIGNED_BYTE, green), RT_NO_ERROR);
    allow(32 * MIB);
    EXPECT(rtTexImage2D(RT_TEXTURE_2D, 0, 4, 4096, 4096, 0, RT_RGBA, RT_FLOAT, texels), RT_OUT_OF_MEMORY);
    EXPECT(rtTexImage2D(RT_TEXTURE_2D, 0, 4, 4096, 4096, 0, RT_RGBA, RT_UNSIGNED_BYTE, texels), RT_OUT_OF_MEMORY);
    allow_all();
    munmap(texels, bytes);
}

static void vertices(void)
{
    RTenum error = RT_NO_ERROR;
    RTuint object;
    int block, i;
    constant_shader(1, 1, 1);
    allow(32 * MIB);
    object = rtNewObject(RT_DEFINE);
    for (block = 0; block < 1000 && error == RT_NO_ERROR; block++) {
        rtBegin(RT_TRIANGLES);
        for (i = 0; i < 3000; i++) {
            rtColor3f((float)(i % 7) / 7, 0, 1);
            rtTexCoord2f((float)i, 1);
            rtVertex3f((float)(i % 3), (float)(i % 2), (float)block);
        }
        rtEnd();
        error = rtGetError();
    }
    allow_all();
    CHECK(error == RT_OUT_OF_MEMORY);
    EXPECT(rtEndObject(), RT_NO_ERROR);
    EXPECT(rtRemoveObject(object), RT_NO_ERROR);
}

static pthread_mutex_t held = PTHREAD_MUTEX_INITIALIZER;

static void *hold_a_stack(void *unused)
{
    pthread_mutex_lock(&held);
    pthread_mutex_unlock(&held);
    return unused;
}

/* A frame that finds no room for its thread has no effect: the next one shows what it would have shown. */
static void frames(void)
{
    pthread_t holders[3];
    pthread_attr_t stack;
    int i;
    rtSceneMode(RT_IMMEDIATE);
    EXPECT(rtRender(), RT_NO_ERROR);
    /* Stacks of threads that have ended are used again. */
    pthread_attr_init(&stack);
    pthread_attr_setstacksize(&stack, 2 * MIB);
    pthread_mutex_lock(&held);
    for (i = 0; i < 3; i++)
        CHECK(pthread_create(&holders[i], &stack, hold_a_stack, NULL) == 0);
    constant_shader(0.25f, 0.5f, 0.75f);
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 0, 1, 0);
    rtEndObject();
    rectangle(0, -1, 1, 1, 0);
    allow(MIB);
    EXPECT(rtStartRendering(), RT_OUT_OF_MEMORY);
    allow_all();
    pthread_mutex_unlock(&held);
    for (i = 0; i < 3; i++)
        pthread_join(holders[i], NULL);
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(-0.5, 0, 0.25, 0.5, 0.75);
    SHOWS(0.5, 0, 0.25, 0.5, 0.75);
    EXPECT(rtRender(), RT_NO_ERROR);
    CHECK(covered() == 0);
}

int main(void)
{
    helpers_are_used();
    use_frame();
    look_at_square();
    textures();
    vertices();
    frames();
    FINISH();
}
