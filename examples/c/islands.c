/* SPDX-License-Identifier: GPL-3.0-or-later
 * The kind of program that OpenRT was made for: a terrain, a torus and a sphere in a sky box, everything sent anew for each
 * frame in immediate mode. The torus is a mirror, the sphere is textured, the sea is see-through.
 *
 *   cc islands.c $(pkg-config --cflags --libs rtut openrt) -lm -o islands && ./islands frame 24 640 360
 *
 * writes frame000.ppm to frame023.ppm.
 */
#include "picture.h"
#include <math.h>
#include <openrt/rt.h>
#include <openrt/rtut.h>
#include <stdlib.h>

#define GRID 96
#define PI 3.14159265358979

static RTuint sky_shader[6], terrain_shader, sea_shader, mirror_shader, globe_shader;
static RTuint terrain, torus, globe, sea, box[6], sun, camera;

static float noise(int x, int y)
{
    unsigned n = (unsigned)(x * 374761393) + (unsigned)y * 668265263u;
    n = (n ^ (n >> 13)) * 1274126177u;
    return (float)((n ^ (n >> 16)) & 0xffff) / 65535.f;
}

/* Smooth noise of one octave. */
static float octave(float x, float y)
{
    const int i = (int)floor(x), j = (int)floor(y);
    float u = x - (float)i, v = y - (float)j, a, b;
    u = u * u * (3 - 2 * u), v = v * v * (3 - 2 * v);
    a = noise(i, j) * (1 - u) + noise(i + 1, j) * u;
    b = noise(i, j + 1) * (1 - u) + noise(i + 1, j + 1) * u;
    return a * (1 - v) + b * v;
}

static float height(float x, float y)
{
    float sum = 0, size = 1, frequency = 0.35f;
    int i;
    for (i = 0; i < 5; i++, size *= 0.5f, frequency *= 2.1f)
        sum += size * (octave(x * frequency, y * frequency) - 0.5f);
    /* Away from the middle it falls below the sea. */
    return 1.3f * sum + 0.6f - 0.016f * (x * x + y * y);
}

static RTuint texture_of(int size, void (*texel)(double, double, RTubyte *))
{
    RTubyte *texels = malloc((size_t)size * (size_t)size * 3);
    const RTuint texture = rtGenTextures(1);
    int x, y;
    for (y = 0; y < size; y++)
        for (x = 0; x < size; x++)
            texel((x + 0.5) / size, (y + 0.5) / size, texels + 3 * (y * size + x));
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, size, size, 0, RT_RGB, RT_UNSIGNED_BYTE, texels);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_T, RT_CLAMP_TO_EDGE);
    free(texels);
    return texture;
}

static void stripes(double s, double t, RTubyte *rgb)
{
    const int on = (int)(12 * s) % 2 == (int)(6 * t) % 2;
    rgb[0] = on ? 200 : 40, rgb[1] = on ? 60 : 40, rgb[2] = on ? 40 : 60;
}

static int side_of_sky;

/* A face of the sky: bright at the horizon, blue above, clouds between. The box's directions decide, so faces fit. */
static void sky(double s, double t, RTubyte *rgb)
{
    static const double out[6][3] = { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } };
    static const double right[6][3] = { { 0, -1, 0 }, { 0, 1, 0 }, { 1, 0, 0 }, { -1, 0, 0 }, { 0, -1, 0 }, { 0, -1, 0 } };
    static const double up[6][3] = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 }, { -1, 0, 0 }, { 1, 0, 0 } };
    double dir[3], length = 0, rise, cloud;
    int k;
    for (k = 0; k < 3; k++) {
        dir[k] = out[side_of_sky][k] + (2 * s - 1) * right[side_of_sky][k] + (2 * t - 1) * up[side_of_sky][k];
        length += dir[k] * dir[k];
    }
    rise = dir[2] / sqrt(length);
    if (rise < 0)
        rise = 0;
    cloud = 0;
    if (rise > 0.02) {
        const float x = (float)(2 * dir[0] / dir[2]), y = (float)(2 * dir[1] / dir[2]);
        cloud = octave(x + 50, y + 50) * 0.6 + octave(2.3f * x + 70, 2.3f * y) * 0.3 + octave(5 * x, 5 * y) * 0.15 - 0.5;
        cloud = cloud < 0 ? 0 : cloud * 2.2 * (rise < 0.25 ? rise * 4 : 1);
    }
    rgb[0] = (RTubyte)(255 * fmin(1, 0.30 + 0.42 * (1 - sqrt(rise)) + cloud * 0.6));
    rgb[1] = (RTubyte)(255 * fmin(1, 0.48 + 0.30 * (1 - sqrt(rise)) + cloud * 0.5));
    rgb[2] = (RTubyte)(255 * fmin(1, 0.78 + 0.08 * (1 - sqrt(rise)) + cloud * 0.2));
}

