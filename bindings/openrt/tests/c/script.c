/* SPDX-License-Identifier: GPL-3.0-or-later
 * Shader classes in the shading language: parameters of all types and rates, a light, a light loop, and what is told of mistakes.
 * Arguments: glow.osl, lamp.osl, lit.osl, bad.osl, twice.osl. */
#include "check.h"

int main(int count, char **files)
{
    RTuint lamp;
    CHECK(count == 6);
    if (count != 6)
        return 1;
    helpers_are_used();
    use_frame();
    look_at_square();

    EXPECT_ID(rtGenNewShaderClass("glow", files[1]), RT_NO_ERROR);
    EXPECT_ID(rtGenNewShader(), RT_NO_ERROR);
    EXPECT(rtParameter3f(rtParameterHandle("tint"), 0.25f, 0.5f, 1), RT_NO_ERROR);
    EXPECT(rtParameter1i(rtParameterHandle("steps"), 2), RT_NO_ERROR);
    EXPECT(rtParameterString(rtParameterHandle("word"), "b"), RT_NO_ERROR);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 0, 1, 0);
    EXPECT(rtParameter1f(rtParameterHandle("heat"), 3), RT_NO_ERROR);
    rectangle(0, -1, 1, 1, 0);
    rtEndObject();
    rtRender();
    SHOWS(-0.5, 0, 1.5, 2, 3);
    SHOWS(0.5, 0, 4.5, 5, 6);
    rtClearInstances();

    EXPECT_ID(rtGenNewShaderClass("lamp", files[2]), RT_NO_ERROR);
    EXPECT_ID(lamp = rtGenNewShader(), RT_NO_ERROR);
    EXPECT(rtParameter3f(rtParameterHandle("power"), 1, 2, 3), RT_NO_ERROR);
    EXPECT(rtUseLight(lamp), RT_NO_ERROR);
    EXPECT_ID(rtGenNewShaderClass("lit", files[3]), RT_NO_ERROR);
    EXPECT_ID(rtGenNewShader(), RT_NO_ERROR);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    rtRender();
    SHOWS(0.5, 0, 1, 2, 3);

    /* What pixels show is a rendering object beside the one that says how light is computed. */
    EXPECT_ID(rtGenNewShaderClass("twice", files[5]), RT_NO_ERROR);
    EXPECT_ID(lamp = rtGenNewShader(), RT_NO_ERROR);
    EXPECT(rtParameter1f(rtParameterHandle("gain"), 2), RT_NO_ERROR);
    EXPECT(rtUseCamera(lamp), RT_INVALID_OPERATION);
    EXPECT(rtUseRenderingObject(lamp), RT_NO_ERROR);
    rtRender();
    SHOWS(0.5, 0, 2, 4, 6);

    EXPECT_ID(rtGenNewShaderClass("bad", files[4]), RT_INVALID_OPERATION);
    CHECK(strstr(rtGetShaderClassInfoLog(), "diffus (N)") != NULL);
    EXPECT_ID(rtGenNewShaderClass("other", files[1]), RT_INVALID_VALUE);
    CHECK(strstr(rtGetShaderClassInfoLog(), "it holds \"glow\"") != NULL);
    FINISH();
}
