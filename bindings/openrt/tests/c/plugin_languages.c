/* SPDX-License-Identifier: GPL-3.0-or-later
 * The example plugins beside built-in classes that do the same. Needs diffuse.so, studio.so, chrome.so and stripes.so. */
#include "check.h"

static float kept[HEIGHT][WIDTH][4];

static RTuint shader_of(const char *name, const char *file)
{
    if (rtGenNewShaderClass(name, file) == RT_INVALID) {
        printf("%s\n", rtGetShaderClassInfoLog());
        failures++;
        return RT_INVALID;
    }
    return rtGenNewShader();
}

static void set3(const char *name, float x, float y, float z)
{
    rtParameter3f(rtParameterHandle(name), x, y, z);
}

/* A floor with a wall that throws a shadow and is mirrored, all of the bound shader; seen from above. */
static RTuint stage(void)
{
    RTuint object = rtNewObject(RT_COMPILE);
    rectangle(-1, -1, 1, 1, 0);
    rtNormal3f(0.6f, 0, 0.8f);
    rectangle(-0.5f, -0.3f, 0.1f, 0.4f, 0.5f);
    rtEndObject();
    return object;
}

/* Largest difference between this frame and the one that was kept. */
static float difference(void)
{
    const float *a = &frame[0][0][0], *b = &kept[0][0][0];
    float largest = 0;
    int i;
    for (i = 0; i < HEIGHT * WIDTH * 4; i++)
        largest = fabsf(a[i] - b[i]) > largest ? fabsf(a[i] - b[i]) : largest;
    return largest;
}

static void show(RTuint object)
{
    rtClearInstances();
    rtInstantiateObject(object);
    rtRender();
}

