/* SPDX-License-Identifier: GPL-3.0-or-later
 * `diffuse`: a Lambertian surface, with or without shadows, its loops written for vector code.
 *
 *   cc -std=c99 -O3 -shared -fPIC diffuse.c $(pkg-config --cflags openrt) -o diffuse.so
 *
 * Arrays from the host begin at multiples of 64 bytes and have room for whole vectors, so each loop below runs over
 * lanes rounded up to a multiple of 16, without a remainder; `restrict` tells the compiler that arrays do not overlap.
 * gcc -O3 -fopt-info-vec shows which loops became vector code. With shadows 0 it shows what the built-in DiffuseShader
 * shows, with shadows 1 one batch of rays per light asks which lanes it reaches.
 *
 * | parameter | rate | default | meaning |
 * |---|---|---|---|
 * | color | shader | 1 1 1 | share of light that is reflected |
 * | texture | shader | 0 | id of a texture that the colour is multiplied with; 0 = none |
 * | shadows | shader | 0 | 1: a light must be seen to count |
 */
#include <openrt/rts.h>

struct diffuse {
    float color[3];
    int32_t texture, shadows;
};

static const RTSparam params[] = {
    { "color", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct diffuse, color) },
    { "texture", RT_INT, 1, RT_PER_SHADER, offsetof(struct diffuse, texture) },
    { "shadows", RT_INT, 1, RT_PER_SHADER, offsetof(struct diffuse, shadows) },
};

static void init(void *block)
{
    struct diffuse *shader = block;
    shader->color[0] = shader->color[1] = shader->color[2] = 1.0f;
}

/* The lanes of three arrays behind each other. */
static RTSvecm vectors(float **memory, uint32_t room)
{
    RTSvecm v;
    v.x = *memory, v.y = v.x + room, v.z = v.y + room;
    *memory += 3 * (size_t)room;
    return v;
}

/* 1 where normals keep their side; -1 where a flat surface is seen from behind. */
static void sides(uint32_t room, const RTShits *hits, float *restrict side)
{
    const float *restrict nx = hits->Ns.x, *restrict ny = hits->Ns.y, *restrict nz = hits->Ns.z;
    const float *restrict gx = hits->Ng.x, *restrict gy = hits->Ng.y, *restrict gz = hits->Ng.z;
    const float *restrict ix = hits->I.x, *restrict iy = hits->I.y, *restrict iz = hits->I.z;
    uint32_t i;
    for (i = 0; i < room; i++) {
        const float moved = (nx[i] - gx[i]) * (nx[i] - gx[i]) + (ny[i] - gy[i]) * (ny[i] - gy[i])
            + (nz[i] - gz[i]) * (nz[i] - gz[i]);
        const float away = gx[i] * ix[i] + gy[i] * iy[i] + gz[i] * iz[i];
        side[i] = (moved == 0.0f) & (away > 0.0f) ? -1.0f : 1.0f;
    }
}

/* How much of a light each lane's surface takes. */
static void cosines(uint32_t room, RTSvec normal, const float *restrict side, RTSvecm dir, float *restrict cosine)
{
    const float *restrict nx = normal.x, *restrict ny = normal.y, *restrict nz = normal.z;
    const float *restrict dx = dir.x, *restrict dy = dir.y, *restrict dz = dir.z;
    uint32_t i;
    for (i = 0; i < room; i++) {
        const float c = side[i] * (nx[i] * dx[i] + ny[i] * dy[i] + nz[i] * dz[i]);
        cosine[i] = c > 0.0f ? c : 0.0f;
    }
}

static void add_products(uint32_t room, const float *restrict a, const float *restrict b, float *restrict sum)
{
    uint32_t i;
    for (i = 0; i < room; i++)
        sum[i] += a[i] * b[i];
}

static void multiply(uint32_t room, const float *restrict a, float *restrict product)
{
    uint32_t i;
    for (i = 0; i < room; i++)
        product[i] *= a[i];
}

static void scale(uint32_t room, float a, float *restrict product)
{
    uint32_t i;
    for (i = 0; i < room; i++)
        product[i] *= a;
}

