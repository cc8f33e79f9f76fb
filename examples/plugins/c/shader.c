/* SPDX-License-Identifier: GPL-3.0-or-later
 * The class of Figure 1 of the GNU RT paper as a plugin: `sample`, a parameter at each of the three rates.
 *
 *   cc -std=c99 -O3 -shared -fPIC shader.c $(pkg-config --cflags openrt) -o shader.so
 *
 * It shows the mean of the three colours, lit by the scene's lights without shadows, or from the eye where there are
 * none: the built-in class of the same name does the same.
 */
#include <openrt/rts.h>

/* The block per shader: what rtParameter* writes. */
struct sample {
    float color[3];
};

/* Blocks of the other rates are the host's: only their layout is told. */
struct of_triangle {
    float color[3];
};
struct of_vertex {
    float color[3];
};

static const RTSparam params[] = {
    { "shader_color", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct sample, color) },
    { "triangle_color", RT_FLOAT, 3, RT_PER_TRIANGLE, offsetof(struct of_triangle, color) },
    { "vertex_color", RT_FLOAT, 3, RT_PER_VERTEX, offsetof(struct of_vertex, color) },
};

static void init(void *block)
{
    struct sample *shader = block;
    shader->color[0] = shader->color[1] = shader->color[2] = 1.0f;
}

/* sum += radiance * |cosine|, in loops that compilers turn into vector code. */
static void add_cosine(uint32_t n, RTSvec normal, const float *side, RTSvec dir, RTSvec radiance, RTSvecm sum)
{
    uint32_t i;
    for (i = 0; i < n; i++) {
        float cosine = side[i] * (normal.x[i] * dir.x[i] + normal.y[i] * dir.y[i] + normal.z[i] * dir.z[i]);
        cosine = cosine > 0.0f ? cosine : 0.0f;
        sum.x[i] += radiance.x[i] * cosine;
        sum.y[i] += radiance.y[i] * cosine;
        sum.z[i] += radiance.z[i] * cosine;
    }
}

static RTSvec read_only(RTSvecm v)
{
    RTSvec same;
    same.x = v.x, same.y = v.y, same.z = v.z;
    return same;
}

static void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    const struct sample *shader = hits->shader;
    const uint32_t n = hits->n, lights = host->light_count(ctx);
    /* Arrays of our own: side, triangle colour, vertex colour, then what a light says. */
    const uint32_t room = (n + 15) / 16 * 16;
    float *memory = host->scratch(ctx, (size_t)room * 15 * sizeof(float));
    float *side = memory, *triangle = memory + room, *vertex = memory + 4 * (size_t)room;
    RTSvecm dir, radiance;
    float *dist;
    uint8_t *lit;
    uint32_t i, k, light;

    for (i = 0; i < n; i++)
        out.x[i] = out.y[i] = out.z[i] = 0.0f;
    if (memory == NULL)
        return;
    dir.x = memory + 7 * (size_t)room, dir.y = dir.x + room, dir.z = dir.y + room;
    radiance.x = dir.z + room, radiance.y = radiance.x + room, radiance.z = radiance.y + room;
    dist = radiance.z + room;
    lit = (uint8_t *)(dist + room);

    /* Normals that the program gave stay as they are; the geometric one turns towards the ray. */
    for (i = 0; i < n; i++) {
        const int flat = hits->Ns.x[i] == hits->Ng.x[i] && hits->Ns.y[i] == hits->Ng.y[i] && hits->Ns.z[i] == hits->Ng.z[i];
        side[i] = flat && hits->back[i] ? -1.0f : 1.0f;
    }
    if (lights == 0) {
        for (i = 0; i < n; i++) {
            const float cosine = hits->Ns.x[i] * hits->I.x[i] + hits->Ns.y[i] * hits->I.y[i] + hits->Ns.z[i] * hits->I.z[i];
            out.x[i] = out.y[i] = out.z[i] = cosine < 0.0f ? -cosine : cosine;
        }
    }
    for (light = 0; light < lights; light++) {
        host->illuminate(ctx, light, n, hits->P, dir, dist, radiance, lit);
        add_cosine(n, hits->Ns, side, read_only(dir), read_only(radiance), out);
    }

    /* One call per parameter, whatever its rate. Component k of lane i is [k * n + i]. */
    host->param(ctx, hits, 1, triangle);
    host->param(ctx, hits, 2, vertex);
    for (k = 0; k < 3; k++) {
        float *channel = k == 0 ? out.x : k == 1 ? out.y : out.z;
        for (i = 0; i < n; i++)
            channel[i] *= (shader->color[k] + triangle[k * n + i] + vertex[k * n + i]) / 3.0f;
    }
}

static const RTSclass sample = {
    .struct_size = sizeof(RTSclass),
    .kind = RT_SURFACE_SHADER,
    .name = "sample",
    .shader_size = sizeof(struct sample),
    .shader_align = 16,
    .triangle_size = sizeof(struct of_triangle),
    .vertex_size = sizeof(struct of_vertex),
    .param_count = sizeof params / sizeof params[0],
    .params = params,
    .init = init,
    .shade = shade,
};

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &sample };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 1, classes };
    return host_abi >> 16 == RTS_ABI >> 16 ? &module : NULL;
}
