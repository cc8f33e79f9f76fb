/* SPDX-License-Identifier: GPL-3.0-or-later
 * With nobody at the other end of the standard error output, and the signal for that ignored, messages are lost and
 * nothing else. The caller sets both up, and OPENRT_DEBUG. Needs tricky.so beside it. */
#include "check.h"

int main(void)
{
    RTuint surface;
    EXPECT(rtBegin(0x17), RT_INVALID_ENUM);
    EXPECT_ID(rtGenNewShaderClass("no such class", NULL), RT_INVALID_VALUE);
    use_frame();
    look_at_square();
    CHECK(rtGenNewShaderClass("bad surface", "./tricky.so") != RT_INVALID);
    surface = rtGenNewShader();
    CHECK(surface != RT_INVALID);
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 0);
    rtEndObject();
    rtParameter1i(rtParameterHandle("mode"), 1);
    EXPECT(rtRender(), RT_INVALID_OPERATION);
    CHECK(strstr(rtGetShaderClassInfoLog(), "NaN or infinite") != NULL);
    rtParameter1i(rtParameterHandle("prepare"), 1); /* it also logs */
    EXPECT(rtRender(), RT_INVALID_OPERATION);
    CHECK(covered() == 64);
    rtExit();
    FINISH();
}
