/* SPDX-License-Identifier: GPL-3.0-or-later
 * `chrome`, in C++11: a coloured mirror that is brighter at grazing angles [Sch94]. All reflections of a batch are traced
 * with one call.
 *
 *   c++ -std=c++11 -O3 -shared -fPIC -fno-exceptions chrome.cpp $(pkg-config --cflags openrt) -o chrome.so
 *
 * | parameter | rate | default | meaning |
 * |---|---|---|---|
 * | tint | shader | 0.9 0.9 0.9 | share of light that is reflected at right angles |
 * | fresnel | shader | 1 | 1: at grazing angles all light is reflected; 0: as much as elsewhere |
 */
#include <openrt/rts.h>

#include <cstddef>
#include <new>

namespace {

struct Chrome {
    float tint[3] = { 0.9f, 0.9f, 0.9f };
    float fresnel = 1.0f;
};

const RTSparam params[] = {
    { "tint", RT_FLOAT, 3, RT_PER_SHADER, offsetof(Chrome, tint) },
    { "fresnel", RT_FLOAT, 1, RT_PER_SHADER, offsetof(Chrome, fresnel) },
};

struct Vec {
    float x, y, z;
};

Vec operator*(float s, Vec v) { return { s * v.x, s * v.y, s * v.z }; }
Vec operator-(Vec a, Vec b) { return { a.x - b.x, a.y - b.y, a.z - b.z }; }
float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec lane(const RTSvec &v, uint32_t i) { return { v.x[i], v.y[i], v.z[i] }; }

/* Arrays of n floats from the host's scratch memory. */
struct Memory {
    float *next;
    uint32_t n;
    float *array() { float *here = next; next += n; return here; }
    RTSvecm vectors() { RTSvecm v = { array(), array(), array() }; return v; }
};

RTSvec read_only(const RTSvecm &v) { RTSvec same = { v.x, v.y, v.z }; return same; }

void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    const Chrome &chrome = *static_cast<const Chrome *>(hits->shader);
    const uint32_t n = hits->n;
    Memory memory = { static_cast<float *>(host->scratch(ctx, 6 * n * sizeof(float))), n };
    if (memory.next == nullptr)
        return; /* what is not written becomes black */
    const RTSvecm mirrored = memory.vectors();
    float *tmin = memory.array(), *tmax = memory.array(), *grazing = memory.array();

    for (uint32_t i = 0; i < n; i++) {
        const Vec in = lane(hits->I, i);
        Vec geometric = lane(hits->Ng, i), normal = lane(hits->Ns, i);
        if (hits->back[i])
            geometric = -1.0f * geometric;
        if (dot(normal, geometric) < 0.0f)
            normal = -1.0f * normal;
        Vec way = in - 2.0f * dot(in, normal) * normal;
        /* An interpolated normal may send the ray through the surface: then the geometric one counts. */
        if (dot(way, geometric) <= 0.0f)
            way = in - 2.0f * dot(in, geometric) * geometric;
        const float square = dot(way, way);
        const float rest = 1.0f - (dot(in, normal) < 0.0f ? -dot(in, normal) : dot(in, normal));
        grazing[i] = chrome.fresnel * rest * rest * rest * rest * rest;
        /* Unit but for rounding: one step of Newton's method for 1 / sqrt(square). */
        way = (1.5f - 0.5f * square) * way;
        mirrored.x[i] = way.x;
        mirrored.y[i] = way.y;
        mirrored.z[i] = way.z;
        tmin[i] = 0.0f; /* the host starts rays that leave P off the surface */
        tmax[i] = 3.4e38f;
    }
    const RTSrays rays = { sizeof(RTSrays), n, hits->P, read_only(mirrored), tmin, tmax, nullptr, nullptr };
    host->trace(ctx, &rays, out);
    for (int k = 0; k < 3; k++) {
        float *channel = k == 0 ? out.x : k == 1 ? out.y : out.z;
        for (uint32_t i = 0; i < n; i++)
            channel[i] *= chrome.tint[k] + (1.0f - chrome.tint[k]) * grazing[i];
    }
}

void init(void *block) { new (block) Chrome; }
void fini(void *block) { static_cast<Chrome *>(block)->~Chrome(); }

RTSclass describe()
{
    RTSclass c = RTSclass();
    c.struct_size = sizeof(RTSclass);
    c.kind = RT_SURFACE_SHADER;
    c.name = "chrome";
    c.shader_size = sizeof(Chrome);
    c.shader_align = 16;
    c.param_count = sizeof params / sizeof params[0];
    c.params = params;
    c.init = init;
    c.fini = fini;
    c.shade = shade;
    return c;
}

}

extern "C" RTS_EXPORT const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass chrome = describe();
    static const RTSclass *const classes[] = { &chrome };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 1, classes };
    return host_abi >> 16 == RTS_ABI >> 16 ? &module : nullptr;
}
