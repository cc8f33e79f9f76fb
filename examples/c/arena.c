/* SPDX-License-Identifier: GPL-3.0-or-later
 * A small game without a player: balls run in an arena between pillars, bounce, and are lit by three lights, one of which
 * follows a ball. Objects are defined once; each frame moves their instances.
 *
 *   cc arena.c $(pkg-config --cflags --libs rtut openrt) -lm -o arena && ./arena frame 24 640 360
 *
 * writes frame000.ppm to frame023.ppm.
 */
#include "picture.h"
#include <math.h>
#include <openrt/rt.h>
#include <openrt/rtut.h>
#include <stdlib.h>

#define BALLS 12
#define PILLARS 8
#define SIZE 6.f
#define RADIUS 0.45f

static struct {
    float x, z, vx, vz, spin;
    RTuint instance;
} balls[BALLS];
static float pillars[PILLARS][2];
static RTuint lamp;
static unsigned dice = 12345;

static float random_number(void)
{
    dice = dice * 1664525u + 1013904223u;
    return (float)(dice >> 8) / 16777216.f;
}

static RTuint shader_of(const char *class_name)
{
    rtGenNewShaderClass(class_name, NULL);
    return rtGenNewShader();
}

static RTuint floor_texture(void)
{
    static RTubyte texels[64][64][3];
    const RTuint texture = rtGenTextures(1);
    int x, y, k;
    for (y = 0; y < 64; y++)
        for (x = 0; x < 64; x++)
            for (k = 0; k < 3; k++) {
                const int line = x % 32 == 0 || y % 32 == 0, field = (x / 32 + y / 32) % 2;
                texels[y][x][k] = (RTubyte)(line ? 30 : field ? 96 + 8 * k : 60 + 6 * k);
            }
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, 64, 64, 0, RT_RGB, RT_UNSIGNED_BYTE, texels);
    return texture;
}

static void light(float r, float g, float b, float x, float y, float z)
{
    rtUseLight(shader_of("SpotLightShader"));
    rtParameter3f(rtParameterHandle("radiance"), r, g, b);
    rtParameter3f(rtParameterHandle("position"), x, y, z);
}

static void define_arena(void)
{
    const RTuint box = rtGenObjects(1);
    int i;
    shader_of("Phong");
    rtParameter1i(rtParameterHandle("diffuseTexture"), (RTint)floor_texture());
    rtParameter3f(rtParameterHandle("diffuseColor"), 1, 1, 1);
    rtParameter1f(rtParameterHandle("reflective"), 0.12f);
    rtParameter1i(rtParameterHandle("maxDepth"), 2);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtNormal3f(0, 1, 0);
    rtBegin(RT_QUADS);
    rtTexCoord2f(0, 0), rtVertex3f(-SIZE, 0, SIZE);
    rtTexCoord2f(8, 0), rtVertex3f(SIZE, 0, SIZE);
    rtTexCoord2f(8, 8), rtVertex3f(SIZE, 0, -SIZE);
    rtTexCoord2f(0, 8), rtVertex3f(-SIZE, 0, -SIZE);
    rtEnd();
    rtEndObject();

    /* Walls and pillars are one box, many times. */
    shader_of("Phong");
    rtParameter3f(rtParameterHandle("diffuseColor"), 0.5f, 0.45f, 0.4f);
    rtNewObject(box, RT_DEFINE);
    rtutCube();
    for (i = 0; i < 4; i++) {
        rtLoadIdentity();
        rtRotatef(90.f * i, 0, 1, 0);
        rtTranslatef(0, 0.25f, -SIZE - 0.2f);
        rtScalef(SIZE + 0.4f, 0.35f, 0.2f);
        rtInstantiateObject(box);
    }
    for (i = 0; i < PILLARS; i++) {
        const float angle = 6.2831853f * (float)i / PILLARS, far = i % 2 ? 2.2f : 4.2f;
        pillars[i][0] = far * cosf(angle), pillars[i][1] = far * sinf(angle);
        rtLoadIdentity();
        rtTranslatef(pillars[i][0], 0.8f, pillars[i][1]);
        rtScalef(0.3f, 0.8f, 0.3f);
        rtInstantiateObject(box);
    }
}