static void set(uint32_t room, float a, float *restrict values)
{
    uint32_t i;
    for (i = 0; i < room; i++)
        values[i] = a;
}

/* Multiplies radiance with what comes through on the way to the light, for the lanes that it may reach. */
static void shadow(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm dir, const float *dist,
                   const float *cosine, const float *zero, RTSvecm through, float *packed, uint32_t *parent,
                   RTSvecm radiance)
{
    const uint32_t room = (hits->n + 15) / 16 * 16;
    RTSvecm org = vectors(&packed, room), way = vectors(&packed, room);
    float *end = packed;
    RTSrays rays = { sizeof rays, 0, { 0, 0, 0 }, { 0, 0, 0 }, 0, 0, 0, 0 };
    uint32_t i, m = 0;
    for (i = 0; i < hits->n; i++) {
        if (cosine[i] > 0.0f) {
            /* P itself: the host starts the ray off the surface. */
            org.x[m] = hits->P.x[i], org.y[m] = hits->P.y[i], org.z[m] = hits->P.z[i];
            way.x[m] = dir.x[i], way.y[m] = dir.y[i], way.z[m] = dir.z[i];
            end[m] = dist[i];
            parent[m++] = i;
        }
    }
    if (m == 0)
        return;
    rays.n = m;
    rays.org.x = org.x, rays.org.y = org.y, rays.org.z = org.z;
    rays.dir.x = way.x, rays.dir.y = way.y, rays.dir.z = way.z;
    rays.tmin = zero, rays.tmax = end, rays.parent = parent;
    host->occluded(ctx, &rays, through);
    for (i = 0; i < m; i++) {
        radiance.x[parent[i]] *= through.x[i];
        radiance.y[parent[i]] *= through.y[i];
        radiance.z[parent[i]] *= through.z[i];
    }
}

static void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out)
{
    const struct diffuse *shader = hits->shader;
    const uint32_t room = (hits->n + 15) / 16 * 16, lights = host->light_count(ctx);
    float *memory = host->scratch(ctx, (size_t)room * 23 * sizeof(float));
    float *side, *cosine, *dist, *zero, *packed;
    RTSvecm dir, radiance, through;
    uint32_t *parent, light;
    uint8_t *lit;

    set(room, 0.0f, out.x), set(room, 0.0f, out.y), set(room, 0.0f, out.z);
    if (memory == NULL)
        return;
    side = memory, cosine = side + room, dist = cosine + room, zero = dist + room;
    memory = zero + room;
    dir = vectors(&memory, room), radiance = vectors(&memory, room), through = vectors(&memory, room);
    lit = (uint8_t *)memory, parent = (uint32_t *)(memory + room), packed = memory + 2 * (size_t)room;
    set(room, 0.0f, zero);

    sides(room, hits, side);
    for (light = 0; light < lights; light++) {
        host->illuminate(ctx, light, hits->n, hits->P, dir, dist, radiance, lit);
        cosines(room, hits->Ns, side, dir, cosine);
        if (shader->shadows)
            shadow(host, ctx, hits, dir, dist, cosine, zero, through, packed, parent, radiance);
        add_products(room, radiance.x, cosine, out.x);
        add_products(room, radiance.y, cosine, out.y);
        add_products(room, radiance.z, cosine, out.z);
    }
    scale(room, shader->color[0], out.x);
    scale(room, shader->color[1], out.y);
    scale(room, shader->color[2], out.z);
    if (shader->texture > 0) {
        host->texture(ctx, (uint32_t)shader->texture, hits->n, hits->texcoord.x, hits->texcoord.y, through, zero);
        multiply(room, through.x, out.x);
        multiply(room, through.y, out.y);
        multiply(room, through.z, out.z);
    }
}

static const RTSclass diffuse = {
    .struct_size = sizeof(RTSclass),
    .kind = RT_SURFACE_SHADER,
    .name = "diffuse",
    .shader_size = sizeof(struct diffuse),
    .shader_align = 16,
    .param_count = sizeof params / sizeof params[0],
    .params = params,
    .init = init,
    .shade = shade,
};

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &diffuse };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 1, classes };
    return host_abi >> 16 == RTS_ABI >> 16 ? &module : NULL;
}
