/* SPDX-License-Identifier: GPL-3.0-or-later
 * Calls of the window at wrong times and with wrong values, and pixels of the program's own. Run with RTUT_HEADLESS=1. */
#include <openrt/rt.h>
#include <openrt/rtut.h>
#include <stdio.h>
#include <string.h>

static int failures, displays, width, height;

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);                                                     \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)

static void display(void)
{
    const RTubyte pixels[] = { 255, 0, 0, 0, 0, 255 };
    displays++;
    rtutShowPixels(NULL, 2, 1, RT_RGB_8);
    rtutShowPixels(pixels, 0, 1, RT_RGB_8);
    rtutShowPixels(pixels, 2, 1, 7);
    rtutShowPixels(pixels, 2, 1, RT_RGB_8);
    rtutLeaveMainLoop();
}

static void reshape(RTint w, RTint h)
{
    width = w, height = h;
}

int main(void)
{
    rtutSwapBuffers();
    CHECK(rtGetError() == RT_NO_ERROR);
    rtutLeaveMainLoop();
    rtutPostRedisplay();
    CHECK(!rtutMainLoop());
    CHECK(strstr(rtutErrorString(), "rtutInitWindow") != NULL);
    rtutInitWindow(0, 5, "no window");
    rtutInitWindow(5, -1, NULL);
    rtutInitWindow(20000, 5, NULL);
    CHECK(!rtutMainLoop());
    rtutInitWindow(64, 32, NULL);
    CHECK(rtutWindowWidth() == 64 && rtutWindowHeight() == 32);
    /* Nobody draws, nothing changes: it ends. */
    CHECK(rtutMainLoop() && rtutErrorString()[0] == 0);
    rtutDisplayFunc(display);
    rtutReshapeFunc(reshape);
    CHECK(rtutMainLoop());
    CHECK(displays == 1 && width == 64 && height == 32);
    rtutDisplayFunc(NULL);
    CHECK(rtutMainLoop() && displays == 1);
    rtExit();
    return failures;
}
