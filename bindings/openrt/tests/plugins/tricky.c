/* SPDX-License-Identifier: GPL-3.0-or-later
 * Surfaces, lights, cameras and environments that behave badly in a frame, and one, `probe`, that checks what the host gives it. */
#include <math.h>
#include <openrt/rts.h>
#include <stdlib.h>
#include <string.h>

/* ---- Bad results ---- */

struct bad {
    int32_t mode, prepare; /* what to do wrong */
};

static const RTSparam bad_params[] = {
    { "mode", RT_INT, 1, RT_PER_SHADER, offsetof(struct bad, mode) },
    { "prepare", RT_INT, 1, RT_PER_SHADER, offsetof(struct bad, prepare) },
};

/* 0: all is well. 1: every second lane NaN. 2: infinity in one channel. 3: nothing is written. */
static float value(int32_t mode, uint32_t i, int channel)
{
    if (mode == 1)
        return i % 2 ? NAN : 0.25f;
    return mode == 2 && channel == 1 ? INFINITY : 0.25f;
}

static void bad_shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    const struct bad *bad = hits->shader;
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < hits->n && bad->mode != 3; i++) {
        out.x[i] = value(bad->mode, i, 0);
        out.y[i] = value(bad->mode, i, 1);
        out.z[i] = value(bad->mode, i, 2);
    }
}

static void bad_miss(const RTShost *host, RTSctx *ctx, const void *block, const RTSrays *rays, RTSvecm out)
{
    const struct bad *bad = block;
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < rays->n && bad->mode != 3; i++)
        out.x[i] = out.y[i] = out.z[i] = value(bad->mode, i, 1);
}

static void bad_illuminate(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, RTSvec P, RTSvecm dir,
                           float *dist, RTSvecm radiance, uint8_t *lit)
{
    const struct bad *bad = block;
    uint32_t i;
    (void)host, (void)ctx, (void)P;
    for (i = 0; i < n; i++) {
        lit[i] = 1;
        if (bad->mode == 3)
            continue;
        dir.x[i] = dir.y[i] = 0, dir.z[i] = 7;
        dist[i] = INFINITY;
        radiance.x[i] = radiance.y[i] = radiance.z[i] = value(bad->mode, i, 1);
    }
}

static void bad_camera(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, const float *x, const float *y,
                       RTSvecm org, RTSvecm dir)
{
    const struct bad *bad = block;
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < n && bad->mode != 3; i++) {
        org.x[i] = 2 * x[i] - 1, org.y[i] = 2 * y[i] - 1, org.z[i] = 10;
        dir.x[i] = dir.y[i] = 0;
        dir.z[i] = bad->mode == 0 ? -3 : bad->mode == 1 ? NAN : 0;
    }
}

/* 0: success. 1: failure with words. 2: writes nowhere. 3: aborts. 4: leaves. 5: writes its block, which frames must
 * not show. */
static int bad_prepare(const RTShost *host, void *snapshot)
{
    struct bad *bad = snapshot;
    static volatile uintptr_t address = 16;
    volatile int *nowhere = (volatile int *)address;
    switch (bad->prepare) {
    case 1: host->log(NULL, 2, "no luck today"); return -7;
    case 2: *nowhere = 1; return 0;
    case 3: abort();
    case 4: _Exit(0);
    case 5: bad->mode++; return 0;
    }
    return 0;
}

#define BAD(kind_, name_, callback_, function_) \
    { .struct_size = sizeof(RTSclass), .kind = kind_, .name = name_, .shader_size = sizeof(struct bad), \
      .param_count = 2, .params = bad_params, .prepare = bad_prepare, .callback_ = function_ }

static const RTSclass bad_classes[] = {
    BAD(RT_SURFACE_SHADER, "bad surface", shade, bad_shade),
    BAD(RT_ENV_SHADER, "bad environment", miss, bad_miss),
    BAD(RT_LIGHT_SHADER, "bad light", illuminate, bad_illuminate),
    BAD(RT_CAMERA_SHADER, "bad camera", camera, bad_camera),
};

/* ---- The probe: shows 1 where all is as promised, else the number of what is not ---- */

struct probe {
    int8_t i8;
    uint8_t u8;
    int16_t i16;
    uint16_t u16;
    int32_t i32[4];
    uint32_t u32;
    float f32, matrix[16];
    double f64, pair[2];
    const char *text;
    const char *made;   /* by init */
    int32_t expected[3]; /* object, instance, first triangle */
};
struct probe_triangle {
    int16_t number;
    float pair[2];
};
struct probe_vertex {
    double weight;
};

