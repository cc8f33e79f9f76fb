/* SPDX-License-Identifier: GPL-3.0-or-later
 * A turntable: a checkered floor with shadows, a mirror ball and a ring of coloured boxes that turns around it. Each
 * frame is rendered in the background while the one before it is written to a file.
 *
 *   cc turntable.c $(pkg-config --cflags --libs openrt) -lm -o turntable && ./turntable frame 24
 *
 * writes frame000.ppm to frame023.ppm.
 */
#include <math.h>
#include <openrt/rt.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 640
#define HEIGHT 360
#define BOXES 9
#define PI 3.14159265358979

/* One is shown to us while the other is rendered to. */
static RTubyte pixels[2][HEIGHT][WIDTH][3];

static int write_ppm(const char *name, int number, int buffer)
{
    char path[1024];
    FILE *file;
    int row;
    snprintf(path, sizeof path, "%s%03d.ppm", name, number);
    file = fopen(path, "wb");
    if (file == NULL)
        return 1;
    fprintf(file, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
    for (row = HEIGHT - 1; row >= 0; row--)
        fwrite(pixels[buffer][row], 3, WIDTH, file);
    return fclose(file) != 0;
}

/* Two light and two dark fields. */
static RTuint checker_texture(void)
{
    const RTubyte texels[] = { 170, 160, 145, 50, 55, 70, 50, 55, 70, 170, 160, 145 };
    const RTuint texture = rtGenTextures(1);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, 2, 2, 0, RT_RGB, RT_UNSIGNED_BYTE, texels);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER, RT_NEAREST);
    return texture;
}

static void define_floor(void)
{
    rtGenNewShaderClass("TexturedDiffuseShader", NULL);
    rtGenNewShader();
    rtParameter1i(rtParameterHandle("texture"), (RTint)checker_texture());
    rtParameter3f(rtParameterHandle("radiance"), 0.12f, 0.13f, 0.16f);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtNormal3f(0, 1, 0);
    rtBegin(RT_QUADS);
    rtTexCoord2f(0, 0), rtVertex3f(-12, 0, 12);
    rtTexCoord2f(8, 0), rtVertex3f(12, 0, 12);
    rtTexCoord2f(8, 8), rtVertex3f(12, 0, -12);
    rtTexCoord2f(0, 8), rtVertex3f(-12, 0, -12);
    rtEnd();
    rtEndObject();
}

/* A mirror ball of radius 1 on the floor, as strips from pole to pole. */
static void define_ball(void)
{
    const int slices = 96, stacks = 48;
    int i, j, k;
    rtGenNewShaderClass("MirrorShader", NULL);
    rtGenNewShader();
    rtParameter1f(rtParameterHandle("attenuation"), 0.85f);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    for (i = 0; i < slices; i++) {
        rtBegin(RT_TRIANGLE_STRIP);
        for (j = 0; j <= stacks; j++) {
            for (k = 0; k < 2; k++) {
                const double longitude = 2 * PI * (i + k) / slices, latitude = PI * (0.5 - (double)j / stacks);
                const double x = cos(latitude) * sin(longitude), y = sin(latitude), z = cos(latitude) * cos(longitude);
                rtNormal3d(x, y, z);
                rtVertex3d(x, y + 1, z);
            }
        }
        rtEnd();
    }
    rtEndObject();
}

/* A box of edge 1 standing on the floor, flat shaded. */
static RTuint define_box(void)
{
    static const float corners[8][3] = { { -.5f, 0, -.5f }, { .5f, 0, -.5f }, { .5f, 0, .5f }, { -.5f, 0, .5f },
                                         { -.5f, 1, -.5f }, { .5f, 1, -.5f }, { .5f, 1, .5f }, { -.5f, 1, .5f } };
    static const int faces[6][4] = { { 0, 1, 2, 3 }, { 7, 6, 5, 4 }, { 0, 4, 5, 1 },
                                     { 1, 5, 6, 2 }, { 2, 6, 7, 3 }, { 3, 7, 4, 0 } };
    const RTuint box = rtCreateObject(RT_DEFINE);
    int face, k;
    rtBegin(RT_QUADS);
    for (face = 0; face < 6; face++)
        for (k = 0; k < 4; k++)
            rtVertex3fv(corners[faces[face][k]]);
    rtEnd();
    rtEndObject();
    return box;
}

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "frame";
    const int frames = argc > 2 ? atoi(argv[2]) : 24;
    RTuint ring[BOXES];
    int failed = 0, frame, i;

    rtGenNewShaderClass("SpotLightShader", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("radiance"), 60, 55, 48);
    rtParameter3f(rtParameterHandle("position"), 4, 7, 5);
    /* A dim light from the other side, so that nothing is black. */
    rtGenNewShaderClass("InfiniteLightShader", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("radiance"), 0.18f, 0.2f, 0.25f);
    rtParameter3f(rtParameterHandle("direction"), -3, 2, 1);
    rtGenNewShaderClass("ConstantEnvironmentShader", NULL);
    rtUseEnvironmentShader(rtGenNewShader());
    rtParameter3f(rtParameterHandle("value"), 0.25f, 0.4f, 0.65f);

    define_floor();
    define_ball();
    for (i = 0; i < BOXES; i++) {
        const float hue = (float)i / BOXES;
        rtGenNewShaderClass("DiffuseShader", NULL);
        rtGenNewShader();
        rtParameter3f(rtParameterHandle("color"), 0.9f * (1 - hue), 0.3f + 0.4f * hue, 0.9f * hue);
        ring[i] = rtInstantiateObject(define_box());
    }

    rtLookAt(0, 3, 7.5, 0, 0.8, 0, 0, 1, 0);
    rtPerspective(45, 0.1, 100);
    for (frame = 0; frame < frames; frame++) {
        for (i = 0; i < BOXES; i++) {
            rtLoadIdentity();
            rtRotatef(360.f * (i + (float)frame / frames) / BOXES, 0, 1, 0);
            rtTranslatef(2.4f, 0, 0);
            rtScalef(0.7f, 0.4f + 0.1f * i, 0.7f);
            rtUpdateInstance(ring[i]);
        }
        /* Ends the frame before and starts this one, which goes on while the other is written. */
        rtSetFrameBuffer(&pixels[frame % 2][0][0][0], WIDTH, HEIGHT, RT_RGB_8);
        rtSwapBuffers();
        if (frame > 0)
            failed |= write_ppm(name, frame - 1, (frame - 1) % 2);
    }
    if (frames > 0) {
        rtEndRendering();
        failed |= write_ppm(name, frames - 1, (frames - 1) % 2);
    }
    if (rtGetError() != RT_NO_ERROR)
        failed = 1;
    rtExit();
    return failed;
}
