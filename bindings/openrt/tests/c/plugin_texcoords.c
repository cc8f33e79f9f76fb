/* SPDX-License-Identifier: GPL-3.0-or-later
 * Third and fourth texture coordinates: a shader sees s/q, t/q and r/q, divided where its point is, under the texture
 * matrix too. Needs texcoords.so beside it. */
#include "check.h"

/* The square [-1, 1] x [-1, 1] with these coordinates s, t, r, q at its corners; u goes to the right, v upwards. */
static void square(const float corners[4][4])
{
    static const float places[4][2] = { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } };
    int i;
    rtClearInstances();
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_QUADS);
    for (i = 0; i < 4; i++) {
        rtTexCoord4fv(corners[i]);
        rtVertex3f(places[i][0], places[i][1], 0);
    }
    rtEnd();
    rtEndObject();
    EXPECT(rtRender(), RT_NO_ERROR);
}

static void all(float s, float t, float r, float q)
{
    float corners[4][4];
    int i;
    for (i = 0; i < 4; i++) {
        corners[i][0] = s, corners[i][1] = t, corners[i][2] = r, corners[i][3] = q;
    }
    square((const float(*)[4])corners);
}

int main(void)
{
    /* A wall seen from the side: its right edge is three times as far away as its left one. */
    static const float wall[4][4] = { { 0, 0, 0, 1 }, { 1, 0, 2, 3 }, { 1, 1, 2, 3 }, { 0, 1, 0, 1 } };
    static const RTubyte black_white[2][4] = { { 0, 0, 0, 255 }, { 255, 255, 255, 255 } };
    const double x = 1.0 / 16, u = (1 + x) / 2, q = 1 + 2 * u;
    RTuint texture;
    helpers_are_used();
    use_frame();
    look_at_square();
    CHECK(rtGenNewShaderClass("texcoords", "./texcoords.so") != RT_INVALID);
    rtGenNewShader();

    all(0.25f, 0.5f, 0.75f, 1);
    SHOWS(0, 0, 0.25, 0.5, 0.75);
    all(0.5f, 1, 1.5f, 2);
    SHOWS(0, 0, 0.25, 0.5, 0.75);
    rtTexCoord3f(0.1f, 0.2f, 0.3f);
    rtClearInstances();
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(0, 0, 0.1, 0.2, 0.3);
    /* Two are as ever. */
    rtTexCoord2f(0.6f, 0.7f);
    rtClearInstances();
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(0, 0, 0.6, 0.7, 0);

    square(wall);
    SHOWS(x, x, u / q, u / q, 2 * u / q);
    SHOWS(-x, x, (1 - u) / (3 - 2 * u), u / (3 - 2 * u), 2 * (1 - u) / (3 - 2 * u));

    /* The texture matrix moves, scales and turns all four. */
    rtMatrixMode(RT_TEXTURE);
    rtTranslatef(0, 0, 0.5f);
    all(0.25f, 0.5f, 0.25f, 1);
    SHOWS(0, 0, 0.25, 0.5, 0.75);
    rtLoadIdentity();
    rtRotatef(90, 1, 0, 0); /* t becomes r */
    all(0.25f, 0.5f, 0, 1);
    SHOWS(0, 0, 0.25, 0, 0.5);
    rtLoadIdentity();
    rtScalef(2, 2, 2);
    all(0.5f, 1, 1.5f, 4);
    SHOWS(0, 0, 0.25, 0.5, 0.75);
    rtLoadIdentity();
    rtMatrixMode(RT_MODELVIEW);

    /* Textures are read at the divided coordinates, too: s/q is 1/4 where u is 1/2, left of the texture's middle; at
     * u = 0.9 it is 0.32. Undivided it would be 0.5 and more. */
    texture = rtGenTextures(1);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER, RT_NEAREST);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MIN_FILTER, RT_NEAREST);
    rtTexImage2D(RT_TEXTURE_2D, 0, 4, 2, 1, 0, RT_RGBA, RT_UNSIGNED_BYTE, black_white);
    rtGenNewShaderClass("TextureShader", NULL);
    rtGenNewShader();
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    square(wall);
    SHOWS(0.9, 0, 0, 0, 0);
    SHOWS(-0.9, 0, 0, 0, 0);
    FINISH();
}