int main(void)
{
    static const RTfloat texels[4][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 } };
    RTuint built_in, plugin, light, spot, camera, sky, texture, red;

    use_frame();
    look_at_square();
    light = shader_of("InfiniteLightShader", NULL);
    set3("direction", 0.3f, 0.2f, 0.8f);
    spot = shader_of("SpotLightShader", NULL);
    set3("position", 0.4f, -0.2f, 1.5f);
    set3("radiance", 1, 0.5f, 0.25f);
    rtUseLight(light);
    rtUseLight(spot);

    /* C: without shadows, bit for bit. */
    shader_of("DiffuseShader", NULL);
    set3("color", 0.75f, 0.5f, 0.25f);
    built_in = stage();
    shader_of("diffuse", "diffuse.so");
    set3("color", 0.75f, 0.5f, 0.25f);
    plugin = stage();
    show(built_in);
    memcpy(kept, frame, sizeof frame);
    CHECK(at(0.8, 0.8)[0] > 0.1f);
    show(plugin);
    CHECK(difference() == 0);

    /* C: with shadows and a texture. */
    texture = rtGenTextures(1);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, 2, 2, 0, RT_RGB, RT_FLOAT, texels);
    rtTexCoord2f(0.25f, 0.25f);
    shader_of("TexturedDiffuseShader", NULL);
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    set3("radiance", 0, 0, 0);
    built_in = stage();
    shader_of("diffuse", "diffuse.so");
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    rtParameter1i(rtParameterHandle("shadows"), 1);
    plugin = stage();
    show(built_in);
    memcpy(kept, frame, sizeof frame);
    CHECK(at(-0.9, 0)[0] > 0.1f && at(-0.9, 0)[1] == 0);
    show(plugin);
    CHECK(difference() == 0);
    rtParameter1i(rtParameterHandle("shadows"), 0);
    show(plugin);
    CHECK(difference() > 0.1f);

    /* C++: a mirror, above a red floor. */
    rtTexCoord2f(0, 0);
    shader_of("ConstantShader", NULL);
    set3("value", 1, 0.25f, 0);
    red = rtNewObject(RT_COMPILE);
    rectangle(-9, -9, 9, 9, 20);
    rtEndObject();
    shader_of("MirrorShader", NULL);
    rtParameter1f(rtParameterHandle("attenuation"), 0.5f);
    built_in = stage();
    shader_of("chrome", "chrome.so");
    set3("tint", 0.5f, 0.5f, 0.5f);
    rtParameter1f(rtParameterHandle("fresnel"), 0);
    plugin = stage();
    rtClearInstances();
    rtInstantiateObject(red);
    rtInstantiateObject(built_in);
    rtRender();
    memcpy(kept, frame, sizeof frame);
    SHOWS(0.8, 0.8, 0.5, 0.125, 0);
    rtClearInstances();
    rtInstantiateObject(red);
    rtInstantiateObject(plugin);
    rtRender();
    CHECK(difference() < 1e-5f);
    /* Two mirrors and the limit of the depth: no recursion without end. */
    rtSetMaxRayRecursionDepth(3);
    rtPushMatrix();
    rtTranslatef(0, 0, 15);
    rtInstantiateObject(plugin);
    rtPopMatrix();
    rtRender();
    rtSetMaxRayRecursionDepth(16);

    /* C: a light. On its axis it is a SpotLightShader, outside of its angle it is dark. */
    shader_of("DiffuseShader", NULL);
    built_in = rtNewObject(RT_COMPILE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    rtRemoveLight(light);
    rtRemoveLight(spot);
    rtUseLight(shader_of("cone", "studio.so"));
    set3("position", 0.0625f, 0.0625f, 2);
    set3("target", 0.0625f, 0.0625f, 0);
    set3("radiance", 4, 8, 0);
    rtParameter1f(rtParameterHandle("angle"), 20);
    show(built_in);
    SHOWS(0.0625, 0.0625, 1, 2, 0);
    SHOWS(0.9, 0.9, 0, 0, 0);
    CHECK(at(0.5, 0)[1] > 0.01f && at(0.5, 0)[1] < at(0.0625, 0.0625)[1]);

    /* C: an environment, seen by a fisheye camera that looks along x from the middle of nothing. */
    sky = shader_of("sky", "studio.so");
    set3("zenith", 0, 0, 1);
    set3("horizon", 1, 1, 1);
    set3("ground", 0, 1, 0);
    rtUseEnvironmentShader(sky);
    camera = shader_of("fisheye", "studio.so");
    set3("eye", 0, 5, 0);
    set3("target", 1, 5, 0);
    rtUseCamera(camera);
    rtClearInstances();
    rtRender();
    CHECK(at(0, 0.97)[0] < 0.05f && at(0, 0.97)[2] > 0.99f);   /* nearly straight up */
    CHECK(at(0, -0.97)[0] < 0.05f && at(0, -0.97)[1] > 0.99f); /* nearly straight down */
    CHECK(at(0.9, 0.01)[0] > 0.6f);                            /* the horizon */
    /* The floor is below: the picture's lower half shows it once it is large. */
    rtLoadIdentity();
    rtRotatef(-90, 1, 0, 0);
    rtScalef(1000, 1000, 1);
    rtInstantiateObject(built_in);
    rtRender();
    CHECK(at(0, -0.5)[3] == 1 && at(0, 0.5)[3] == 0);
    rtLoadIdentity();

    /* Rust: stripes along s, of two colours. */
    rtExit();
    use_frame();
    look_at_square();
    shader_of("stripes", "stripes.so");
    set3("color", 1, 0, 0);
    rtParameter1f(rtParameterHandle("width"), 0.5f);
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rtParameter3f(rtParameterHandle("other_color"), 0, 1, 0);
    rtBegin(RT_QUADS);
    rtTexCoord2f(0, 0); rtVertex3f(-1, -1, 0);
    rtTexCoord2f(2, 0); rtVertex3f(1, -1, 0);
    rtTexCoord2f(2, 2); rtVertex3f(1, 1, 0);
    rtTexCoord2f(0, 2); rtVertex3f(-1, 1, 0);
    rtEnd();
    rtEndObject();
    rtRender();
    SHOWS(-0.75, 0, 1, 0, 0);
    SHOWS(-0.25, 0, 0, 1, 0);
    SHOWS(0.25, 0, 1, 0, 0);
    FINISH();
}
