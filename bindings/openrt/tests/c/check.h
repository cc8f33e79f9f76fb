/* SPDX-License-Identifier: GPL-3.0-or-later
 * Checks for the test programs: each failure is printed with its line, and the program's status is 1 at the end. */
#ifndef CHECK_H
#define CHECK_H

#include <math.h>
#include <openrt/rt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

/* The condition holds. */
#define CHECK(condition) \
    do { \
        if (!(condition)) { \
            printf("%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
            failures++; \
        } \
    } while (0)

/* The call leaves this error behind, and no other was left before it. */
#define EXPECT(call, error) \
    do { \
        RTenum before_ = rtGetError(), after_; \
        (void)(call); \
        after_ = rtGetError(); \
        if (before_ != RT_NO_ERROR) { \
            printf("%s:%d: error %#x was left before %s\n", __FILE__, __LINE__, before_, #call); \
            failures++; \
        } \
        if (after_ != (error)) { \
            printf("%s:%d: %s gives %#x, not %s\n", __FILE__, __LINE__, #call, after_, #error); \
            failures++; \
        } \
    } while (0)

/* The same for calls that return an id: on errors it is RT_INVALID. */
#define EXPECT_ID(call, error) \
    do { \
        RTuint id_ = 0; \
        EXPECT(id_ = (call), error); \
        if (((error) == RT_NO_ERROR) != (id_ != RT_INVALID && id_ != 0)) { \
            printf("%s:%d: %s returns %#x\n", __FILE__, __LINE__, #call, id_); \
            failures++; \
        } \
    } while (0)

#define NEAR(a, b, tolerance) \
    do { \
        double a_ = (a), b_ = (b); \
        if (!(fabs(a_ - b_) <= (tolerance))) { \
            printf("%s:%d: %s is %.9g, not %.9g\n", __FILE__, __LINE__, #a, a_, b_); \
            failures++; \
        } \
    } while (0)

/* The end of main. */
#define FINISH() \
    do { \
        CHECK(rtGetError() == RT_NO_ERROR); \
        if (failures > 0) \
            printf("%d checks failed\n", failures); \
        return failures > 0; \
    } while (0)

/* A frame buffer of floats, red, green, blue, alpha; row 0 is the lowest. */
#define WIDTH 16
#define HEIGHT 16
static float frame[HEIGHT][WIDTH][4];

static inline void use_frame(void)
{
    rtSetFrameBuffer((RTubyte *)frame, WIDTH, HEIGHT, RT_RGBA_32);
}

/* A camera at (0, 0, 10) that sees the square [-1, 1] x [-1, 1], without perspective. */
static inline void look_at_square(void)
{
    rtMatrixMode(RT_PROJECTION);
    rtLoadIdentity();
    rtOrtho(-1, 1, -1, 1, 0, 100);
    rtMatrixMode(RT_MODELVIEW);
    rtLookAt(0, 0, 10, 0, 0, 0, 0, 1, 0);
}

/* The pixel that shows (x, y) of that square. */
static inline const float *at(double x, double y)
{
    int column = (int)((x + 1) / 2 * WIDTH), row = (int)((y + 1) / 2 * HEIGHT);
    return frame[row][column];
}

/* The pixel at (x, y) shows this colour. */
#define SHOWS(x, y, r, g, b) \
    do { \
        const float *p_ = at(x, y); \
        if (!(fabs(p_[0] - (r)) < 1e-4 && fabs(p_[1] - (g)) < 1e-4 && fabs(p_[2] - (b)) < 1e-4)) { \
            printf("%s:%d: (%g, %g) shows %g %g %g, not %g %g %g\n", __FILE__, __LINE__, (double)(x), (double)(y), \
                   p_[0], p_[1], p_[2], (double)(r), (double)(g), (double)(b)); \
            failures++; \
        } \
    } while (0)

/* How many pixels show a surface. */
static inline int covered(void)
{
    int count = 0, row, column;
    for (row = 0; row < HEIGHT; row++)
        for (column = 0; column < WIDTH; column++)
            count += frame[row][column][3] > 0.5f;
    return count;
}

/* A new, bound ConstantShader. */
static inline RTuint constant_shader(float r, float g, float b)
{
    RTuint shader;
    rtGenNewShaderClass("ConstantShader", NULL);
    shader = rtGenNewShader();
    rtParameter3f(rtParameterHandle("value"), r, g, b);
    return shader;
}

/* A rectangle at depth z, counter-clockwise seen from above. */
static inline void rectangle(float x0, float y0, float x1, float y1, float z)
{
    rtBegin(RT_QUADS);
    rtVertex3f(x0, y0, z);
    rtVertex3f(x1, y0, z);
    rtVertex3f(x1, y1, z);
    rtVertex3f(x0, y1, z);
    rtEnd();
}

static inline RTint integer(RTenum name)
{
    RTint value = -1;
    rtGetIntegerv(name, &value);
    return value;
}

/* Every helper counts as used. */
static inline void helpers_are_used(void)
{
    (void)use_frame, (void)look_at_square, (void)covered, (void)constant_shader, (void)rectangle, (void)integer;
    (void)at;
}

#endif
