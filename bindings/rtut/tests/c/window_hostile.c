/* SPDX-License-Identifier: GPL-3.0-or-later
 * Frames that cannot start or end while the window grows and shrinks, and a listener to errors that calls back.
 * Run with RTUT_HEADLESS=1, and once more built with -fsanitize=address. */
#include <openrt/rt.h>
#include <openrt/rtut.h>
#include <stdio.h>
#include <string.h>

static int failures, told, depth;

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);                                                     \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)

static RTubyte own[64 * 64 * 3];

/* Everything that a program may think of when it hears of an error. */
static void RTAPIENTRY listener(RTenum error, const char *call, void *user)
{
    (void)error, (void)user;
    told++;
    CHECK(call != NULL && depth == 0);
    depth++;
    rtutPostRedisplay();
    rtutLeaveMainLoop();
    rtutSwapBuffers();
    rtutInitWindow(8 + told % 5, 8, "told");
    rtutShowPixels(own, 64, 64, RT_RGB_8);
    rtutDisplayFunc(NULL);
    CHECK(rtutWindowWidth() == 8 + told % 5 && rtutWindowHeight() == 8);
    CHECK(rtutElapsedTime() >= 0);
    rtutSphere(4, 4);
    depth--;
}

static void sizes(int side)
{
    rtutInitWindow(side, side, NULL);
}


/* A frame in flight, an object open, and the window grows: neither end nor start can be. */
static void grows_while_open(void)
{
    int round;
    rtSetSamplesPerPixel(16);
    for (round = 0; round < 4; round++) {
        sizes(32);
        rtutSwapBuffers();
        CHECK(rtGetError() == RT_NO_ERROR);
        rtCreateObject(RT_DEFINE);
        rtutSwapBuffers();
        sizes(256 + round);
        rtutSwapBuffers();
        rtutSwapBuffers();
        CHECK(rtGetError() == RT_INVALID_OPERATION);
        rtEndObject();
        rtutSwapBuffers();
        sizes(16);
        rtutSwapBuffers();
        CHECK(rtGetError() == RT_NO_ERROR);
    }
}

/* Between rtBegin and rtEnd not even the frame buffer changes. */
static void grows_within_a_block(void)
{
    int round;
    for (round = 0; round < 4; round++) {
        sizes(48);
        rtutSwapBuffers();
        rtBegin(RT_TRIANGLES);
        rtutSwapBuffers();
        sizes(200 + round);
        rtutSwapBuffers();
        rtEnd();
        CHECK(rtGetError() == RT_INVALID_OPERATION);
        rtutSwapBuffers();
        sizes(24);
        rtutSwapBuffers();
    }
}

/* The program ends, begins and cancels frames itself, with the window's buffers and with its own. */
static void frames_of_its_own(void)
{
    int round;
    for (round = 0; round < 4; round++) {
        sizes(40 + round);
        rtutSwapBuffers();
        rtEndRendering();
        rtStartRendering();
        CHECK(rtGetError() == RT_NO_ERROR);
        sizes(90 + round);
        rtutSwapBuffers();
        rtEndRendering();
        rtSetFrameBuffer(own, 64, 64, RT_RGB_8);
        rtStartRendering();
        rtutSwapBuffers();
        CHECK(rtGetError() == RT_INVALID_OPERATION);
        rtCancelRendering();
        rtEndRendering();
        rtutSwapBuffers();
        rtExit();
        rtSetSamplesPerPixel(16);
        rtutSwapBuffers();
        CHECK(rtGetError() == RT_NO_ERROR);
    }
}

static void called_back(void)
{
    int round;
    rtDebugCallback(listener, NULL);
    for (round = 0; round < 4; round++) {
        rtutSwapBuffers();
        rtCreateObject(RT_DEFINE);
        rtutSwapBuffers();
        rtutSwapBuffers();
        rtEndObject();
        rtStartRendering();
        rtutSwapBuffers();
        rtStartRendering();
        rtutSwapBuffers();
        rtEndRendering();
    }
    CHECK(told > 4);
    rtDebugCallback(NULL, NULL);
    while (rtGetError() != RT_NO_ERROR)
        ;
}

static void display(void)
{
    sizes(20 + rtutWindowWidth() % 50);
    rtCreateObject(RT_DEFINE);
    rtutSwapBuffers();
    rtEndObject();
    rtutSwapBuffers();
    rtutPostRedisplay();
}

int main(void)
{
    grows_while_open();
    grows_within_a_block();
    frames_of_its_own();
    called_back();
    rtutInitWindow(32, 32, NULL);
    rtutDisplayFunc(display);
    rtDebugCallback(listener, NULL);
    CHECK(rtutMainLoop());
    rtDebugCallback(NULL, NULL);
    rtutDisplayFunc(display);
    CHECK(rtutMainLoop());
    rtExit();
    return failures;
}
