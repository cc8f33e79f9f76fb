/* SPDX-License-Identifier: GPL-3.0-or-later
 * Pictures against their formulas, pixel by pixel: point light, pinhole camera, texture wrapping and filtering, depth
 * of reflection, normals under matrices. */
#include "check.h"

/* The point of the square that pixel i shows. */
static double x_of(int i) { return (i % WIDTH + 0.5) / WIDTH * 2 - 1; }
static double y_of(int i) { return (i / WIDTH + 0.5) / HEIGHT * 2 - 1; }

static RTuint shader_of(const char *name)
{
    rtGenNewShaderClass(name, NULL);
    return rtGenNewShader();
}

static void set3(const char *parameter, float x, float y, float z)
{
    rtParameter3f(rtParameterHandle(parameter), x, y, z);
}

static void object_of_square(void)
{
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
}

/* E color cos / d^2, with and without shadows; a lamp around the light's place does not shadow it. */
static void point_light(void)
{
    const double place[3] = { 0.3, -0.2, 2 };
    RTuint light = shader_of("SpotLightShader");
    int shadows, i;
    set3("radiance", 8, 4, 2);
    set3("position", (float)place[0], (float)place[1], (float)place[2]);
    rtUseLight(light);
    for (shadows = 0; shadows < 2; shadows++) {
        if (shadows) {
            shader_of("TexturedDiffuseShader");
            set3("radiance", 0, 0, 0);
        } else {
            shader_of("DiffuseShader");
            set3("color", 1, 1, 1);
        }
        object_of_square();
        rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
        rectangle(-5, -5, 5, 5, 2);
        rtEndObject();
        rtLookAt(0, 0, 1, 0, 0, 0, 0, 1, 0);
        rtRender();
        for (i = 0; i < WIDTH * HEIGHT; i++) {
            const double dx = place[0] - x_of(i), dy = place[1] - y_of(i), d2 = dx * dx + dy * dy + 4;
            const double share = 2 / sqrt(d2) / d2;
            SHOWS(x_of(i), y_of(i), 8 * share, 4 * share, 2 * share);
        }
        rtClearInstances();
    }
    rtRemoveLight(light);
    look_at_square();
}

/* dir = lowerLeft + x horizontal + y vertical; a plane far below shows where each ray goes. */
static void pinhole(void)
{
    const RTuint camera = shader_of("PinholeCameraShader");
    RTuint vertex;
    int i, k;
    set3("origin", 1, 2, 5);
    set3("lowerLeft", -1, -0.5f, -2);
    set3("vertical", 0.1f, 1.5f, 0);
    set3("horizontal", 3, 0, 0.2f);
    rtUseCamera(camera);
    shader_of("sample");
    set3("shader_color", 0, 0, 0);
    vertex = rtParameterHandle("vertex_color");
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    set3("triangle_color", 0, 0, 0);
    rtBegin(RT_QUADS);
    for (k = 0; k < 4; k++) {
        const int right = k == 1 || k == 2, top = k >= 2;
        rtParameter3f(vertex, 3.f * right, 3.f * top, 0);
        rtVertex3f(right ? 100.f : -100.f, top ? 100.f : -100.f, 0);
    }
    rtEnd();
    rtEndObject();
    rtRender();
    for (i = 0; i < WIDTH * HEIGHT; i++) {
        const double x = (x_of(i) + 1) / 2, y = (y_of(i) + 1) / 2;
        const double dir[3] = { -1 + 3 * x + 0.1 * y, -0.5 + 1.5 * y, -2 + 0.2 * x }, t = 5 / -dir[2];
        /* Lit from the eye: the cosine of what is seen. */
        const double cosine = -dir[2] / sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
        SHOWS(x_of(i), y_of(i), cosine * (1 + t * dir[0] + 100) / 200, cosine * (2 + t * dir[1] + 100) / 200, 0);
    }
    rtClearInstances();
    /* Immediate mode forgets the camera with this frame. */
    rtSceneMode(RT_IMMEDIATE);
    rtRender();
    rtSceneMode(RT_RETAINED);
}

