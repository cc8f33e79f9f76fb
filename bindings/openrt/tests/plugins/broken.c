/* SPDX-License-Identifier: GPL-3.0-or-later
 * Plugins that break one rule each: CASE says which. The class is `broken`, beside a sound one, `sound`. */
#include <openrt/rts.h>

#ifndef CASE
#define CASE 0
#endif

static void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < hits->n; i++)
        out.x[i] = out.y[i] = out.z[i] = 0.25f;
}

static const RTSparam params[] = {
    { CASE == 1 ? NULL : CASE == 2 ? "" : "first", CASE == 3 ? RT_2_BYTES : CASE == 4 ? 77u : RT_FLOAT,
      CASE == 5 ? 0 : CASE == 6 ? 2 : 1, CASE == 7 ? 0x503u : CASE == 8 ? RT_PER_VERTEX : RT_PER_SHADER,
      CASE == 9 ? 0xFFFFFFFFu : 0 },
    { CASE == 10 ? "first" : "second", CASE == 11 ? RT_STRING : RT_INT, 1, RT_PER_TRIANGLE, 0 },
};

static const RTSclass broken = {
    .struct_size = CASE == 12 ? 40 : sizeof(RTSclass),
    .kind = CASE == 13 ? RT_RENDERING_OBJECT : CASE == 14 ? 5 : CASE == 8 ? RT_LIGHT_SHADER : RT_SURFACE_SHADER,
    .flags = CASE == 15 ? 1 : 0,
    .name = "broken",
    .shader_size = CASE == 16 ? 0xFFFFFFFFu : 4,
    .shader_align = CASE == 17 ? 24 : CASE == 18 ? 8192 : 0,
    .triangle_size = 8,
    .vertex_size = 0,
    .param_count = CASE == 19 ? 0xFFFFFFFFu : 2,
    .params = CASE == 20 ? NULL : params,
    .shade = CASE == 21 ? NULL : shade,
};

/* Only what is needed: struct_size ends before the optional members, which must not be read. */
static const RTSclass sound = { .struct_size = sizeof(RTSclass), .name = "sound", .kind = RT_SURFACE_SHADER, .shade = shade };
static const RTSclass nameless = { .struct_size = sizeof(RTSclass), .kind = RT_SURFACE_SHADER, .shade = shade };

#if CASE == 22
#define rts_module another_name
const RTSmodule *another_name(uint32_t host_abi);
#endif

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &nameless, NULL, &sound, &broken };
    static const RTSmodule module = { CASE == 23 ? 8 : sizeof(RTSmodule),
                                      CASE == 24 ? 0x00020000u : CASE == 25 ? 0x00010007u : RTS_ABI,
                                      CASE == 26 ? 0 : 4, CASE == 27 ? NULL : classes };
    (void)host_abi;
    return CASE == 28 ? NULL : &module;
}
