/* SPDX-License-Identifier: GPL-3.0-or-later
 * Minified textures: a checkerboard to the horizon is grey far away and equals the picture of many samples; mirrors see it so,
 * too; RT_TEXTURE matrices scale it; every filter and every wrong one. */
#include "check.h"

#define SIZE 64
static float sharp[SIZE][SIZE][4], truth[SIZE][SIZE][4], filtered[SIZE][SIZE][4];
static RTuint texture;

static void checkerboard(void)
{
    static float texels[64][64];
    int x, y;
    for (y = 0; y < 64; y++)
        for (x = 0; x < 64; x++)
            texels[y][x] = (float)((x / 8 + y / 8) % 2);
    texture = rtGenTextures(1);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_LUMINANCE, 64, 64, 0, RT_LUMINANCE, RT_FLOAT, texels);
}

/* A floor of 400 x 400 textures, or 100 x 100 of a matrix times four. */
static void floor_plane(void)
{
    rtGenNewShaderClass("TextureShader", NULL);
    rtGenNewShader();
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    rtMatrixMode(RT_TEXTURE);
    rtScalef(4, 4, 1);
    rtMatrixMode(RT_MODELVIEW);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_QUADS);
    rtTexCoord2f(0, 0), rtVertex3f(-200, 0, 200);
    rtTexCoord2f(100, 0), rtVertex3f(200, 0, 200);
    rtTexCoord2f(100, 100), rtVertex3f(200, 0, -200);
    rtTexCoord2f(0, 100), rtVertex3f(-200, 0, -200);
    rtEnd();
    rtEndObject();
}

static void filter(RTenum value)
{
    rtBindTexture(RT_TEXTURE_2D, texture);
    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MIN_FILTER, (RTint)value), RT_NO_ERROR);
}

static void draw(float (*out)[SIZE][4], RTuint samples)
{
    rtSetFrameBuffer((RTubyte *)out, SIZE, SIZE, RT_RGBA_32);
    rtSetSamplesPerPixel(samples);
    rtRender();
}

/* Root of the mean square of the difference from a picture, or from a grey, in some rows. */
static double difference(float (*a)[SIZE][4], float (*b)[SIZE][4], int first, int last)
{
    double sum = 0;
    int x, y;
    for (y = first; y < last; y++)
        for (x = 0; x < SIZE; x++) {
            const double d = a[y][x][0] - (b ? b[y][x][0] : 0.5);
            sum += d * d;
        }
    return sqrt(sum / ((last - first) * SIZE));
}

/* The same for a picture of the floor: far rows, near rows. */
static void compare(void)
{
    static const RTenum filters[] = { RT_LINEAR_MIPMAP_NEAREST, RT_NEAREST_MIPMAP_LINEAR, RT_NEAREST_MIPMAP_NEAREST,
                                      RT_LINEAR_MIPMAP_LINEAR };
    int i, far_from = SIZE / 2 - 12, far_to = SIZE / 2 - 2;
    filter(RT_LINEAR);
    draw(sharp, 1);
    draw(truth, 256);
    CHECK(difference(sharp, NULL, far_from, far_to) > 0.3);
    CHECK(difference(truth, NULL, far_from, far_to) < 0.12);
    for (i = 0; i < 4; i++) {
        filter(filters[i]);
        draw(filtered, 1);
        CHECK(difference(filtered, NULL, far_from + 6, far_to) < 0.05);
        CHECK(difference(filtered, truth, far_from, far_to) < 0.5 * difference(sharp, truth, far_from, far_to));
        CHECK(difference(filtered, truth, far_from, far_to) < 0.12);
    }
    /* Samples of filtered texels are as good near by. */
    draw(filtered, 256);
    CHECK(difference(filtered, truth, 0, SIZE / 4) < 0.25);
}

int main(void)
{
    RTuint mirror;
    helpers_are_used();
    checkerboard();
    floor_plane();
    rtPerspective(60, 0.1, 1000);
    rtLookAt(0.3, 2, 0, 0.3, 2, -10, 0, 1, 0);
    compare();

    /* From behind, in a mirror across the view: the cone goes on. */
    rtMatrixMode(RT_TEXTURE);
    rtLoadIdentity();
    rtMatrixMode(RT_MODELVIEW);
    rtGenNewShaderClass("MirrorShader", NULL);
    mirror = rtGenNewShader();
    CHECK(mirror != RT_INVALID);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_QUADS);
    rtVertex3f(-50, -1, -1), rtVertex3f(50, -1, -1), rtVertex3f(50, 50, -1), rtVertex3f(-50, 50, -1);
    rtEnd();
    rtEndObject();
    compare();

    /* Near by, nothing is filtered: as without. */
    rtClearInstances();
    rtExit();
    checkerboard();
    rtGenNewShaderClass("TextureShader", NULL);
    rtGenNewShader();
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_QUADS);
    rtTexCoord2f(0, 0), rtVertex2f(-1, -1);
    rtTexCoord2f(0.5f, 0), rtVertex2f(1, -1);
    rtTexCoord2f(0.5f, 0.5f), rtVertex2f(1, 1);
    rtTexCoord2f(0, 0.5f), rtVertex2f(-1, 1);
    rtEnd();
    rtEndObject();
    look_at_square();
    draw(sharp, 1);
    filter(RT_LINEAR_MIPMAP_LINEAR);
    draw(filtered, 1);
    CHECK(difference(sharp, filtered, 0, SIZE) == 0);

    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER, (RTint)RT_LINEAR_MIPMAP_LINEAR), RT_INVALID_ENUM);
    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MIN_FILTER, 0x2704), RT_INVALID_ENUM);
    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MIN_FILTER, 0x2602), RT_INVALID_ENUM);
    FINISH();
}