/* How much of the square cameras of each kind see from (0, 0, 2). */
static void looking(void)
{
    static const char *const names[4] = { "OrthographicCameraShader", "ThinLensCameraShader", "FisheyeCameraShader",
                                          "PanoramicCameraShader" };
    const double pi = acos(-1.0);
    int kind, i;
    for (kind = 0; kind < 4; kind++) {
        const RTuint camera = shader_of(names[kind]);
        int wanted = 0;
        set3("eye", 0, 0, 2);
        set3("target", 0, 0, 0);
        if (kind == 0)
            rtParameter1f(rtParameterHandle("height"), 3.7f);
        else if (kind == 1)
            rtParameter1f(rtParameterHandle("fov"), 80);
        constant_shader(1, 1, 1);
        object_of_square();
        rtUseCamera(camera);
        rtRender();
        for (i = 0; i < WIDTH * HEIGHT; i++) {
            const double x = x_of(i), y = y_of(i), angle = sqrt(x * x + y * y) * pi / 2, up = y * pi / 2;
            double right = x * 1.85, above = y * 1.85;
            if (kind == 1) {
                right = 2 * x * tan(40 * pi / 180), above = 2 * y * tan(40 * pi / 180);
            } else if (kind == 2) {
                right = 2 * tan(angle) * x / sqrt(x * x + y * y), above = 2 * tan(angle) * y / sqrt(x * x + y * y);
                right = angle < pi / 2 ? right : 9;
            } else if (kind == 3) {
                right = fabs(x) < 0.5 ? 2 * tan(x * pi) : 9, above = 2 * tan(up) / cos(x * pi);
            }
            wanted += fabs(right) < 1 && fabs(above) < 1;
        }
        if (covered() != wanted || wanted == 0) {
            printf("%s sees the square in %d pixels, not %d\n", names[kind], covered(), wanted);
            failures++;
        }
        rtClearInstances();
    }
    /* Immediate mode forgets the camera with this frame. */
    rtSceneMode(RT_IMMEDIATE);
    rtRender();
    rtSceneMode(RT_RETAINED);
}

static const RTubyte texels[2][3][3] = { { { 255, 0, 0 }, { 0, 255, 0 }, { 0, 0, 255 } },
                                         { { 255, 255, 0 }, { 0, 255, 255 }, { 255, 0, 255 } } };

/* The texel's number along one side; `at` counts texels, side after side. */
static int wrapped(RTenum wrap, int at, int side)
{
    const int turn = (int)floor((double)at / side);
    if (wrap == RT_REPEAT)
        return at - turn * side;
    if (wrap == RT_MIRRORED_REPEAT)
        return turn % 2 == 0 ? at - turn * side : side - 1 - (at - turn * side);
    return at < 0 ? 0 : at >= side ? side - 1 : at;
}

/* The square shows texture coordinates -1 to 2. */
static void texture_against_formula(RTenum wrap_s, RTenum wrap_t, RTenum filter)
{
    int i, k, corner;
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_S, (RTint)wrap_s);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_T, (RTint)wrap_t);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER, (RTint)filter);
    rtRender();
    for (i = 0; i < WIDTH * HEIGHT; i++) {
        const double shift = filter == RT_LINEAR ? 0.5 : 0;
        const double s = (x_of(i) * 1.5 + 0.5) * 3 - shift, t = (y_of(i) * 1.5 + 0.5) * 2 - shift;
        const double part_s = filter == RT_LINEAR ? s - floor(s) : 0, part_t = filter == RT_LINEAR ? t - floor(t) : 0;
        double color[3] = { 0, 0, 0 };
        for (corner = 0; corner < 4; corner++) {
            const int u = corner % 2, v = corner / 2;
            const RTubyte *texel =
                texels[wrapped(wrap_t, (int)floor(t) + v, 2)][wrapped(wrap_s, (int)floor(s) + u, 3)];
            for (k = 0; k < 3; k++)
                color[k] += (u ? part_s : 1 - part_s) * (v ? part_t : 1 - part_t) * texel[k] / 255;
        }
        SHOWS(x_of(i), y_of(i), color[0], color[1], color[2]);
    }
}