enum { I8, U8, I16, U16, I32, U32, F32, MATRIX, F64, PAIR, TEXT, EXPECTED, T_NUMBER, T_PAIR, V_WEIGHT };
static const RTSparam probe_params[] = {
    { "i8", RT_BYTE, 1, RT_PER_SHADER, offsetof(struct probe, i8) },
    { "u8", RT_UNSIGNED_BYTE, 1, RT_PER_SHADER, offsetof(struct probe, u8) },
    { "i16", RT_SHORT, 1, RT_PER_SHADER, offsetof(struct probe, i16) },
    { "u16", RT_UNSIGNED_SHORT, 1, RT_PER_SHADER, offsetof(struct probe, u16) },
    { "i32", RT_INT, 4, RT_PER_SHADER, offsetof(struct probe, i32) },
    { "u32", RT_UNSIGNED_INT, 1, RT_PER_SHADER, offsetof(struct probe, u32) },
    { "f32", RT_FLOAT, 1, RT_PER_SHADER, offsetof(struct probe, f32) },
    { "matrix", RT_FLOAT, 16, RT_PER_SHADER, offsetof(struct probe, matrix) },
    { "f64", RT_DOUBLE, 1, RT_PER_SHADER, offsetof(struct probe, f64) },
    { "pair", RT_DOUBLE, 2, RT_PER_SHADER, offsetof(struct probe, pair) },
    { "text", RT_STRING, 1, RT_PER_SHADER, offsetof(struct probe, text) },
    { "expected", RT_INT, 3, RT_PER_SHADER, offsetof(struct probe, expected) },
    { "t_number", RT_SHORT, 1, RT_PER_TRIANGLE, offsetof(struct probe_triangle, number) },
    { "t_pair", RT_FLOAT, 2, RT_PER_TRIANGLE, offsetof(struct probe_triangle, pair) },
    { "v_weight", RT_DOUBLE, 1, RT_PER_VERTEX, offsetof(struct probe_vertex, weight) },
};

static void probe_init(void *block)
{
    struct probe *probe = block;
    probe->f32 = 0.5f;
    probe->made = strcpy(malloc(8), "made");
}

static void probe_fini(void *block)
{
    free((void *)((struct probe *)block)->made);
}

static int near(double a, double b)
{
    return fabs(a - b) < 1e-4;
}

static int aligned(const void *p)
{
    return p != NULL && (uintptr_t)p % 64 == 0;
}

/* What is wrong with the batch: 1 = nothing. */
static float wrong(const RTShost *host, RTSctx *ctx, const RTShits *hits, float *memory, uint32_t i)
{
    const struct probe *p = hits->shader;
    const uint32_t n = hits->n;
    const float *a;
    int k;
    if (hits->struct_size < sizeof(RTShits) || host->struct_size < sizeof(RTShost) || host->abi >> 16 != 1)
        return 2;
    if (!aligned(hits->P.x) || !aligned(hits->P.y) || !aligned(hits->Ng.z) || !aligned(hits->I.x) || !aligned(hits->t)
        || !aligned(hits->texcoord.z) || !aligned(hits->object) || !aligned(hits->back) || !aligned(memory))
        return 3;
    if ((uintptr_t)p % 16 != 0)
        return 4;
    if (p->i8 != -5 || p->u8 != 250 || p->i16 != -30000 || p->u16 != 60000 || p->u32 != 4000000000u || p->f32 != 0.5f)
        return 5;
    if (p->i32[0] != 1 || p->i32[3] != -4 || p->matrix[15] != 16.0f || p->f64 != 0.1 || p->pair[1] != 2.5)
        return 6;
    if (p->text == NULL || strcmp(p->text, "a text") != 0 || strcmp(p->made, "made") != 0)
        return 7;
    if (hits->object[i] != (uint32_t)p->expected[0] || hits->instance[i] != (uint32_t)p->expected[1])
        return 8;
    if (hits->triangle[i] < (uint32_t)p->expected[2] || hits->triangle[i] > (uint32_t)p->expected[2] + 1)
        return 9;
    if (hits->depth[i] != 0 || hits->back[i] != 0 || hits->alpha[i] != 0.5f)
        return 10;
    if (!near(hits->t[i], 10) || !near(hits->P.z[i], 0) || !near(hits->Ng.z[i], 1) || !near(hits->I.z[i], -1)
        || !near(hits->Ns.z[i], 1))
        return 11;
    if (!near(hits->texcoord.x[i], hits->P.x[i]) || !near(hits->texcoord.y[i], hits->P.y[i]) || hits->texcoord.z[i] != 0)
        return 12;
    if (!near(hits->color.x[i], 0.125) || !near(hits->color.z[i], 0.5))
        return 13;
    if (!(hits->b1[i] >= 0 && hits->b2[i] >= 0 && hits->b1[i] + hits->b2[i] <= 1.0001f))
        return 14;
    /* Parameters, whatever their rate. */
    a = memory;
    memset(memory, 0, 16 * n * sizeof(float));
    host->param(ctx, hits, I32, memory);
    if (a[i] != 1 || a[n + i] != 2 || a[3 * n + i] != -4)
        return 15;
    host->param(ctx, hits, MATRIX, memory);
    for (k = 0; k < 16; k++)
        if (a[k * n + i] != k + 1)
            return 16;
    host->param(ctx, hits, T_NUMBER, memory);
    if (a[i] != -7)
        return 17;
    host->param(ctx, hits, T_PAIR, memory);
    if (a[i] != 3 || a[n + i] != 4)
        return 18;
    host->param(ctx, hits, V_WEIGHT, memory);
    if (!near(a[i], 0.25 * hits->P.x[i]))
        return 19;
    host->param(ctx, hits, TEXT, memory);
    if (a[i] != 0)
        return 20;
    host->param(ctx, hits, 99, memory); /* nothing happens */
    return 1;
}

