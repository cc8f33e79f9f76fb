/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A picture in letters of a torus: rays of a camera, then shadow rays to a light. cc shade.c -lgnurt -lm */
#include <gnurt/rays.h>

#include <math.h>
#include <stdio.h>

enum { AROUND = 48, ALONG = 24, WIDTH = 60, HEIGHT = 24 };

static float positions[AROUND * ALONG][3];
static uint32_t quads[AROUND * ALONG][4];
static float directions[WIDTH * HEIGHT][3], points[WIDTH * HEIGHT][3], t[WIDTH * HEIGHT], normals[WIDTH * HEIGHT][3];
static uint8_t shadowed[WIDTH * HEIGHT];

static int fails(int status)
{
    if (status)
        fprintf(stderr, "%s\n", gnurt_last_error());
    return status;
}

int main(void)
{
    const float turn = 6.2831853f, eye[3] = { 0, -4, 3 }, sun[3] = { 0.6f, -0.3f, 0.74f };
    for (int i = 0; i < AROUND; i++)
        for (int j = 0; j < ALONG; j++) {
            float a = turn * i / AROUND, b = turn * j / ALONG, r = 1.5f + 0.6f * cosf(b);
            int v = i * ALONG + j, right = (i + 1) % AROUND * ALONG, up = (j + 1) % ALONG;
            positions[v][0] = r * cosf(a), positions[v][1] = r * sinf(a), positions[v][2] = 0.6f * sinf(b);
            quads[v][0] = v, quads[v][1] = right + j, quads[v][2] = right + up, quads[v][3] = i * ALONG + up;
        }
    gnurt_scene *scene = gnurt_scene_new();
    gnurt_array vertices = { positions, AROUND * ALONG, 0, GNURT_F32 }, faces = { quads, AROUND * ALONG, 0, GNURT_U32 };
    if (fails(gnurt_add_quads(scene, vertices, faces, 1, NULL)) || fails(gnurt_commit(scene)))
        return 1;

    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float x = (i % WIDTH + 0.5f) / WIDTH - 0.5f, y = 0.5f - (i / WIDTH + 0.5f) / HEIGHT;
        directions[i][0] = 1.2f * x, directions[i][1] = 0.8f + 0.6f * y, directions[i][2] = -0.6f + 0.8f * y;
    }
    gnurt_rays rays = { WIDTH * HEIGHT, { eye, 1, 0, GNURT_F32 }, { directions, WIDTH * HEIGHT, 0, GNURT_F32 }, { 0 }, { 0 }, { 0 } };
    gnurt_query coherent = { 0, 1, NULL, NULL };
    gnurt_hits hits = { 0, t, NULL, NULL, NULL, NULL, NULL, normals[0] };
    if (fails(gnurt_intersect(scene, &rays, &coherent, &hits)))
        return 1;

    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int k = 0; k < 3; k++)
            points[i][k] = eye[k] + (isinf(t[i]) ? 1e3f : t[i]) * directions[i][k] + 1e-3f * normals[i][k];
    gnurt_rays to_sun = { WIDTH * HEIGHT, { points, WIDTH * HEIGHT, 0, GNURT_F32 }, { sun, 1, 0, GNURT_F32 }, { 0 }, { 0 }, { 0 } };
    if (fails(gnurt_occluded(scene, &to_sun, &coherent, shadowed)))
        return 1;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float facing = normals[i][0] * sun[0] + normals[i][1] * sun[1] + normals[i][2] * sun[2];
        putchar(isinf(t[i]) ? ' ' : shadowed[i] || facing <= 0 ? '.' : "-+*%#@"[(int)(5.99f * facing)]);
        if (i % WIDTH == WIDTH - 1)
            putchar('\n');
    }
    gnurt_scene_free(scene);
    return 0;
}
