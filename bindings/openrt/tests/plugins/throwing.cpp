// SPDX-License-Identifier: GPL-3.0-or-later
// Every function of a plugin throws, some by choice of a parameter.
#include <openrt/rts.h>
#include <stdexcept>
#include <string>

namespace {

struct block { int32_t throws; };

const RTSparam params[] = {
    { "throws", RT_INT, 1, RT_PER_SHADER, offsetof(struct block, throws) },
};

// Objects with destructors on the way, as real programs have them.
void fail(const std::string &where)
{
    std::string message = "from " + where;
    throw std::runtime_error(message);
}

void fill(RTSvecm out, uint32_t n, float value)
{
    for (uint32_t i = 0; i < n; i++)
        out.x[i] = out.y[i] = out.z[i] = value;
}

int prepare(const RTShost *, void *snapshot)
{
    if (static_cast<block *>(snapshot)->throws == 2)
        fail("prepare");
    return 0;
}

void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    int32_t throws = static_cast<const block *>(hits->shader)->throws;
    if (throws == 3) {
        // From behind a ray: another call of this function throws, and this one goes on.
        float *tmin = static_cast<float *>(host->scratch(ctx, hits->n * 2 * sizeof(float))), *tmax = tmin + hits->n;
        for (uint32_t i = 0; i < hits->n; i++)
            tmin[i] = 0, tmax[i] = 100;
        RTSrays rays = RTSrays();
        rays.struct_size = sizeof rays, rays.n = hits->n;
        rays.org = hits->P, rays.dir = hits->I, rays.tmin = tmin, rays.tmax = tmax;
        if (*hits->depth == 0) {
            host->trace(ctx, &rays, out);
            fill(out, hits->n, 0.75f);
            return;
        }
        fail("shade");
    }
    if (throws == 1)
        fail("shade");
    fill(out, hits->n, 0.25f);
}

void transmit(const RTShost *, RTSctx *, const RTShits *hits, RTSvecm out)
{
    if (static_cast<const block *>(hits->shader)->throws == 4)
        fail("transmit");
    fill(out, hits->n, 1);
}

void miss(const RTShost *, RTSctx *, const void *data, const RTSrays *rays, RTSvecm out)
{
    if (static_cast<const block *>(data)->throws == 1)
        fail("miss");
    fill(out, rays->n, 0.5f);
}

void illuminate(const RTShost *, RTSctx *, const void *data, uint32_t n, RTSvec, RTSvecm dir, float *dist, RTSvecm radiance,
                uint8_t *lit)
{
    if (static_cast<const block *>(data)->throws == 1)
        fail("illuminate");
    fill(radiance, n, 1);
    for (uint32_t i = 0; i < n; i++)
        dir.x[i] = dir.y[i] = 0, dir.z[i] = 1, dist[i] = 100, lit[i] = 1;
}

void camera(const RTShost *, RTSctx *, const void *data, uint32_t n, const float *x, const float *y, RTSvecm org, RTSvecm dir)
{
    if (static_cast<const block *>(data)->throws == 1)
        throw 7; // no object at all
    for (uint32_t i = 0; i < n; i++) {
        org.x[i] = 2 * x[i] - 1, org.y[i] = 2 * y[i] - 1, org.z[i] = 10;
        dir.x[i] = dir.y[i] = 0, dir.z[i] = -1;
    }
}

void bad_init(void *) { fail("init"); }
void bad_fini(void *) { fail("fini"); }

RTSclass of(uint32_t kind, const char *name)
{
    RTSclass made = RTSclass();
    made.struct_size = sizeof made, made.kind = kind, made.name = name;
    made.shader_size = sizeof(block), made.shader_align = 16;
    made.param_count = 1, made.params = params, made.prepare = prepare;
    made.shade = kind == RT_SURFACE_SHADER ? shade : NULL;
    made.miss = kind == RT_ENV_SHADER ? miss : NULL;
    made.illuminate = kind == RT_LIGHT_SHADER ? illuminate : NULL;
    made.camera = kind == RT_CAMERA_SHADER ? camera : NULL;
    return made;
}

} // namespace

const RTSmodule *rts_module(uint32_t)
{
#ifdef MODULE_THROWS
    fail("rts_module");
#endif
    static RTSclass surface = of(RT_SURFACE_SHADER, "surface"), glass = of(RT_SURFACE_SHADER, "glass");
    static RTSclass environment = of(RT_ENV_SHADER, "environment"), light = of(RT_LIGHT_SHADER, "light");
    static RTSclass lens = of(RT_CAMERA_SHADER, "camera");
    static RTSclass init = of(RT_SURFACE_SHADER, "init"), fini = of(RT_SURFACE_SHADER, "fini");
    glass.transmit = transmit, init.init = bad_init, fini.fini = bad_fini;
    static const RTSclass *const classes[] = { &surface, &glass, &environment, &light, &lens, &init, &fini };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 7, classes };
    return &module;
}
