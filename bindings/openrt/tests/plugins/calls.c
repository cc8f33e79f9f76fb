/* SPDX-License-Identifier: GPL-3.0-or-later
 * Surfaces that look at which thread and process their functions run in, and with which arguments services may be called. */
#define _XOPEN_SOURCE 600
#include <openrt/rts.h>
#include <pthread.h>
#include <time.h>

unsigned rtGetError(void);

/* What the program looks at. */
RTS_EXPORT int error_within = -1, ends = 0, ends_elsewhere = 0;

static pthread_t home;

static void constant(RTSvecm out, uint32_t n, float value)
{
    uint32_t i;
    for (i = 0; i < n; i++)
        out.x[i] = out.y[i] = out.z[i] = value;
}

static void plain_shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    (void)host, (void)ctx;
    constant(out, hits->n, 0.25f);
}

/* Calls back, while another thread waits for the library. */
static void calling_init(void *block)
{
    static const struct timespec while_the_other_calls = { 0, 200000000 };
    (void)block;
    nanosleep(&while_the_other_calls, NULL);
    error_within = (int)rtGetError();
}

/* Ends where it began. */
static void homely_init(void *block)
{
    (void)block;
    home = pthread_self();
}

static void homely_fini(void *block)
{
    (void)block;
    ends++;
    ends_elsewhere += !pthread_equal(home, pthread_self());
}

/* Light number 0 of points lifted from the surface; arrays may be null. */
static void lifted_shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    const uint32_t n = hits->n, room = (n + 15) / 16 * 16;
    float *memory = host->scratch(ctx, (size_t)room * 5 * sizeof(float));
    RTSvecm dir = { memory, memory + room, memory + 2 * room };
    RTSvec lifted = hits->P, none = hits->P;
    float *z = memory + 4 * room;
    uint32_t i;
    for (i = 0; i < n; i++)
        z[i] = hits->P.z[i] + 0.5f;
    lifted.z = z;
    none.y = NULL;
    host->param(ctx, hits, 0, NULL);
    host->illuminate(ctx, 0, n, none, dir, memory + 3 * room, out, NULL);
    host->illuminate(ctx, 0, n, lifted, dir, memory + 3 * room, out, NULL);
}

/* Asks from a thread of its own. */
struct question {
    const RTShost *host;
    RTSctx *ctx;
    uint32_t answer;
};

static void *ask(void *of)
{
    struct question *question = of;
    question->answer = question->host->light_count(question->ctx);
    return NULL;
}

static void stray_shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    struct question question = { host, ctx, 99 };
    pthread_t thread;
    if (pthread_create(&thread, NULL, ask, &question) == 0)
        pthread_join(thread, NULL);
    constant(out, hits->n, (float)question.answer + 0.5f * (float)host->light_count(ctx));
}

struct block {
    float triple[3];
};
static const RTSparam params[] = { { "triple", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct block, triple) } };

#define CLASS(name_, ...) \
    { .struct_size = sizeof(RTSclass), .kind = RT_SURFACE_SHADER, .name = name_, .shader_size = sizeof(struct block), \
      .param_count = 1, .params = params, __VA_ARGS__ }

static const RTSclass calling = CLASS("calling", .init = calling_init, .shade = plain_shade);
static const RTSclass homely = CLASS("homely", .init = homely_init, .fini = homely_fini, .shade = plain_shade);
static const RTSclass lifted = CLASS("lifted", .shade = lifted_shade);
static const RTSclass stray = CLASS("stray", .shade = stray_shade);

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &calling, &homely, &lifted, &stray };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 4, classes };
    (void)host_abi;
    return &module;
}
