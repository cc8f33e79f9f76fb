/* SPDX-License-Identifier: GPL-3.0-or-later
 * All forms of rtVertex*, rtNormal*, rtTexCoord* and rtColor*. */
#include "check.h"

static const RTshort s[4] = { 1, -2, 3, 2 };
static const RTint i[4] = { 1, -2, 3, 2 };
static const RTfloat f[4] = { 1, -2, 3, 2 };
static const RTdouble d[4] = { 1, -2, 3, 2 };

/* The current value after the call. */
#define IS(name, count, call, a, b, c, last) \
    do { \
        const RTfloat wanted_[4] = { (RTfloat)(a), (RTfloat)(b), (RTfloat)(c), (RTfloat)(last) }; \
        RTfloat now_[4]; \
        int k_; \
        call; \
        rtGetFloatv(name, now_); \
        for (k_ = 0; k_ < (count); k_++) \
            if (!(fabs(now_[k_] - wanted_[k_]) < 1e-6)) { \
                printf("%s:%d: %s: number %d is %g, not %g\n", __FILE__, __LINE__, #call, k_, now_[k_], wanted_[k_]); \
                failures++; \
            } \
    } while (0)
#define NORMAL(call, x, y, z) IS(RT_CURRENT_NORMAL, 3, call, x, y, z, 0)
#define TEXCOORD(call, a, b, c, last) IS(RT_CURRENT_TEXTURE_COORDS, 4, call, a, b, c, last)
#define COLOR(call, r, g, b, a) IS(RT_CURRENT_COLOR, 4, call, r, g, b, a)

static void normals(void)
{
    NORMAL((void)0, 0, 0, 1);
#define FORMS(t) \
    NORMAL(rtNormal2##t(4, 5), 4, 5, 0); NORMAL(rtNormal2##t##v(t), 1, -2, 0); \
    NORMAL(rtNormal3##t(4, 5, 6), 4, 5, 6); NORMAL(rtNormal3##t##v(t), 1, -2, 3); \
    NORMAL(rtNormal4##t(4, 5, 6, 7), 4, 5, 6); NORMAL(rtNormal4##t##v(t), 1, -2, 3)
    FORMS(s); FORMS(i); FORMS(f); FORMS(d);
#undef FORMS
}

static void texcoords(void)
{
    TEXCOORD((void)0, 0, 0, 0, 1);
#define FORMS(t) \
    TEXCOORD(rtTexCoord4##t(4, 5, 6, 7), 4, 5, 6, 7); TEXCOORD(rtTexCoord4##t##v(t), 1, -2, 3, 2); \
    TEXCOORD(rtTexCoord3##t(4, 5, 6), 4, 5, 6, 1); TEXCOORD(rtTexCoord3##t##v(t), 1, -2, 3, 1); \
    TEXCOORD(rtTexCoord2##t(4, 5), 4, 5, 0, 1); TEXCOORD(rtTexCoord2##t##v(t), 1, -2, 0, 1); \
    TEXCOORD(rtTexCoord1##t(4), 4, 0, 0, 1); TEXCOORD(rtTexCoord1##t##v(t), 1, 0, 0, 1)
    FORMS(s); FORMS(i); FORMS(f); FORMS(d);
#undef FORMS
}

/* The largest number of a type is 1, the smallest of a signed one -1. */
static void colors(void)
{
    const RTbyte b[4] = { 127, -128, 127, -128 };
    const RTshort sh[4] = { 32767, -32767 - 1, 32767, -32767 - 1 };
    const RTint in[4] = { 2147483647, -2147483647 - 1, 2147483647, -2147483647 - 1 };
    const RTubyte ub[4] = { 255, 0, 51, 102 };
    const RTushort us[4] = { 65535, 0, 13107, 26214 };
    const RTuint ui[4] = { 4294967295u, 0, 858993459u, 1717986918u };
    COLOR((void)0, 1, 1, 1, 1);
#define SIGNED(t, n, zero) \
    COLOR(rtColor3##t(n[0], n[1], 0), 1, -1, zero, 1); COLOR(rtColor3##t##v(n), 1, -1, 1, 1); \
    COLOR(rtColor4##t(n[0], n[1], 0, n[1]), 1, -1, zero, -1); COLOR(rtColor4##t##v(n), 1, -1, 1, -1)
    SIGNED(b, b, 1 / 255.0); SIGNED(s, sh, 1 / 65535.0); SIGNED(i, in, 0);
#undef SIGNED
#define UNSIGNED(t) \
    COLOR(rtColor3##t(t[0], t[1], t[2]), 1, 0, 0.2, 1); COLOR(rtColor3##t##v(t), 1, 0, 0.2, 1); \
    COLOR(rtColor4##t(t[0], t[1], t[2], t[3]), 1, 0, 0.2, 0.4); COLOR(rtColor4##t##v(t), 1, 0, 0.2, 0.4)
    UNSIGNED(ub); UNSIGNED(us); UNSIGNED(ui);
#undef UNSIGNED
#define UNSCALED(t) \
    COLOR(rtColor3##t(4, 5, 6), 4, 5, 6, 1); COLOR(rtColor3##t##v(t), 1, -2, 3, 1); \
    COLOR(rtColor4##t(4, 5, 6, 7), 4, 5, 6, 7); COLOR(rtColor4##t##v(t), 1, -2, 3, 2)
    UNSCALED(f); UNSCALED(d);
#undef UNSCALED
}

/* The square must show the triangle below the diagonal of its upper right quarter. */
static void shows_corner(int line)
{
    int row, column, wrong = 0;
    rtEndObject();
    rtRender();
    for (row = 0; row < HEIGHT; row++)
        for (column = 0; column < WIDTH; column++) {
            const double x = (column + 0.5) / WIDTH * 2 - 1, y = (row + 0.5) / HEIGHT * 2 - 1;
            const int inside = x > 0 && y > 0 && x + y < 1;
            /* Pixels on the diagonal may be either. */
            wrong += fabs(x + y - 1) > 1e-3 && inside != (frame[row][column][3] > 0.5f);
        }
    if (wrong > 0) {
        printf("%s:%d: %d pixels are wrong\n", __FILE__, line, wrong);
        failures++;
    }
    rtClearInstances();
}

static void vertices(void)
{
    int k;
    constant_shader(1, 1, 1);
#define TRIANGLE(call) \
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE); \
    rtBegin(RT_TRIANGLES); \
    for (k = 0; k < 3; k++) \
        call; \
    rtEnd(); \
    shows_corner(__LINE__)
    /* Corners (0, 0), (1, 0), (0, 1), also as homogeneous coordinates with w = 2. */
#define FORMS(t, type) \
    do { \
        const type v[3][4] = { { 0, 0, 0, 1 }, { 1, 0, 0, 1 }, { 0, 1, 0, 1 } }; \
        const type w[3][4] = { { 0, 0, 0, 1 }, { 2, 0, 0, 2 }, { 0, 2, 0, 2 } }; \
        TRIANGLE(rtVertex2##t(v[k][0], v[k][1])); TRIANGLE(rtVertex2##t##v(v[k])); \
        TRIANGLE(rtVertex3##t(v[k][0], v[k][1], 0)); TRIANGLE(rtVertex3##t##v(v[k])); \
        TRIANGLE(rtVertex4##t(w[k][0], w[k][1], 0, w[k][3])); TRIANGLE(rtVertex4##t##v(w[k])); \
    } while (0)
    FORMS(s, RTshort); FORMS(i, RTint); FORMS(f, RTfloat); FORMS(d, RTdouble);
}

int main(void)
{
    helpers_are_used();
    use_frame();
    look_at_square();
    normals();
    texcoords();
    colors();
    vertices();
    FINISH();
}
