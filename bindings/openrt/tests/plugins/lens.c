/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cameras that look down at the middle of a square for a quarter of their lens, and away from it for the rest. */
#include <openrt/rts.h>

static void down(RTSvecm org, RTSvecm dir, uint32_t i, int is_down)
{
    org.x[i] = 0, org.y[i] = 0, org.z[i] = 10;
    dir.x[i] = 0, dir.y[i] = 0, dir.z[i] = is_down ? -1.f : 1.f;
}

static void plain(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, const float *x, const float *y,
                  RTSvecm org, RTSvecm dir)
{
    uint32_t i;
    (void)host, (void)ctx, (void)block, (void)x, (void)y;
    for (i = 0; i < n; i++)
        down(org, dir, i, 1);
}

static void lens(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, const float *x, const float *y,
                 const float *lens_x, const float *lens_y, const float *time, RTSvecm org, RTSvecm dir)
{
    uint32_t i;
    (void)host, (void)ctx, (void)block, (void)x, (void)y;
    for (i = 0; i < n; i++) {
        const int is_middle = lens_x[i] == 0.5f && lens_y[i] == 0.5f, is_quarter = lens_x[i] < 0.5f && lens_y[i] < 0.5f;
        down(org, dir, i, (is_middle || is_quarter) && time[i] >= 0 && time[i] <= 1);
    }
}

static const RTSclass with_lens = {
    .struct_size = sizeof(RTSclass), .kind = RT_CAMERA_SHADER, .name = "lens", .camera_lens = lens,
};

/* Of version 1.0: what lies beyond its size is not read. */
static const RTSclass without = {
    .struct_size = offsetof(RTSclass, camera_lens), .kind = RT_CAMERA_SHADER, .name = "plain", .camera = plain,
    .camera_lens = lens,
};

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &with_lens, &without };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 2, classes };
    return host_abi >> 16 == RTS_ABI >> 16 ? &module : NULL;
}
