/* SPDX-License-Identifier: GPL-3.0-or-later
 * Plugins that do wrong in a frame: the frame goes on, an error and the info log tell. Needs tricky.so beside it. */
#include "check.h"

static RTuint mode, prepare;

static RTuint bad(const char *kind)
{
    RTuint shader;
    CHECK(rtGenNewShaderClass(kind, "./tricky.so") != RT_INVALID);
    shader = rtGenNewShader();
    mode = rtParameterHandle("mode");
    prepare = rtParameterHandle("prepare");
    return shader;
}

/* A frame with this error, and an info log with this part; both halves of rtRender say it by themselves. */
static void frame_gives(RTenum start, RTenum end, const char *part)
{
    EXPECT(rtStartRendering(), start);
    EXPECT(rtEndRendering(), end);
    if (strstr(rtGetShaderClassInfoLog(), part) == NULL) {
        printf("no \"%s\" in: %s\n", part, rtGetShaderClassInfoLog());
        failures++;
    }
    EXPECT(rtRender(), start != RT_NO_ERROR ? start : end);
}

/* Every prepare that goes wrong, then a good one again. */
static void prepares(void)
{
    rtParameter1i(prepare, 1);
    frame_gives(RT_INVALID_OPERATION, RT_NO_ERROR, "prepare failed with -7 (no luck today)");
    rtParameter1i(prepare, 2);
    frame_gives(RT_INVALID_OPERATION, RT_NO_ERROR, "SIGSEGV");
    rtParameter1i(prepare, 3);
    frame_gives(RT_INVALID_OPERATION, RT_NO_ERROR, "SIGABRT");
    rtParameter1i(prepare, 4);
    frame_gives(RT_INVALID_OPERATION, RT_NO_ERROR, "left the process");
}

int main(void)
{
    const RTenum IO = RT_INVALID_OPERATION, OK = RT_NO_ERROR;
    RTuint surface, light, camera, environment, diffuse;
    RTfloat number = 0;

    use_frame();
    look_at_square();
    surface = bad("bad surface");
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 0);
    rtEndObject();

    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    rtParameter1i(mode, 1);
    frame_gives(OK, IO, "32 results not written, NaN or infinite");
    CHECK(covered() == 64);
    rtParameter1i(mode, 2);
    frame_gives(OK, IO, "64 results");
    SHOWS(0, 0, 0, 0, 0);
    rtParameter1i(mode, 3);
    frame_gives(OK, IO, "bad surface");
    SHOWS(0, 0, 0, 0, 0);
    rtParameter1i(mode, 0);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    /* The frame's copy is changed, the block is not. */
    rtParameter1i(prepare, 5);
    frame_gives(OK, IO, "32 results");
    rtGetParameterfv(mode, &number);
    CHECK(number == 0);
    prepares();
    SHOWS(0, 0, 0.5, 0.5, 0.5);
    rtParameter1i(prepare, 0);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.25, 0.25, 0.25);

    /* An environment: black, or the default, which is black too. */
    environment = bad("bad environment");
    rtUseEnvironmentShader(environment);
    EXPECT(rtRender(), OK);
    SHOWS(-0.9, 0, 0.25, 0.25, 0.25);
    rtParameter1i(mode, 1);
    frame_gives(OK, IO, "bad environment");
    rtParameter1i(mode, 3);
    frame_gives(OK, IO, "192 results");
    SHOWS(-0.9, 0, 0, 0, 0);
    prepares();
    SHOWS(-0.9, 0, 0, 0, 0);
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    rtParameter1i(prepare, 0);
    rtParameter1i(mode, 0);

    /* A light: unlit, or left out. */
    rtGenNewShaderClass("DiffuseShader", NULL);
    diffuse = rtGenNewShader();
    rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 1);
    rtEndObject();
    light = bad("bad light");
    rtUseLight(light);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.25, 0.25, 0.25); /* its direction has length 7 */
    rtParameter1i(mode, 2);
    frame_gives(OK, IO, "64 results");
    SHOWS(0, 0, 0, 0, 0);
    rtParameter1i(mode, 3);
    frame_gives(OK, IO, "bad light");
    SHOWS(0, 0, 0, 0, 0);
    prepares();
    SHOWS(0, 0, 0, 0, 0);
    rtParameter1i(prepare, 0);
    rtParameter1i(mode, 0);

    /* A camera: rays that see nothing, or the default camera. */
    camera = bad("bad camera");
    rtUseCamera(camera);
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    CHECK(covered() == 64);
    rtParameter1i(mode, 1);
    frame_gives(OK, IO, "bad camera");
    CHECK(covered() == 0);
    rtParameter1i(mode, 2);
    frame_gives(OK, IO, "bad camera");
    rtParameter1i(mode, 3);
    frame_gives(OK, IO, "bad camera");
    prepares();
    CHECK(covered() == 64);

    /* Deleted and in use, then gone; frames go on. */
    rtDeleteShader(camera);
    rtDeleteShader(surface);
    rtDeleteShader(diffuse);
    EXPECT(rtRender(), IO);
    EXPECT(rtRender(), IO);
    rtExit();
    use_frame();
    EXPECT(rtRender(), OK);
    FINISH();
}
