/* SPDX-License-Identifier: GPL-3.0-or-later
 * Pictures that are too large: an error before memory is taken, and the program goes on. The process may take 4 GiB. */
#define _XOPEN_SOURCE 600
#include "check.h"
#include <sys/resource.h>

int main(void)
{
    struct rlimit limit;
    limit.rlim_cur = limit.rlim_max = (rlim_t)4 << 30;
    helpers_are_used();
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
    /* More than 2^31 pixels, whatever the product is in 32 bits. */
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 65536, 32769, RT_RGB_8), RT_INVALID_VALUE);
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 65536, 65536, RT_RGB_8), RT_INVALID_VALUE);
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 0xFFFFFFFFu, 0xFFFFFFFFu, RT_RGBA_32), RT_INVALID_VALUE);
    EXPECT(rtStartRendering(), RT_INVALID_OPERATION);
    /* As many as may be: the frame has no room, and writes nothing. */
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 65536, 32768, RT_RGB_8), RT_NO_ERROR);
    EXPECT(rtStartRendering(), RT_OUT_OF_MEMORY);
    EXPECT(rtEndRendering(), RT_INVALID_OPERATION);
    EXPECT(rtRender(), RT_OUT_OF_MEMORY);
    EXPECT(rtSwapBuffers(), RT_OUT_OF_MEMORY);
    use_frame();
    look_at_square();
    constant_shader(0.25f, 0.5f, 0.75f);
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(0, 0, 0.25, 0.5, 0.75);
    FINISH();
}
