/* SPDX-License-Identifier: GPL-3.0-or-later
 * The fragment rule: blocks too short for one primitive continue each other; others are blocks as in OpenGL. */
#include "check.h"

static RTuint sample, other;

/* Vertices of a block, on a parabola so that any three make a triangle. */
static int next_vertex = 0;

static void block(RTenum mode, int vertices)
{
    int i;
    rtBegin(mode);
    for (i = 0; i < vertices; i++, next_vertex++)
        rtVertex2f((float)next_vertex, (float)(next_vertex * next_vertex));
    rtEnd();
}

static void open(void)
{
    next_vertex = 0;
    rtBindShader(sample);
    rtCreateObject(RT_DEFINE);
}

/* Triangles of the object that is closed here. */
static int close(void)
{
    int before = integer(RT_TRIANGLE_COUNT);
    rtEndObject();
    return integer(RT_TRIANGLE_COUNT) - before;
}

int main(void)
{
    RTuint handle;
    int i;
    helpers_are_used();
    sample = constant_shader(1, 1, 1);
    other = constant_shader(0, 1, 0);

    open(); block(RT_TRIANGLES, 1); block(RT_TRIANGLES, 1); block(RT_TRIANGLES, 1); CHECK(close() == 1);
    open(); block(RT_TRIANGLES, 2); block(RT_TRIANGLES, 1); CHECK(close() == 1);
    open(); block(RT_TRIANGLES, 1); block(RT_TRIANGLES, 2); CHECK(close() == 1);
    open(); block(RT_TRIANGLES, 2); block(RT_TRIANGLES, 2); CHECK(close() == 1);
    open(); block(RT_TRIANGLES, 2); block(RT_TRIANGLES, 2); block(RT_TRIANGLES, 2); CHECK(close() == 2);
    open(); block(RT_TRIANGLES, 3); CHECK(close() == 1);

    /* Four, one left over and dropped, then three; then a fragment finds nothing waiting. */
    open(); block(RT_TRIANGLES, 4); block(RT_TRIANGLES, 3); CHECK(close() == 2);
    open(); block(RT_TRIANGLES, 5); block(RT_TRIANGLES, 1); CHECK(close() == 1);

    /* A whole block discards what waits and takes none of it. */
    open(); block(RT_TRIANGLES, 2); block(RT_TRIANGLES, 3); block(RT_TRIANGLES, 1); CHECK(close() == 1);
    open(); block(RT_TRIANGLES, 2); block(RT_TRIANGLES, 4); block(RT_TRIANGLES, 2); CHECK(close() == 1);

    /* Another mode. */
    open(); block(RT_TRIANGLES, 2); block(RT_QUADS, 1); block(RT_TRIANGLES, 1); CHECK(close() == 0);
    open(); block(RT_TRIANGLES, 2); block(RT_TRIANGLE_STRIP, 2); block(RT_TRIANGLES, 1); CHECK(close() == 0);
    open(); block(RT_TRIANGLES, 2); block(RT_POLYGON, 3); block(RT_TRIANGLES, 1); CHECK(close() == 1);

    /* Quads of 4, both halves at once. */
    open(); block(RT_QUADS, 1); block(RT_QUADS, 2); CHECK(close() == 0);
    open(); for (i = 0; i < 4; i++) block(RT_QUADS, 1); CHECK(close() == 2);
    open(); block(RT_QUADS, 3); block(RT_QUADS, 3); CHECK(close() == 2);
    open(); block(RT_QUADS, 3); block(RT_QUADS, 5); block(RT_QUADS, 1); CHECK(close() == 2);

    /* Strips, fans and polygons never continue. */
    open(); block(RT_TRIANGLE_STRIP, 2); block(RT_TRIANGLE_STRIP, 2); CHECK(close() == 0);
    open(); block(RT_TRIANGLE_FAN, 1); block(RT_TRIANGLE_FAN, 2); CHECK(close() == 0);
    open(); block(RT_POLYGON, 2); block(RT_POLYGON, 1); CHECK(close() == 0);
    open(); block(RT_QUAD_STRIP, 3); block(RT_QUAD_STRIP, 1); CHECK(close() == 0);

    /* Another shader discards; binding back and forth without a block between does not; nor does an empty block. */
    open(); block(RT_TRIANGLES, 2); rtBindShader(other); block(RT_TRIANGLES, 1); CHECK(close() == 0);
    open(); block(RT_TRIANGLES, 2); rtBindShader(other); block(RT_TRIANGLES, 1); rtBindShader(sample);
    block(RT_TRIANGLES, 1); CHECK(close() == 0);
    open(); block(RT_TRIANGLES, 2); rtBindShader(other); rtBindShader(sample); block(RT_TRIANGLES, 1);
    CHECK(close() == 1);
    open(); block(RT_TRIANGLES, 2); block(RT_TRIANGLES, 0); block(RT_QUADS, 0); block(RT_TRIANGLES, 1);
    CHECK(close() == 1);
    open(); block(RT_TRIANGLES, 2); rtBindShader(other); block(RT_POLYGON, 0); rtBindShader(sample);
    block(RT_TRIANGLES, 1); CHECK(close() == 1);

    /* The object's end discards. */
    open(); block(RT_TRIANGLES, 2); CHECK(close() == 0);
    open(); block(RT_TRIANGLES, 1); CHECK(close() == 0);

    /* The triangle's value is the one current at its last rtVertex; each vertex keeps its own matrix. */
    use_frame();
    look_at_square();
    rtGenNewShaderClass("sample", NULL);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("shader_color"), 0, 0, 0);
    handle = rtParameterHandle("triangle_color");
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtParameter3f(rtParameterHandle("vertex_color"), 0, 0, 0);
    rtParameter3f(handle, 0, 0, 0);
    rtBegin(RT_TRIANGLES); rtVertex2f(-1, -1); rtEnd();
    rtPushMatrix();
    rtTranslatef(3, 0, 0);
    rtBegin(RT_TRIANGLES); rtVertex2f(0, -1); rtEnd();
    rtPopMatrix();
    rtBegin(RT_TRIANGLES);
    rtParameter3f(handle, 0, 3, 0);
    rtVertex2f(-1, 3);
    rtParameter3f(handle, 3, 0, 0);
    rtEnd();
    rtEndObject();
    rtRender();
    SHOWS(0, 0, 0, 1, 0);
    SHOWS(0.8, -0.8, 0, 1, 0);

    /* The unnamed object follows the rule too, and forgets what waits when a frame starts. */
    rtClearInstances();
    constant_shader(1, 0, 0);
    rtBegin(RT_TRIANGLES); rtVertex2f(-3, -1); rtVertex2f(3, -1); rtEnd();
    rtBegin(RT_TRIANGLES); rtVertex2f(0, 5); rtEnd();
    rtRender();
    SHOWS(0, 0, 1, 0, 0);
    rtBegin(RT_TRIANGLES); rtVertex2f(-3, -1); rtVertex2f(3, -1); rtEnd();
    rtRender();
    CHECK(covered() == 0);
    rtBegin(RT_TRIANGLES); rtVertex2f(0, 5); rtEnd();
    rtRender();
    CHECK(covered() == 0);
    FINISH();
}
