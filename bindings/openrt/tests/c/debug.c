/* SPDX-License-Identifier: GPL-3.0-or-later
 * The debug callback hears every error with the call that made it; rtGetError goes on as without. */
#include "check.h"

static char heard[2000];
static int count;

static void listen(RTenum error, const char *call, void *user)
{
    CHECK(user == &count);
    count++;
    sprintf(heard, "%s %#x", call, error);
    /* Calls are allowed here; their errors are not told. */
    rtGetString(7);
}

#define HEARD(call, text) \
    do { \
        count = 0; \
        (void)(call); \
        CHECK(count == 1); \
        if (strcmp(heard, text) != 0) { \
            printf("%s:%d: heard '%s', not '%s'\n", __FILE__, __LINE__, heard, text); \
            failures++; \
        } \
    } while (0)

int main(void)
{
    const float numbers[3] = { 1, 2.5f, -3 };
    helpers_are_used();
    rtDebugCallback(listen, &count);
    CHECK(rtGetError() == RT_NO_ERROR);
    HEARD(rtBegin(0x17), "rtBegin(0x17) 0xfffffe01");
    HEARD(rtVertex3fv(numbers), "rtVertex3fv({1, 2.5, -3}) 0xfffffe03");
    HEARD(rtVertex3fv(NULL), "rtVertex3fv(NULL) 0xfffffe02");
    HEARD(rtVertex2d(0.5, 1e10), "rtVertex2d(0.5, 10000000000) 0xfffffe03");
    HEARD(rtGenNewShaderClass("a \"b\"", NULL), "rtGenNewShaderClass(\"a \\\"b\\\"\", NULL) 0xfffffe02");
    HEARD(rtSetFrameBuffer(NULL, 3, 4, RT_RGB_8), "rtSetFrameBuffer(NULL, 3, 4, 0x310) 0xfffffe02");
    HEARD(rtBindShader(12), "rtBindShader(12) 0xfffffe03");
    HEARD(rtInit(NULL, NULL), "rtInit() 0xfffffe03");
    HEARD(rtEnd(), "rtEnd() 0xfffffe03");
    rtBegin(RT_TRIANGLES);
    HEARD(rtGetError(), "rtGetError() 0xfffffe03");
    HEARD(rtDebugCallback(NULL, NULL), "rtDebugCallback() 0xfffffe03");
    rtEnd();
    /* The first one is still there. */
    CHECK(rtGetError() == RT_INVALID_ENUM);
    rtDebugCallback(NULL, NULL);
    count = 0;
    rtEnd();
    CHECK(count == 0);
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    FINISH();
}
