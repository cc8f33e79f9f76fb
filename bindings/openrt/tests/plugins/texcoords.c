/* SPDX-License-Identifier: GPL-3.0-or-later
 * Shows texture coordinates as colours. */
#include <openrt/rts.h>

static void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < hits->n; i++) {
        out.x[i] = hits->texcoord.x[i];
        out.y[i] = hits->texcoord.y[i];
        out.z[i] = hits->texcoord.z[i];
    }
}

static const RTSclass texcoords = {
    .struct_size = sizeof(RTSclass), .kind = RT_SURFACE_SHADER, .name = "texcoords", .shade = shade,
};

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &texcoords };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 1, classes };
    return host_abi >> 16 == RTS_ABI >> 16 ? &module : NULL;
}
