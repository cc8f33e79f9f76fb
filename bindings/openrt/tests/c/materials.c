/* SPDX-License-Identifier: GPL-3.0-or-later
 * The classes of materials by name: what each shows of a light at the eye, head-on, and that it takes its parameters. */
#include "check.h"

static RTuint instance;

static void surface(const char *name)
{
    RTuint object;
    if (instance != 0)
        rtDeleteInstance(instance);
    CHECK(rtGenNewShaderClass(name, NULL) != RT_INVALID);
    rtGenNewShader();
    object = rtCreateObject(RT_DEFINE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    instance = rtInstantiateObject(object);
}

#define SET(name, ...) rtParameter3f(rtParameterHandle(name), __VA_ARGS__)
#define SET1(name, x) rtParameter1f(rtParameterHandle(name), x)

int main(void)
{
    const float pi = 3.14159265f, texel[3] = { 0.5f, 0.25f, 1 };
    float back[3];
    RTuint texture, light;
    helpers_are_used();
    rtGenNewShaderClass("InfiniteLightShader", NULL);
    light = rtGenNewShader();
    rtUseLight(light);
    rtGenNewShaderClass("ConstantEnvironmentShader", NULL);
    rtUseEnvironmentShader(rtGenNewShader());
    SET("value", 0.5f, 0.25f, 0.125f);
    texture = rtGenTextures(1);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, 1, 1, 0, RT_RGB, RT_FLOAT, texel);
    look_at_square();
    use_frame();

    surface("MatteShader");
    SET("color", 1, 0.5f, 0.25f);
    rtRender();
    SHOWS(0, 0, 1 / pi, 0.5f / pi, 0.25f / pi);
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    rtRender();
    SHOWS(0, 0, 0.5f / pi, 0.125f / pi, 0.25f / pi);

    surface("EmissiveShader");
    SET("radiance", 3, 2, 1);
    rtRender();
    SHOWS(0, 0, 3, 2, 1);

    surface("GlassShader");
    SET1("ior", 1.5f);
    SET("transmittance", 0, 1, 0);
    rtRender();
    /* Head-on a twenty-fifth is mirrored; the rest goes through. */
    SHOWS(0, 0, 0.04f * 0.5f, 0.25f, 0.04f * 0.125f);

    surface("MetallicRoughnessShader");
    SET("baseColor", 1, 0.5f, 0);
    SET1("metallic", 1);
    SET1("roughness", 0);
    rtRender();
    /* A smooth metal mirrors its colour; the light has no extent that a ray could meet, only the highlight is left. */
    CHECK(at(0, 0)[0] >= 0.5f - 1e-4f && at(0, 0)[2] <= 1e-3f);

    surface("Phong");
    SET("diffuseColor", 0.5f, 0.25f, 0.125f);
    rtRender();
    SHOWS(0, 0, 0.6f, 0.3f, 0.15f);
    SET("specularColor", 0.25f, 0.25f, 0.25f);
    SET("emissiveColor", 0, 0, 1);
    SET1("reflective", 0.5f);
    SET1("ambientIntensity", 0);
    SET1("shininess", 1);
    rtRender();
    SHOWS(0, 0, 0.5f + 0.25f + 0.25f, 0.25f + 0.25f + 0.125f, 0.125f + 0.25f + 0.0625f + 1);
    rtParameter1i(rtParameterHandle("maxDepth"), 0);
    rtRender();
    SHOWS(0, 0, 0.5f + 0.25f, 0.25f + 0.25f, 0.125f + 0.25f + 1);
    rtParameter1i(rtParameterHandle("maxDepth"), -1);
    SET1("transparency", 0.5f);
    rtRender();
    SHOWS(0, 0, 0.5f + 0.25f, 0.3125f + 0.125f, 0.71875f + 0.0625f);
    rtParameter1i(rtParameterHandle("useVertexColor"), 1);
    rtGetParameterfv(rtParameterHandle("useVertexColor"), back);
    CHECK(back[0] == 1);
    EXPECT(SET1("maxDepth", 1), RT_INVALID_OPERATION);
    EXPECT(rtParameter1i(rtParameterHandle("transparency"), 1), RT_INVALID_OPERATION);
    FINISH();
}
