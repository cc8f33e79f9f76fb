/* SPDX-License-Identifier: GPL-3.0-or-later
 * Three classes in one library: a light, a camera and an environment.
 *
 *   cc -std=c99 -O3 -shared -fPIC studio.c $(pkg-config --cflags openrt) -lm -o studio.so
 *
 * | class | parameter | default | meaning |
 * |---|---|---|---|
 * | cone (light) | position, target | 0 0 1, 0 0 0 | where it is and what it looks at |
 * | | radiance | 1 1 1 | what arrives at distance 1 on its axis |
 * | | angle | 30 | degrees from its axis to its edge; it fades out towards that |
 * | fisheye (camera) | eye, target, up | 0 0 1, 0 0 0, 0 1 0 | as rtLookAt |
 * | | angle | 180 | degrees from edge to edge of the picture |
 * | sky (environment) | zenith, horizon, ground | colours | from above to below; y is up |
 */
#include <math.h>
#include <openrt/rts.h>

#define DEGREES 0.01745329251994329577

static void subtract(const float a[3], const float b[3], float difference[3])
{
    int k;
    for (k = 0; k < 3; k++)
        difference[k] = a[k] - b[k];
}

static void cross(const float a[3], const float b[3], float product[3])
{
    product[0] = a[1] * b[2] - a[2] * b[1];
    product[1] = a[2] * b[0] - a[0] * b[2];
    product[2] = a[0] * b[1] - a[1] * b[0];
}

/* 0 if it has no direction. */
static int normalize(float v[3])
{
    const float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    int k;
    if (!(length > 0.0f) || isinf(length))
        return 0;
    for (k = 0; k < 3; k++)
        v[k] /= length;
    return 1;
}

/* ---- The light ----------------------------------------------------------------------------------------------- */

struct cone {
    float position[3], target[3], radiance[3], angle;
    /* Computed once per frame, in the frame's copy of the block. */
    float axis[3], edge;
};

static const RTSparam cone_params[] = {
    { "position", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct cone, position) },
    { "target", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct cone, target) },
    { "radiance", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct cone, radiance) },
    { "angle", RT_FLOAT, 1, RT_PER_SHADER, offsetof(struct cone, angle) },
};

static void cone_init(void *block)
{
    struct cone *light = block;
    light->position[2] = 1.0f;
    light->radiance[0] = light->radiance[1] = light->radiance[2] = 1.0f;
    light->angle = 30.0f;
}

static int cone_prepare(const RTShost *host, void *snapshot)
{
    struct cone *light = snapshot;
    subtract(light->target, light->position, light->axis);
    light->edge = (float)cos(light->angle * DEGREES);
    if (normalize(light->axis))
        return 0;
    host->log(NULL, 2, "cone: position and target are the same point");
    return 1;
}

static void cone_illuminate(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, RTSvec P, RTSvecm dir,
                            float *dist, RTSvecm radiance, uint8_t *lit)
{
    const struct cone *light = block;
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < n; i++) {
        const float x = light->position[0] - P.x[i], y = light->position[1] - P.y[i], z = light->position[2] - P.z[i];
        const float square = x * x + y * y + z * z, length = sqrtf(square);
        const float cosine = -(x * light->axis[0] + y * light->axis[1] + z * light->axis[2]) / length;
        /* From 0 at the edge to 1 on the axis, smoothly. */
        float share = (cosine - light->edge) / (1.0f - light->edge);
        share = share < 0.0f ? 0.0f : share > 1.0f ? 1.0f : share;
        share = share * share * (3.0f - 2.0f * share) / square;
        lit[i] = length > 0.0f && share > 0.0f;
        dir.x[i] = x, dir.y[i] = y, dir.z[i] = z; /* the host makes it unit */
        dist[i] = length;
        radiance.x[i] = share * light->radiance[0];
        radiance.y[i] = share * light->radiance[1];
        radiance.z[i] = share * light->radiance[2];
    }
}

/* ---- The camera ---------------------------------------------------------------------------------------------- */

struct fisheye {
    float eye[3], target[3], up[3], angle;
    float right[3], above[3], forward[3];
};

static const RTSparam fisheye_params[] = {
    { "eye", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct fisheye, eye) },
    { "target", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct fisheye, target) },
    { "up", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct fisheye, up) },
    { "angle", RT_FLOAT, 1, RT_PER_SHADER, offsetof(struct fisheye, angle) },
};

