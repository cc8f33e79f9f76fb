// SPDX-License-Identifier: GPL-3.0-or-later
// Exceptions leave each of the program's functions and arrive at its own handler. Run with RTUT_HEADLESS=1.
#include <openrt/rt.h>
#include <openrt/rtut.h>
#include <cstdio>
#include <cstring>
#include <stdexcept>

static int failures;

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            std::printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);                                                \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)

// Gone when the stack is unwound.
static int alive;
struct Counted {
    Counted() { alive++; }
    ~Counted() { alive--; }
};

extern "C" {
static void from_display() { Counted c; throw std::runtime_error("display"); }
static void from_idle() { Counted c; throw std::runtime_error("idle"); }
static void from_reshape(RTint, RTint) { Counted c; throw std::runtime_error("reshape"); }
static void quiet() { rtutPostRedisplay(); }
static void RTAPIENTRY from_listener(RTenum, const char *, void *) { Counted c; throw std::runtime_error("listener"); }
static void swaps() { rtutSwapBuffers(); rtutPostRedisplay(); }
}

template <class Function> static void throws(const char *text, Function function)
{
    bool caught = false;
    try {
        function();
    } catch (const std::runtime_error &error) {
        caught = std::strcmp(error.what(), text) == 0;
    }
    if (!caught)
        std::printf("nothing caught from %s\n", text);
    failures += !caught;
    CHECK(alive == 0);
}

int main()
{
    rtutInitWindow(32, 32, "thrown");
    for (int round = 0; round < 3; round++) {
        rtutDisplayFunc(from_display);
        throws("display", [] { rtutMainLoop(); });
        rtutDisplayFunc(swaps);
        rtutIdleFunc(from_idle);
        throws("idle", [] { rtutMainLoop(); });
        rtutIdleFunc(nullptr);
        rtutReshapeFunc(from_reshape);
        throws("reshape", [] { rtutMainLoop(); });
        rtutReshapeFunc(nullptr);
        // A frame is in flight and an object open: each call of a swap fails and is told.
        rtutDisplayFunc(quiet);
        rtutSwapBuffers();
        rtDebugCallback(from_listener, nullptr);
        rtCreateObject(RT_DEFINE);
        throws("listener", [] { rtutSwapBuffers(); });
        throws("listener", [] { rtutSwapBuffers(); });
        rtEndObject();
        throws("listener", [] { rtutSphere(8, 4); });
        // The shape was left in the middle: within a block no listener can be changed.
        try {
            rtEnd();
        } catch (const std::runtime_error &) {
        }
        rtDebugCallback(nullptr, nullptr);
        rtutSwapBuffers();
        while (rtGetError() != RT_NO_ERROR) {
        }
    }
    rtutDisplayFunc(swaps);
    CHECK(rtutMainLoop());
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
    return failures;
}
