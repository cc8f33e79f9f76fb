/* SPDX-License-Identifier: GPL-3.0-or-later
 * Virtual lights as lights of an old shader: a room of the plugin `diffuse`, which loops over lights, shows what the same
 * room of MatteShader shows, whichever rendering object has virtual lights. Needs diffuse.so. */
#include "check.h"

static const float colors[5][3] = {
    { 0.8f, 0.8f, 0.8f }, { 0.7f, 0.7f, 0.7f }, { 0.8f, 0.2f, 0.1f }, { 0.2f, 0.7f, 0.1f }, { 0.5f, 0.5f, 0.9f }
};

/* A shader of the kind under test. Radiance of MatteShader is light times colour over pi, that of the plugin light times
 * colour. */
static void bind_color(int is_plugin, const float *color)
{
    if (rtGenNewShaderClass(is_plugin ? "diffuse" : "MatteShader", is_plugin ? "diffuse.so" : NULL) == RT_INVALID) {
        printf("%s\n", rtGetShaderClassInfoLog());
        exit(1);
    }
    rtGenNewShader();
    rtParameter3fv(rtParameterHandle("color"), color);
    if (is_plugin)
        rtParameter1i(rtParameterHandle("shadows"), 1);
}

static void face(const float *a, const float *b, const float *c, const float *d)
{
    rtBegin(RT_QUADS);
    rtVertex3fv(a);
    rtVertex3fv(b);
    rtVertex3fv(c);
    rtVertex3fv(d);
    rtEnd();
}

/* A box around [-1, 1]^2 x [-2, 0] without its front, and a board in it. */
static void room(int is_plugin)
{
    static const float p[8][3] = { { -1, -1, -2 }, { 1, -1, -2 }, { 1, 1, -2 }, { -1, 1, -2 },
                                   { -1, -1, 0 },  { 1, -1, 0 },  { 1, 1, 0 },  { -1, 1, 0 } };
    static const float board[4][3] = { { -0.5f, -0.6f, -1 }, { 0.3f, -0.5f, -0.8f }, { 0.3f, 0.2f, -1.1f },
                                       { -0.5f, 0.1f, -1.3f } };
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    bind_color(is_plugin, colors[0]);
    face(p[0], p[1], p[2], p[3]);
    bind_color(is_plugin, colors[1]);
    face(p[0], p[4], p[5], p[1]);
    face(p[3], p[2], p[6], p[7]);
    bind_color(is_plugin, colors[2]);
    face(p[0], p[3], p[7], p[4]);
    bind_color(is_plugin, colors[3]);
    face(p[1], p[5], p[6], p[2]);
    bind_color(is_plugin, colors[4]);
    face(board[0], board[1], board[2], board[3]);
    rtEndObject();
}

/* Mean of a part of the picture (four of them) and a channel. */
static double part(int number, int channel)
{
    double sum = 0;
    int x, y;
    for (y = 0; y < HEIGHT / 2; y++)
        for (x = 0; x < WIDTH / 2; x++)
            sum += frame[y + number / 2 * (HEIGHT / 2)][x + number % 2 * (WIDTH / 2)][channel];
    return sum / (WIDTH / 2 * (HEIGHT / 2));
}

static void light(double radiance)
{
    rtGenNewShaderClass("SpotLightShader", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("radiance"), (float)radiance, (float)radiance, (float)(0.7 * radiance));
    rtParameter3f(rtParameterHandle("position"), 0.4f, 0.6f, -0.6f);
}

/* Renders a room; the means of its parts, and of all. */
static double render(int is_plugin, const char *object, int samples, double means[4][3])
{
    double all = 0;
    int i, k;
    rtExit();
    use_frame();
    rtLookAt(0, 0, 3, 0, 0, -1, 0, 1, 0);
    rtPerspective(40, 0.1, 100);
    room(is_plugin);
    light(is_plugin ? 2.0 / 3.14159265358979 : 2.0);
    rtSetMaxRayRecursionDepth(5);
    CHECK(rtGenNewShaderClass(object, NULL) != RT_INVALID);
    rtUseRenderingObject(rtGenNewShader());
    rtParameter1i(rtParameterHandle("samplesPerPixel"), samples);
    rtParameter1i(rtParameterHandle("vplCount"), 64);
    EXPECT(rtRender(), RT_NO_ERROR);
    for (i = 0; i < 4; i++)
        for (k = 0; k < 3; k++)
            all += means[i][k] = part(i, k);
    return all / 12;
}

int main(void)
{
    static const char *const objects[] = { "InstantRadiosity", "BidirectionalInstantRadiosity",
                                           "MetropolisInstantRadiosity" };
    double direct[4][3], paths[4][3], matte[4][3], plugin[4][3], mean, all;
    int i, k, object;

    render(0, "Whitted", 16, direct);
    all = render(0, "PathTracer", 512, paths);
    /* Light that walls send to each other is a good part of it, and colours them. */
    CHECK(paths[0][0] > 1.3 * direct[0][0]);
    for (object = 0; object < 3; object++) {
        mean = render(0, objects[object], 64, matte);
        NEAR(mean / all, 1, 0.01);
        mean = render(1, objects[object], 64, plugin);
        NEAR(mean / all, 1, 0.01);
        for (i = 0; i < 4; i++)
            for (k = 0; k < 3; k++) {
                NEAR(matte[i][k] / paths[i][k], 1, 0.03);
                NEAR(plugin[i][k] / paths[i][k], 1, 0.03);
            }
    }
    FINISH();
}
