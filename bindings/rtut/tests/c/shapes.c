/* SPDX-License-Identifier: GPL-3.0-or-later
 * Shapes: how many triangles each has, where it is, that bad arguments give nothing, and that errors are libOpenRT's. */
#include "../../../openrt/tests/c/check.h"
#include <openrt/rtut.h>

#define SIZE 32
static float picture[SIZE][SIZE][4];

static int triangles_before;

static RTuint begin(void)
{
    triangles_before = integer(RT_TRIANGLE_COUNT);
    return rtCreateObject(RT_DEFINE);
}

static int end(void)
{
    rtEndObject();
    return integer(RT_TRIANGLE_COUNT) - triangles_before;
}

/* The object's first shader shows a diffuse white under a light from the eye: n * d at the pixel. */
static void show(RTuint object)
{
    const RTuint instance = rtInstantiateObject(object);
    rtSetFrameBuffer((RTubyte *)picture, SIZE, SIZE, RT_RGBA_32);
    rtRender();
    rtDeleteInstance(instance);
}

static const float *pixel(double x, double y)
{
    return picture[(int)((y + 1) / 2 * SIZE)][(int)((x + 1) / 2 * SIZE)];
}

int main(void)
{
    RTuint sphere, cube, torus, teapot, logo, light;
    helpers_are_used();

    rtGenNewShaderClass("InfiniteLightShader", NULL);
    light = rtGenNewShader();
    rtParameter3f(rtParameterHandle("direction"), 0, 0, 1);
    rtUseLight(light);
    look_at_square();
    rtGenNewShaderClass("DiffuseShader", NULL);
    rtGenNewShader();

    sphere = begin();
    rtutSphere(64, 32);
    CHECK(end() == 2 * 64 * 31);
    cube = begin();
    rtutCube();
    CHECK(end() == 12);
    torus = begin();
    rtutTorus(0.25, 0.75, 24, 48);
    CHECK(end() == 2 * 24 * 48);
    teapot = begin();
    rtutTeapot(0.5);
    CHECK(end() == 32 * 200 - 80);
    logo = begin();
    rtutLogo();
    CHECK(end() == 24 + 2 * 48 * 23);
    CHECK(rtGetError() == RT_NO_ERROR);

    /* A unit sphere under a light from the eye: the cosine is z. */
    show(sphere);
    NEAR(pixel(0.01, 0.01)[0], 1, 0.02);
    NEAR(pixel(0.51, 0.51)[0], sqrt(1 - 2 * 0.53125 * 0.53125), 0.02);
    CHECK(pixel(-0.95, 0.95)[3] == 0);
    show(cube);
    NEAR(pixel(0.5, -0.5)[0], 1, 1e-6);
    CHECK(pixel(0.99, 0.99)[3] == 1);
    show(torus);
    CHECK(pixel(0, 0)[3] == 0);
    NEAR(pixel(0.74, 0.01)[0], 1, 0.02);
    show(teapot);
    CHECK(pixel(0, 0)[3] == 1);
    CHECK(pixel(0.9, -0.9)[3] == 0);
    show(logo);
    NEAR(pixel(0.01, 0.01)[0], 1, 0.02);
    NEAR(pixel(0.01, 0.8)[0], 1, 1e-6);
    CHECK(pixel(0.01, 0.32)[3] == 0);

    /* Arguments out of range: nothing, and no error. */
    begin();
    rtutSphere(2, 8);
    rtutSphere(8, -1);
    rtutSphere(1000000, 1000000);
    rtutTorus(1, 0.5, 8, 8);
    rtutTorus(0, 0.5, 8, 8);
    rtutTorus(0.1, 0.5, 2, 8);
    rtutTeapot(0);
    rtutTeapot(-1);
    CHECK(end() == 0);
    CHECK(rtGetError() == RT_NO_ERROR);

    /* Errors are those of the calls that are made. */
    rtBindShader(light);
    begin();
    EXPECT(rtutCube(), RT_INVALID_OPERATION);
    CHECK(end() == 0);
    FINISH();
}
