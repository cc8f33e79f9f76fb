/* SPDX-License-Identifier: GPL-3.0-or-later
 * Two mirrors face each other, and a plugin's shader takes 64 KiB of the stack for each bounce: at 1,000 bounces that is
 * four times the stack. Needs deep.so beside it. */
#include "check.h"

int main(void)
{
    helpers_are_used();
    use_frame();
    look_at_square();
    CHECK(rtGenNewShaderClass("deep", "./deep.so") != RT_INVALID);
    rtGenNewShader();
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rectangle(-1, -1, 1, 1, 11); /* behind the camera */
    rtEndObject();
    rtSetMaxRayRecursionDepth(20);
    EXPECT(rtRender(), RT_NO_ERROR);
    CHECK(covered() == WIDTH * HEIGHT);
    rtSetMaxRayRecursionDepth(1000);
    EXPECT(rtRender(), RT_INVALID_OPERATION);
    CHECK(strstr(rtGetShaderClassInfoLog(), "too little of a thread's stack") != NULL);
    CHECK(strstr(rtGetShaderClassInfoLog(), "rtSetMaxRayRecursionDepth") != NULL);
    SHOWS(0, 0, 0, 0, 0);
    rtSetMaxRayRecursionDepth(20);
    EXPECT(rtRender(), RT_NO_ERROR);
    FINISH();
}