static void define_balls(void)
{
    static const float colors[3][3] = { { 0.8f, 0.15f, 0.1f }, { 0.1f, 0.45f, 0.75f }, { 0.85f, 0.65f, 0.1f } };
    RTuint kinds[4];
    int i;
    /* The current matrix would go into the object's vertices. */
    rtLoadIdentity();
    for (i = 0; i < 4; i++) {
        shader_of("Phong");
        if (i < 3)
            rtParameter3fv(rtParameterHandle("diffuseColor"), colors[i]);
        else
            rtParameter3f(rtParameterHandle("diffuseColor"), 0.05f, 0.05f, 0.05f);
        rtParameter3f(rtParameterHandle("specularColor"), 0.7f, 0.7f, 0.7f);
        rtParameter1f(rtParameterHandle("shininess"), 0.5f);
        rtParameter1f(rtParameterHandle("reflective"), i < 3 ? 0.1f : 0.8f);
        kinds[i] = rtCreateObject(RT_DEFINE);
        rtutSphere(32, 16);
        rtEndObject();
    }
    for (i = 0; i < BALLS; i++) {
        const float angle = 6.2831853f * ((float)i + 0.5f) / BALLS, far = 3.2f + 1.6f * (float)(i % 2);
        balls[i].x = far * cosf(angle), balls[i].z = far * sinf(angle);
        balls[i].vx = 5 * random_number() - 2.5f, balls[i].vz = 5 * random_number() - 2.5f;
        balls[i].instance = rtInstantiateObject(kinds[i % 4]);
    }
}

/* Pushes a ball out of a circle, and turns its speed. */
static void bounce(int i, float x, float z, float distance)
{
    const float dx = balls[i].x - x, dz = balls[i].z - z, length = sqrtf(dx * dx + dz * dz);
    float speed;
    if (length >= distance || length <= 0)
        return;
    balls[i].x = x + dx / length * distance, balls[i].z = z + dz / length * distance;
    speed = (balls[i].vx * dx + balls[i].vz * dz) / length;
    if (speed < 0)
        balls[i].vx -= 2 * speed * dx / length, balls[i].vz -= 2 * speed * dz / length;
}

static void step(float seconds)
{
    const float edge = SIZE - RADIUS;
    int i, j;
    for (i = 0; i < BALLS; i++) {
        balls[i].x += seconds * balls[i].vx, balls[i].z += seconds * balls[i].vz;
        balls[i].spin += seconds * 90;
        if (fabsf(balls[i].x) > edge)
            balls[i].x = balls[i].x > 0 ? edge : -edge, balls[i].vx = -balls[i].vx;
        if (fabsf(balls[i].z) > edge)
            balls[i].z = balls[i].z > 0 ? edge : -edge, balls[i].vz = -balls[i].vz;
        for (j = 0; j < PILLARS; j++)
            bounce(i, pillars[j][0], pillars[j][1], RADIUS + 0.35f);
        for (j = 0; j < BALLS; j++)
            if (j != i)
                bounce(i, balls[j].x, balls[j].z, 2 * RADIUS);
        rtLoadIdentity();
        rtTranslatef(balls[i].x, RADIUS, balls[i].z);
        rtRotatef(balls[i].spin, 0, 1, 0);
        rtScalef(RADIUS, RADIUS, RADIUS);
        rtUpdateInstance(balls[i].instance);
    }
    rtBindShader(lamp);
    rtParameter3f(rtParameterHandle("position"), balls[0].x, 2.2f, balls[0].z);
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

    light(40, 36, 30, 5, 8, 4);
    light(14, 18, 30, -7, 6, -3);
    lamp = shader_of("SpotLightShader");
    rtParameter3f(rtParameterHandle("radiance"), 4, 2.2f, 1);
    rtUseLight(lamp);
    rtUseEnvironmentShader(shader_of("ConstantEnvironmentShader"));
    rtParameter3f(rtParameterHandle("value"), 0.03f, 0.04f, 0.07f);
    define_arena();
    define_balls();
    rtLookAt(0, 8, 10.5, 0, 0, 0.6, 0, 1, 0);
    rtPerspective(42, 0.1, 100);
    rtSetSamplesPerPixel(4);

    for (frame = 0; frame <= frames; frame++) {
        if (frame < frames) {
            step(1.f / 24);
            rtSetFrameBuffer(pixels[frame % 2], (RTuint)width, (RTuint)height, RT_RGB_8);
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
