/* SPDX-License-Identifier: GPL-3.0-or-later
 * A mirror that takes 64 KiB of the stack for each bounce. */
#include <openrt/rts.h>

#define MOST 1024

static void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    /* What the compiler cannot leave out. */
    volatile char large[65536];
    float dir[3][MOST], tmin[MOST], tmax[MOST];
    RTSrays rays = { sizeof(RTSrays), 0, { 0, 0, 0 }, { 0, 0, 0 }, 0, 0, 0, 0 };
    uint32_t i, n = hits->n < MOST ? hits->n : MOST;
    for (i = 0; i < sizeof large; i += 4096)
        large[i] = (char)i;
    for (i = 0; i < n; i++) {
        float twice = 2 * (hits->I.x[i] * hits->Ng.x[i] + hits->I.y[i] * hits->Ng.y[i] + hits->I.z[i] * hits->Ng.z[i]);
        dir[0][i] = hits->I.x[i] - twice * hits->Ng.x[i];
        dir[1][i] = hits->I.y[i] - twice * hits->Ng.y[i];
        dir[2][i] = hits->I.z[i] - twice * hits->Ng.z[i];
        tmin[i] = 0;
        tmax[i] = 1e30f;
    }
    rays.n = n;
    rays.org = hits->P;
    rays.dir.x = dir[0], rays.dir.y = dir[1], rays.dir.z = dir[2];
    rays.tmin = tmin, rays.tmax = tmax;
    host->trace(ctx, &rays, out);
    for (i = 0; i < n; i++)
        out.x[i] += large[4096 * (i % 16)] * 0.0f, out.y[i] = out.z[i] = out.x[i];
}

static const RTSclass deep = {
    .struct_size = sizeof(RTSclass), .kind = RT_SURFACE_SHADER, .name = "deep", .shade = shade,
};

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &deep };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 1, classes };
    return host_abi >> 16 == RTS_ABI >> 16 ? &module : NULL;
}
