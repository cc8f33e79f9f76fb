// SPDX-License-Identifier: GPL-3.0-or-later
// Exceptions of C++: those of the program's own debug callback come to the program's own handler, whatever call they were
// thrown through; those of plugins end in the library and become errors. Needs throwing.so and throwing_module.so beside it.
#include "check.h"
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>

static int thrown = 0;

static void listen(RTenum, const char *call, void *)
{
    std::string heard = call;
    thrown++;
    throw std::runtime_error(heard);
}

// The call fails, and what the callback throws then arrives here.
#define THROWS(call, name) \
    do { \
        bool seen_ = false; \
        int before_ = thrown; \
        try { \
            (void)(call); \
        } catch (const std::runtime_error &error) { \
            seen_ = strncmp(error.what(), name, strlen(name)) == 0; \
        } \
        CHECK(seen_); \
        CHECK(thrown == before_ + 1); \
        CHECK(!std::uncaught_exception()); \
    } while (0)

static void through_calls()
{
    const float *none = NULL;
    rtDebugCallback(listen, NULL);
    THROWS(rtBegin(0x17), "rtBegin(0x17)");
    THROWS(rtVertex3f(1, 2, 3), "rtVertex3f");
    THROWS(rtVertex3fv(none), "rtVertex3fv");
    THROWS(rtColor3fv(none), "rtColor3fv");
    THROWS(rtEnd(), "rtEnd");
    THROWS(rtInit(NULL, NULL), "rtInit");
    THROWS(rtGetString(7), "rtGetString");
    THROWS(rtGetIntegerv(7, NULL), "rtGetIntegerv");
    THROWS(rtMatrixMode(7), "rtMatrixMode");
    THROWS(rtLoadMatrixf(NULL), "rtLoadMatrixf");
    THROWS(rtCreateObject(7), "rtCreateObject");
    THROWS(rtInstantiateObject(7), "rtInstantiateObject");
    THROWS(rtGetInstanceMatrixf(7, NULL), "rtGetInstanceMatrixf");
    THROWS(rtGenNewShaderClass("no such class", NULL), "rtGenNewShaderClass");
    THROWS(rtGenNewShader(), "rtGenNewShader");
    THROWS(rtParameter1f(7, 1), "rtParameter1f");
    THROWS(rtParameter3fv(7, NULL), "rtParameter3fv");
    THROWS(rtParameterRaw(7, NULL, 4), "rtParameterRaw");
    THROWS(rtParameterString(7, NULL), "rtParameterString");
    THROWS(rtTexImage2D(7, 0, 3, 1, 1, 0, RT_RGB, RT_FLOAT, NULL), "rtTexImage2D");
    THROWS(rtSetFrameBuffer(NULL, 1, 1, RT_RGB_8), "rtSetFrameBuffer");
    THROWS(rtStartRendering(), "rtStartRendering");
    THROWS(rtEndRendering(), "rtEndRendering");
    THROWS(rtRender(), "rtRender");
    THROWS(rtSwapBuffers(), "rtSwapBuffers");
    THROWS(rtUseLight(7), "rtUseLight");
    THROWS(rtLookAt(0, 0, 0, 0, 0, 0, 0, 0, 0), "rtLookAt");
    rtBegin(RT_TRIANGLES);
    THROWS(rtExit(), "rtExit");
    THROWS(rtGetError(), "rtGetError");
    THROWS(rtIsObject(1), "rtIsObject");
    THROWS(rtDebugCallback(NULL, NULL), "rtDebugCallback");
    rtEnd();
    // On another thread, which catches for itself; then the lock is free for all.
    std::thread([] { THROWS(rtBegin(0x18), "rtBegin(0x18)"); }).join();
    CHECK(rtGetError() == RT_INVALID_ENUM);
    // Waits for no call that is still under way: they have all ended.
    rtDebugCallback(NULL, NULL);
    EXPECT(rtBegin(0x17), RT_INVALID_ENUM);
}

static RTuint throws;

static RTuint shader(const char *name)
{
    RTuint made;
    CHECK(rtGenNewShaderClass(name, "./throwing.so") != RT_INVALID);
    made = rtGenNewShader();
    throws = rtParameterHandle("throws");
    return made;
}

