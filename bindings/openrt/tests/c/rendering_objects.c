/* SPDX-License-Identifier: GPL-3.0-or-later
 * Rendering objects: which there are, their parameters, and that they change the picture. */
#include "check.h"

static void quad(void)
{
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-0.51f, -0.51f, 0.5f, 0.5f, 0);
    rtEndObject();
}

int main(void)
{
    static const char *const others[] = { "PathTracer", "InstantRadiosity", "BidirectionalInstantRadiosity",
                                          "MetropolisInstantRadiosity" };
    const RTenum IV = RT_INVALID_VALUE, IO = RT_INVALID_OPERATION, OK = RT_NO_ERROR;
    RTuint whitted, eyelight, surface, light;
    RTfloat value = 0;
    int i;

    use_frame();
    look_at_square();
    rtGenNewShaderClass("DiffuseShader", NULL);
    surface = rtGenNewShader();
    quad();
    rtGenNewShaderClass("InfiniteLightShader", NULL);
    light = rtGenNewShader();
    rtUseLight(light);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 1, 1, 1);

    EXPECT_ID(rtGenNewShaderClass("Whitted", NULL), OK);
    EXPECT_ID(whitted = rtGenNewShader(), OK);
    EXPECT_ID(rtGenNewShaderClass("Eyelight", NULL), OK);
    EXPECT_ID(eyelight = rtGenNewShader(), OK);
    rtGetParameterfv(rtParameterHandle("samplesPerPixel"), &value);
    CHECK(value == 0);
    EXPECT(rtParameter1f(rtParameterHandle("samplesPerPixel"), 4), IO);
    EXPECT(rtParameter1i(rtParameterHandle("samplesPerPixel"), 16), OK);
    EXPECT(rtParameter1i(rtParameterHandle("maxDepth"), 3), OK);
    EXPECT(rtParameter1i(rtParameterHandle("vplCount"), 10), OK);
    EXPECT(rtParameter1f(rtParameterHandle("clamp"), 1.5f), OK);
    EXPECT(rtParameter1i(rtParameterHandle("clamp"), 1), IO);
    EXPECT(rtParameter1i(rtParameterHandle("seed"), 7), OK);
    EXPECT_ID(rtParameterHandle("samples"), IV);

    EXPECT(rtUseRenderingObject(12345), IV);
    EXPECT(rtUseRenderingObject(surface), IO);
    EXPECT(rtUseLight(eyelight), IO);
    EXPECT(rtUseCamera(eyelight), IO);

    /* Base colours by eyelight: mid-grey where a shader does not tell; edges are smooth with 16 samples. */
    EXPECT(rtUseRenderingObject(eyelight), OK);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.5, 0.5, 0.5);
    CHECK(frame[3][8][0] > 0.0f && frame[3][8][0] < 0.25f);
    EXPECT(rtUseRenderingObject(whitted), OK);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 1, 1, 1);
    CHECK(frame[3][8][0] == 0.0f);

    /* It stays in immediate mode, and after it was deleted. */
    EXPECT(rtUseRenderingObject(eyelight), OK);
    rtDeleteShader(eyelight);
    EXPECT(rtUseRenderingObject(eyelight), IV);
    rtSceneMode(RT_IMMEDIATE);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.5, 0.5, 0.5);
    rtBindShader(surface);
    quad();
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.5, 0.5, 0.5);

    /* What the renderer has besides draws; what it has not is missing, with the names that there are. */
    rtSceneMode(RT_RETAINED);
    rtBindShader(surface);
    quad();
    rtUseLight(light);
    for (i = 0; i < 4; i++) {
        if (rtGenNewShaderClass(others[i], NULL) == RT_INVALID) {
            CHECK(rtGetError() == RT_INVALID_VALUE);
            CHECK(strstr(rtGetShaderClassInfoLog(), "Whitted") != NULL);
            continue;
        }
        rtUseRenderingObject(rtGenNewShader());
        rtParameter1i(rtParameterHandle("samplesPerPixel"), 4);
        rtParameter1i(rtParameterHandle("maxDepth"), 4);
        EXPECT(rtRender(), OK);
        CHECK(covered() > 60);
        CHECK(at(0, 0)[0] >= 0 && at(0, 0)[0] < 10);
    }
    FINISH();
}