static RTuint shader_of(const char *class_name)
{
    rtGenNewShaderClass(class_name, NULL);
    return rtGenNewShader();
}

/* A face of the box, seen from within. */
static RTuint define_sky(int side)
{
    static const float corner[6][4][3] = {
        { { 1, 1, -1 }, { 1, -1, -1 }, { 1, -1, 1 }, { 1, 1, 1 } },   { { -1, -1, -1 }, { -1, 1, -1 }, { -1, 1, 1 }, { -1, -1, 1 } },
        { { -1, 1, -1 }, { 1, 1, -1 }, { 1, 1, 1 }, { -1, 1, 1 } },   { { 1, -1, -1 }, { -1, -1, -1 }, { -1, -1, 1 }, { 1, -1, 1 } },
        { { 1, 1, 1 }, { 1, -1, 1 }, { -1, -1, 1 }, { -1, 1, 1 } },   { { -1, 1, -1 }, { -1, -1, -1 }, { 1, -1, -1 }, { 1, 1, -1 } },
    };
    static const float st[4][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } };
    RTuint object, texture;
    int k;
    side_of_sky = side;
    texture = texture_of(256, sky);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_S, RT_CLAMP_TO_EDGE);
    sky_shader[side] = shader_of("TextureShader");
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    object = rtNewObject(RT_DEFINE);
    rtBegin(RT_QUADS);
    for (k = 0; k < 4; k++) {
        rtTexCoord2fv(st[k]);
        rtVertex3f(100 * corner[side][k][0], 100 * corner[side][k][1], 100 * corner[side][k][2]);
    }
    rtEnd();
    rtEndObject();
    return object;
}

static void terrain_vertex(float x, float y)
{
    const float h = height(x, y), e = 0.05f;
    const float dx = (height(x + e, y) - h) / e, dy = (height(x, y + e) - h) / e;
    const float steep = sqrtf(dx * dx + dy * dy);
    /* Sand, grass, rock, snow. */
    if (h < 0.08f)
        rtColor3f(0.55f, 0.48f, 0.30f);
    else if (steep > 1.1f)
        rtColor3f(0.30f, 0.27f, 0.24f);
    else if (h > 0.95f)
        rtColor3f(0.85f, 0.87f, 0.9f);
    else
        rtColor3f(0.12f, 0.26f, 0.07f);
    rtNormal3f(-dx, -dy, 1);
    rtVertex3f(x, y, h);
}

static void define_scene(void)
{
    int i, j, side;
    sun = shader_of("InfiniteLightShader");
    camera = shader_of("PinholeCameraShader");

    terrain_shader = shader_of("Phong");
    rtParameter1i(rtParameterHandle("useVertexColor"), 1);
    terrain = rtNewObject(RT_DEFINE);
    for (j = 0; j < GRID; j++) {
        rtBegin(RT_QUAD_STRIP);
        for (i = 0; i <= GRID; i++) {
            const float x = 16.f * (float)i / GRID - 8, y0 = 16.f * (float)j / GRID - 8;
            terrain_vertex(x, y0 + 16.f / GRID);
            terrain_vertex(x, y0);
        }
        rtEnd();
    }
    rtEndObject();

    sea_shader = shader_of("Phong");
    rtParameter3f(rtParameterHandle("diffuseColor"), 0.02f, 0.10f, 0.14f);
    rtParameter3f(rtParameterHandle("specularColor"), 0.6f, 0.6f, 0.5f);
    rtParameter1f(rtParameterHandle("shininess"), 0.9f);
    rtParameter1f(rtParameterHandle("transparency"), 0.35f);
    rtParameter1f(rtParameterHandle("reflective"), 0.45f);
    rtParameter1i(rtParameterHandle("maxDepth"), 3);
    sea = rtNewObject(RT_DEFINE);
    rtNormal3f(0, 0, 1);
    rtBegin(RT_QUADS);
    rtVertex2f(-60, -60), rtVertex2f(60, -60), rtVertex2f(60, 60), rtVertex2f(-60, 60);
    rtEnd();
    rtEndObject();

    mirror_shader = shader_of("MirrorShader");
    rtParameter1f(rtParameterHandle("attenuation"), 0.85f);
    torus = rtNewObject(RT_DEFINE);
    rtutTorus(0.28, 0.9, 32, 64);
    rtEndObject();

    globe_shader = shader_of("TexturedDiffuseShader");
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture_of(256, stripes));
    rtParameter3f(rtParameterHandle("radiance"), 0.25f, 0.27f, 0.3f);
    globe = rtNewObject(RT_DEFINE);
    rtutSphere(48, 24);
    rtEndObject();

    for (side = 0; side < 6; side++)
        box[side] = define_sky(side);
}