// A frame with this error, and an info log with this part.
static void frame_gives(RTenum start, RTenum end, const char *part)
{
    EXPECT(rtStartRendering(), start);
    EXPECT(rtEndRendering(), end);
    if (strstr(rtGetShaderClassInfoLog(), part) == NULL) {
        printf("no \"%s\" in: %s\n", part, rtGetShaderClassInfoLog());
        failures++;
    }
    CHECK(!std::uncaught_exception());
}

static void of_plugins()
{
    const RTenum IO = RT_INVALID_OPERATION, OK = RT_NO_ERROR;
    use_frame();
    look_at_square();
    EXPECT_ID(rtGenNewShaderClass("surface", "./throwing_module.so"), IO);
    CHECK(strstr(rtGetShaderClassInfoLog(), "an exception left its rts_module") != NULL);
    CHECK(rtGenNewShaderClass("init", "./throwing.so") != RT_INVALID);
    EXPECT_ID(rtGenNewShader(), IO);
    CHECK(strstr(rtGetShaderClassInfoLog(), "an exception left its init") != NULL);
    CHECK(!std::uncaught_exception());
    RTuint fini = shader("fini");
    EXPECT(rtDeleteShader(fini), OK);

    RTuint surface = shader("surface");
    RTuint object = rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 0);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, -1);
    rtEndObject();
    frame_gives(OK, OK, "");
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    rtParameter1i(throws, 1);
    frame_gives(OK, IO, "left its callbacks");
    CHECK(covered() == 64);
    SHOWS(0, 0, 0, 0, 0);
    rtParameter1i(throws, 3);
    frame_gives(OK, IO, "left its callbacks");
    SHOWS(0, 0, 0.75, 0.75, 0.75);
    rtParameter1i(throws, 2);
    frame_gives(IO, OK, "an exception left its prepare");
    SHOWS(0, 0, 0.5, 0.5, 0.5);
    rtParameter1i(throws, 0);
    frame_gives(OK, OK, "");
    SHOWS(0, 0, 0.25, 0.25, 0.25);

    RTuint environment = shader("environment");
    rtUseEnvironmentShader(environment);
    frame_gives(OK, OK, "");
    SHOWS(-0.9, 0, 0.5, 0.5, 0.5);
    rtParameter1i(throws, 1);
    frame_gives(OK, IO, "left its callbacks");
    SHOWS(-0.9, 0, 0, 0, 0);
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    rtParameter1i(throws, 0);

    // A light on a built-in surface, through a pane of the plugin's.
    rtGenNewShaderClass("DiffuseShader", NULL);
    rtGenNewShader();
    rtNewObject(object, RT_DEFINE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 1);
    rtEndObject();
    RTuint light = shader("light");
    rtUseLight(light);
    frame_gives(OK, OK, "");
    SHOWS(0, 0, 1, 1, 1);
    rtParameter1i(throws, 1);
    frame_gives(OK, IO, "left its callbacks");
    SHOWS(0, 0, 0, 0, 0);
    rtParameter1i(throws, 0);
    // A surface that asks for shadows, and a pane of the plugin's between it and the light.
    rtGenNewShaderClass("MatteShader", NULL);
    rtGenNewShader();
    rtNewObject(object, RT_DEFINE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 2);
    rtEndObject();
    shader("glass");
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 20);
    rtEndObject();
    frame_gives(OK, OK, "");
    CHECK(at(0, 0)[0] > 0.1f);
    rtParameter1i(throws, 4);
    frame_gives(OK, IO, "left its callbacks");
    SHOWS(0, 0, 0, 0, 0);
    rtParameter1i(throws, 0);

    RTuint lens = shader("camera");
    rtUseCamera(lens);
    frame_gives(OK, OK, "");
    CHECK(covered() == 64);
    rtParameter1i(throws, 1);
    frame_gives(OK, IO, "left its callbacks");
    CHECK(covered() == 0);
    rtParameter1i(throws, 0);
    frame_gives(OK, OK, "");
    CHECK(surface != RT_INVALID);
}

int main()
{
    helpers_are_used();
    through_calls();
    of_plugins();
    rtExit();
    CHECK(!std::uncaught_exception());
    FINISH();
}
