/* SPDX-License-Identifier: GPL-3.0-or-later
 * A plugin's camera gets places on its lens: the middle where there is one sample, all of it where there are more. One of version
 * 1.0 gets none. Needs lens.so beside it. */
#include "check.h"

int main(void)
{
    RTuint with_lens, without;
    helpers_are_used();
    use_frame();
    CHECK(rtGenNewShaderClass("lens", "./lens.so") != RT_INVALID);
    with_lens = rtGenNewShader();
    CHECK(rtGenNewShaderClass("plain", "./lens.so") != RT_INVALID);
    without = rtGenNewShader();
    constant_shader(1, 1, 1);
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();

    rtUseCamera(with_lens);
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(0, 0, 1, 1, 1);
    rtSetSamplesPerPixel(16);
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    SHOWS(-0.9, 0.9, 0.25, 0.25, 0.25);
    rtUseCamera(without);
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(0, 0, 1, 1, 1);
    FINISH();
}