/* Services with arguments that ask for nothing, or for what is not there. */
static float services(const RTShost *host, RTSctx *ctx, const RTShits *hits, float *memory)
{
    const uint32_t n = hits->n, room = (n + 15) / 16 * 16;
    const RTSvecm none = { NULL, NULL, NULL };
    RTSvecm out = { memory, memory + room, memory + 2 * room };
    RTSrays rays = { sizeof rays, 0, hits->P, hits->Ng, hits->t, hits->t, NULL, NULL };
    uint8_t *lit = (uint8_t *)(memory + 3 * room);
    float *zero = memory + 4 * room, *far = zero + room, *alpha = far + room;
    uint32_t i, lane = 0xFFFFFFFFu;
    host->trace(ctx, &rays, out);
    host->trace(ctx, NULL, out);
    host->log(ctx, 0, NULL);
    memset(lit, 1, n);
    host->illuminate(ctx, 12345, n, hits->P, out, zero, out, lit);
    if (lit[0] != 0)
        return 30;
    host->illuminate(ctx, 0, n, hits->P, none, NULL, none, NULL);
    for (i = 0; i < n; i++)
        zero[i] = 0, far[i] = INFINITY;
    /* Up, where nothing is: rays of length 3, which is the surface's affair. */
    rays.n = n, rays.tmin = zero, rays.tmax = far;
    rays.org = hits->P, rays.dir = hits->Ng;
    host->occluded(ctx, &rays, out);
    if (out.x[0] != 1 || out.z[n - 1] != 1)
        return 31;
    /* A parent that is not there, one ray. */
    rays.n = 1, rays.parent = &lane;
    zero[0] = 0.01f;
    host->occluded(ctx, &rays, out);
    zero[0] = 0;
    if (out.x[0] != 1)
        return 32;
    /* Down through the rectangle, from above: all is blocked, and seen through a short ray it is not. */
    for (i = 0; i < n; i++)
        out.x[i] = hits->P.x[i], out.y[i] = hits->P.y[i], out.z[i] = 3;
    rays.n = n, rays.parent = NULL, rays.dir = hits->I;
    rays.org.x = out.x, rays.org.y = out.y, rays.org.z = out.z;
    {
        RTSvecm through = { alpha, alpha + room, alpha + 2 * room };
        host->occluded(ctx, &rays, through);
        if (through.x[0] != 0 || through.y[n - 1] != 0)
            return 33;
        for (i = 0; i < n; i++)
            far[i] = 2.9f;
        host->occluded(ctx, &rays, through);
        if (through.x[0] != 1 || through.y[n - 1] != 1)
            return 34;
        host->texture(ctx, 4711, n, hits->P.x, hits->P.y, through, far);
        if (through.x[0] != 1 || far[n - 1] != 1)
            return 35;
    }
    if (host->scratch(ctx, (size_t)-1 / 4) != NULL || host->scratch(ctx, 0) == NULL)
        return 36;
    return 1;
}

static void probe_shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    const uint32_t room = (hits->n + 15) / 16 * 16;
    float *memory = host->scratch(ctx, (size_t)room * 16 * sizeof(float));
    uint32_t i;
    for (i = 0; i < hits->n; i++) {
        out.x[i] = wrong(host, ctx, hits, memory, i);
        out.y[i] = services(host, ctx, hits, memory);
        out.z[i] = 1;
    }
}

static const RTSclass probe = {
    .struct_size = sizeof(RTSclass), .kind = RT_SURFACE_SHADER, .name = "probe", .shader_size = sizeof(struct probe),
    .shader_align = 0, .triangle_size = sizeof(struct probe_triangle), .vertex_size = sizeof(struct probe_vertex),
    .param_count = sizeof probe_params / sizeof probe_params[0], .params = probe_params,
    .init = probe_init, .fini = probe_fini, .shade = probe_shade,
};

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &bad_classes[0], &bad_classes[1], &bad_classes[2], &bad_classes[3], &probe };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 5, classes };
    (void)host_abi;
    return &module;
}