static void fisheye_init(void *block)
{
    struct fisheye *camera = block;
    camera->eye[2] = 1.0f;
    camera->up[1] = 1.0f;
    camera->angle = 180.0f;
}

static int fisheye_prepare(const RTShost *host, void *snapshot)
{
    struct fisheye *camera = snapshot;
    subtract(camera->target, camera->eye, camera->forward);
    cross(camera->forward, camera->up, camera->right);
    cross(camera->right, camera->forward, camera->above);
    if (normalize(camera->forward) && normalize(camera->right) && normalize(camera->above))
        return 0;
    host->log(NULL, 2, "fisheye: eye, target and up give no view");
    return 1;
}

static void fisheye_rays(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, const float *x,
                         const float *y, RTSvecm org, RTSvecm dir)
{
    const struct fisheye *camera = block;
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < n; i++) {
        /* The distance from the middle of the picture is the angle to the axis. */
        const float across = 2.0f * x[i] - 1.0f, upwards = 2.0f * y[i] - 1.0f;
        const float radius = sqrtf(across * across + upwards * upwards);
        const float angle = (float)(0.5 * DEGREES) * camera->angle * radius;
        const float sine = radius > 0.0f ? sinf(angle) / radius : 0.0f, cosine = cosf(angle);
        const float r = sine * across, a = sine * upwards;
        org.x[i] = camera->eye[0], org.y[i] = camera->eye[1], org.z[i] = camera->eye[2];
        dir.x[i] = r * camera->right[0] + a * camera->above[0] + cosine * camera->forward[0];
        dir.y[i] = r * camera->right[1] + a * camera->above[1] + cosine * camera->forward[1];
        dir.z[i] = r * camera->right[2] + a * camera->above[2] + cosine * camera->forward[2];
    }
}

/* ---- The environment ----------------------------------------------------------------------------------------- */

struct sky {
    float zenith[3], horizon[3], ground[3];
};

static const RTSparam sky_params[] = {
    { "zenith", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct sky, zenith) },
    { "horizon", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct sky, horizon) },
    { "ground", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct sky, ground) },
};

static void sky_init(void *block)
{
    static const struct sky day = { { 0.1f, 0.25f, 0.7f }, { 0.7f, 0.8f, 0.9f }, { 0.2f, 0.18f, 0.15f } };
    *(struct sky *)block = day;
}

static void sky_miss(const RTShost *host, RTSctx *ctx, const void *block, const RTSrays *rays, RTSvecm out)
{
    const struct sky *sky = block;
    uint32_t i;
    (void)host, (void)ctx;
    for (i = 0; i < rays->n; i++) {
        const float height = rays->dir.y[i], share = sqrtf(fabsf(height));
        const float *end = height < 0.0f ? sky->ground : sky->zenith;
        out.x[i] = sky->horizon[0] + share * (end[0] - sky->horizon[0]);
        out.y[i] = sky->horizon[1] + share * (end[1] - sky->horizon[1]);
        out.z[i] = sky->horizon[2] + share * (end[2] - sky->horizon[2]);
    }
}

/* ---- The module ---------------------------------------------------------------------------------------------- */

static const RTSclass cone = {
    .struct_size = sizeof(RTSclass), .kind = RT_LIGHT_SHADER, .name = "cone",
    .shader_size = sizeof(struct cone), .shader_align = 16,
    .param_count = sizeof cone_params / sizeof cone_params[0], .params = cone_params,
    .init = cone_init, .prepare = cone_prepare, .illuminate = cone_illuminate,
};

static const RTSclass fisheye = {
    .struct_size = sizeof(RTSclass), .kind = RT_CAMERA_SHADER, .name = "fisheye",
    .shader_size = sizeof(struct fisheye), .shader_align = 16,
    .param_count = sizeof fisheye_params / sizeof fisheye_params[0], .params = fisheye_params,
    .init = fisheye_init, .prepare = fisheye_prepare, .camera = fisheye_rays,
};

static const RTSclass sky = {
    .struct_size = sizeof(RTSclass), .kind = RT_ENV_SHADER, .name = "sky",
    .shader_size = sizeof(struct sky), .shader_align = 16,
    .param_count = sizeof sky_params / sizeof sky_params[0], .params = sky_params,
    .init = sky_init, .miss = sky_miss,
};

const RTSmodule *rts_module(uint32_t host_abi)
{
    static const RTSclass *const classes[] = { &cone, &fisheye, &sky };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 3, classes };
    return host_abi >> 16 == RTS_ABI >> 16 ? &module : NULL;
}