/* In immediate mode a frame shows what was said since the last one began. */
static void say_frame(double time, double aspect)
{
    const double turn = 0.6 + 0.5 * sin(2 * PI * time), distance = 8.5, rise = 2.6, half = tan(0.5 * 50 * PI / 180);
    const double eye[3] = { distance * cos(turn), distance * sin(turn), rise };
    double dir[3] = { -eye[0], -eye[1], 0.5 - eye[2] }, right[3], up[3], length = sqrt(distance * distance + 2.1 * 2.1);
    int k, side;
    for (k = 0; k < 3; k++)
        dir[k] /= length;
    right[0] = dir[1], right[1] = -dir[0], right[2] = 0;
    length = sqrt(right[0] * right[0] + right[1] * right[1]);
    right[0] *= half * aspect / length, right[1] *= half * aspect / length;
    up[0] = (right[1] * dir[2] - right[2] * dir[1]) / aspect;
    up[1] = (right[2] * dir[0] - right[0] * dir[2]) / aspect;
    up[2] = (right[0] * dir[1] - right[1] * dir[0]) / aspect;

    rtBindShader(camera);
    rtParameter3f(rtParameterHandle("origin"), (float)eye[0], (float)eye[1], (float)eye[2]);
    rtParameter3f(rtParameterHandle("lowerLeft"), (float)(dir[0] - right[0] - up[0]), (float)(dir[1] - right[1] - up[1]),
                  (float)(dir[2] - right[2] - up[2]));
    rtParameter3f(rtParameterHandle("horizontal"), (float)(2 * right[0]), (float)(2 * right[1]), (float)(2 * right[2]));
    rtParameter3f(rtParameterHandle("vertical"), (float)(2 * up[0]), (float)(2 * up[1]), (float)(2 * up[2]));
    rtUseCamera(camera);

    rtBindShader(sun);
    rtParameter3f(rtParameterHandle("direction"), (float)(0.6 + 0.2 * cos(2 * PI * time)), -0.5f, 0.55f);
    rtParameter3f(rtParameterHandle("radiance"), 1.5f, 1.35f, 1.1f);
    rtUseLight(sun);

    rtLoadIdentity();
    rtInstantiateObject(terrain);
    rtInstantiateObject(sea);
    for (side = 0; side < 6; side++)
        rtInstantiateObject(box[side]);
    rtPushMatrix();
    rtTranslatef(2.2f, -1.4f, 1.9f);
    rtRotated(360 * time, 0, 0, 1);
    rtRotated(60, 1, 0, 0);
    rtInstantiateObject(torus);
    rtPopMatrix();
    rtPushMatrix();
    rtTranslated(2.0 + 0.4 * sin(2 * PI * time), 1.9, 1.6 + 0.3 * cos(4 * PI * time));
    rtRotated(720 * time, 0, 0, 1);
    rtScalef(0.7f, 0.7f, 0.7f);
    rtInstantiateObject(globe);
    rtPopMatrix();
}

int main(int argc, char **argv)
{
    const char *name;
    RTubyte *pixels[2];
    int frames, width, height, frame, failed = 0;
    rtInit(&argc, argv);
    name = argc > 1 ? argv[1] : "frame";
    frames = argc > 2 ? atoi(argv[2]) : 24;
    width = argc > 4 ? atoi(argv[3]) : 640;
    height = argc > 4 ? atoi(argv[4]) : 360;
    if (frames < 1 || width < 1 || height < 1)
        return 1;
    pixels[0] = malloc((size_t)width * (size_t)height * 3);
    pixels[1] = malloc((size_t)width * (size_t)height * 3);

    define_scene();
    rtSceneMode(RT_IMMEDIATE);
    rtSetSamplesPerPixel(4);
    for (frame = 0; frame <= frames; frame++) {
        if (frame < frames) {
            say_frame((double)frame / frames, (double)width / height);
            rtSetFrameBuffer(pixels[frame % 2], (RTuint)width, (RTuint)height, RT_RGB_8);
            /* Ends the frame before, whose picture is written while this one is rendered. */
            rtSwapBuffers();
        } else
            rtEndRendering();
        if (frame > 0) {
            char path[1024];
            snprintf(path, sizeof path, "%s%03d.ppm", name, frame - 1);
            failed |= write_ppm(path, pixels[(frame - 1) % 2], width, height);
        }
    }
    if (rtGetError() != RT_NO_ERROR)
        failed = 1;
    rtExit();
    free(pixels[0]);
    free(pixels[1]);
    return failed;
}
