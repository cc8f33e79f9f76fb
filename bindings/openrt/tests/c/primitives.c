/* SPDX-License-Identifier: GPL-3.0-or-later
 * Triangles of each mode: how many, where they are and which way they wind. */
#include "check.h"

/* Draws an object of these vertices and returns the number of its triangles. */
static int draw(RTenum mode, int count, const float (*v)[2])
{
    int i, before;
    rtClearInstances();
    before = integer(RT_TRIANGLE_COUNT);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(mode);
    for (i = 0; i < count; i++)
        rtVertex2fv(v[i]);
    rtEnd();
    rtEndObject();
    rtRender();
    return integer(RT_TRIANGLE_COUNT) - before;
}

int main(void)
{
    const float zigzag[6][2] = { { -1, -1 }, { -1, 1 }, { 0, -1 }, { 0, 1 }, { 1, -1 }, { 1, 1 } };
    const float ring[6][2] = { { -1, -1 }, { 1, -1 }, { 1, 1 }, { 0, 1 }, { -1, 1 }, { -1, 0 } };
    const float bad[6][2] = { { 0, 0 }, { 1, 0 }, { 1, 0 }, { 0, 0 }, { 0.5f, 0.5f }, { 1, 1 } };
    const int all = WIDTH * HEIGHT;
    helpers_are_used();
    use_frame();
    look_at_square();
    constant_shader(1, 1, 1);

    CHECK(draw(RT_TRIANGLES, 3, ring) == 1);
    SHOWS(0.5, -0.5, 1, 1, 1);
    SHOWS(-0.5, 0.5, 0, 0, 0);
    CHECK(draw(RT_TRIANGLE_STRIP, 6, zigzag) == 4 && covered() == all);
    CHECK(draw(RT_TRIANGLE_STRIP, 5, zigzag) == 3);
    SHOWS(0.8, 0.8, 0, 0, 0);
    CHECK(draw(RT_QUAD_STRIP, 6, zigzag) == 4 && covered() == all);
    CHECK(draw(RT_QUAD_STRIP, 5, zigzag) == 2 && covered() == all / 2);
    CHECK(draw(RT_TRIANGLE_FAN, 6, ring) == 3 && covered() == all);
    CHECK(draw(RT_POLYGON, 5, ring) == 3 && covered() == all);
    CHECK(draw(RT_QUADS, 6, ring) == 2);

    /* Without area or without a place: dropped silently; tiny ones are kept. */
    CHECK(draw(RT_TRIANGLES, 6, bad) == 0 && covered() == 0);
    rtCreateObject(RT_DEFINE);
    rtBegin(RT_TRIANGLES);
    rtVertex2f(0, 0); rtVertex2f(1, 0); rtVertex2f(NAN, 1);
    rtVertex2f(0, 0); rtVertex2f(1, 0); rtVertex2f(INFINITY, 1);
    rtVertex2f(0, 0); rtVertex2f(1e-12f, 0); rtVertex2f(0, 1e-12f);
    rtEnd();
    rtEndObject();
    {
        const int with_tiny = integer(RT_TRIANGLE_COUNT);
        CHECK(draw(RT_TRIANGLES, 3, ring) == 1 && integer(RT_TRIANGLE_COUNT) == with_tiny + 1);
    }

    /* All triangles of a strip wind the same way: mirrors and normals do not show it, but a light on one side does not
     * either, since geometric normals turn to the ray. What shows is that no triangle is lost from either side. */
    rtLookAt(0, 0, -10, 0, 0, 0, 0, 1, 0);
    CHECK(draw(RT_TRIANGLE_STRIP, 6, zigzag) == 4 && covered() == all);
    FINISH();
}