static void textures(void)
{
    const RTenum wraps[4] = { RT_REPEAT, RT_CLAMP, RT_MIRRORED_REPEAT, RT_CLAMP_TO_EDGE };
    const RTuint texture = rtGenTextures(1);
    int k;
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, 3, 2, 0, RT_RGB, RT_UNSIGNED_BYTE, texels);
    shader_of("TextureShader");
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_QUADS);
    rtTexCoord2f(-1, -1); rtVertex2f(-1, -1);
    rtTexCoord2f(2, -1); rtVertex2f(1, -1);
    rtTexCoord2f(2, 2); rtVertex2f(1, 1);
    rtTexCoord2f(-1, 2); rtVertex2f(-1, 1);
    rtEnd();
    rtEndObject();
    for (k = 0; k < 4; k++) {
        texture_against_formula(wraps[k], wraps[(k + 1) % 4], RT_NEAREST);
        texture_against_formula(wraps[(k + 1) % 4], wraps[k], RT_LINEAR);
    }
    rtClearInstances();
}

/* Two mirrors face each other: the ray of depth d has been halved d times when the environment ends it. */
static void depth(void)
{
    unsigned greatest;
    rtUseEnvironmentShader(shader_of("ConstantEnvironmentShader"));
    set3("value", 0.25f, 0.5f, 1);
    shader_of("MirrorShader");
    rtParameter1f(rtParameterHandle("attenuation"), 0.5f);
    object_of_square();
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 20);
    rtEndObject();
    for (greatest = 0; greatest < 8; greatest++) {
        const double share = pow(0.5, greatest + 1);
        rtSetMaxRayRecursionDepth(greatest);
        rtRender();
        SHOWS(0, 0, 0.25 * share, 0.5 * share, share);
    }
    /* Far down too. */
    rtParameter1f(rtParameterHandle("attenuation"), 0.999f);
    rtSetMaxRayRecursionDepth(1000);
    rtRender();
    SHOWS(0, 0, 0.25 * pow(0.999f, 1001), 0.5 * pow(0.999f, 1001), pow(0.999f, 1001));
    rtSetMaxRayRecursionDepth(16);
    rtClearInstances();
}

/* The normal (1, 0, 1) under a scaling of z by 3 becomes (1, 0, 1/3), baked or by the instance, mirrored in y or not. */
static void normals(void)
{
    const double wanted = 1.0 / 3 / sqrt(1 + 1.0 / 9);
    int mode;
    rtUseLight(shader_of("InfiniteLightShader"));
    set3("direction", 0, 0, 5);
    shader_of("DiffuseShader");
    for (mode = 0; mode < 4; mode++) {
        RTuint object;
        if (mode < 2)
            rtScalef(1, mode ? -1 : 1, 3);
        object = rtCreateObject(RT_DEFINE);
        rtNormal3f(5, 0, 5);
        rectangle(-1, -1, 1, 1, 0);
        rtLoadIdentity();
        if (mode >= 2)
            rtScalef(1, mode == 3 ? -1 : 1, 3);
        rtInstantiateObject(object);
        rtLoadIdentity();
        rtRender();
        SHOWS(0, 0, wanted, wanted, wanted);
        rtClearInstances();
    }
}

int main(void)
{
    helpers_are_used();
    use_frame();
    look_at_square();
    point_light();
    pinhole();
    looking();
    textures();
    depth();
    normals();
    FINISH();
}
