/* SPDX-License-Identifier: GPL-3.0-or-later
 * A plugin that checks what it is given: every type and rate of parameter, batches, services. Needs tricky.so beside it. */
#include "check.h"

static RTuint of(const char *name)
{
    RTuint handle = rtParameterHandle(name);
    if (handle == RT_INVALID) {
        printf("no parameter %s\n", name);
        failures++;
    }
    return handle;
}

/* Handles cannot be asked for between rtBegin and rtEnd. */
static RTuint v_weight;

static void corner(float x, float y)
{
    rtParameter1d(v_weight, 0.25 * x);
    rtColor4f(0.125f, 0.25f, 0.5f, 0.5f);
    rtTexCoord2f(x, y);
    rtVertex3f(x, y, 0);
}

int main(void)
{
    static const RTfloat matrix[16] = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16 };
    const RTenum IV = RT_INVALID_VALUE, IO = RT_INVALID_OPERATION, OK = RT_NO_ERROR;
    const RTfloat three_four[2] = { 3, 4 };
    const double pair[2] = { 1.5, 2.5 };
    RTfloat read[16];
    RTuint object, instance, class_id, h, first;
    char text[8] = "a text";
    int row, column;

    use_frame();
    look_at_square();
    rtGenObjects(3);
    class_id = rtGenNewShaderClass("probe", "./tricky.so");
    CHECK(class_id != RT_INVALID);
    first = rtGenNewShader();
    v_weight = of("v_weight");
    EXPECT(rtGetParameterfv(of("f32"), read), OK);
    CHECK(read[0] == 0.5f);

    /* Sizes and types must be those declared. */
    h = of("i8");
    EXPECT(rtParameter1i(h, -129), IV); EXPECT(rtParameter1f(h, 1), IO); EXPECT(rtParameter1i(h, -5), OK);
    h = of("u8");
    EXPECT(rtParameter1i(h, -1), IV); EXPECT(rtParameter1i(h, 250), OK);
    h = of("i16");
    EXPECT(rtParameter1i(h, 40000), IV); EXPECT(rtParameter1i(h, -30000), OK);
    h = of("u16");
    EXPECT(rtParameter1i(h, 60000), OK);
    h = of("i32");
    EXPECT(rtParameter3i(h, 1, 2, 3), IO); EXPECT(rtParameter4f(h, 1, 2, 3, 4), IO); EXPECT(rtParameter4i(h, 1, 2, 3, -4), OK);
    rtGetParameterfv(h, read);
    CHECK(read[0] == 1 && read[3] == -4);
    h = of("u32");
    EXPECT(rtParameter1i(h, (RTint)4000000000u), OK);
    rtGetParameterfv(h, read);
    CHECK(read[0] == 4000000000.0f);
    h = of("matrix");
    EXPECT(rtParameter4fv(h, matrix), IO); EXPECT(rtParameter16fv(h, matrix), OK);
    h = of("f64");
    EXPECT(rtParameter1f(h, 1), IO); EXPECT(rtParameter1d(h, 0.1), OK);
    h = of("pair");
    EXPECT(rtParameter1d(h, 1), IO); EXPECT(rtParameterRaw(h, pair, 8), IO); EXPECT(rtParameterRaw(h, NULL, 16), IV);
    EXPECT(rtParameterRaw(h, pair, 16), OK);
    rtGetParameterfv(h, read);
    CHECK(read[0] == 1.5f && read[1] == 2.5f);
    h = of("text");
    EXPECT(rtParameterString(h, NULL), IV); EXPECT(rtParameter1i(h, 1), IO); EXPECT(rtParameterRaw(h, &text, 8), IO);
    EXPECT(rtGetParameterfv(h, read), IO);
    EXPECT(rtParameterString(h, text), OK);
    strcpy(text, "other"); /* it was copied */
    EXPECT(rtParameterString(of("f32"), "0.5"), IO);
    EXPECT(rtParameterHandle("no such parameter"), IV);

    /* A rectangle with values of each rate, behind three triangles of another shader. */
    object = rtNewObject(RT_COMPILE);
    constant_shader(1, 0, 0);
    rectangle(-1, -1, 1, 1, -3);
    rtBegin(RT_TRIANGLES);
    rtVertex3f(0, 0, -4), rtVertex3f(1, 0, -4), rtVertex3f(0, 1, -4);
    rtVertex3f(0, 0, -4), rtVertex3f(1, 1, -4), rtVertex3f(2, 2, -4); /* no area: it does not count */
    rtEnd();
    rtBindShader(first);
    h = of("t_number");
    EXPECT(rtGetParameterfv(h, read), OK);
    CHECK(read[0] == 0);
    EXPECT(rtParameter1f(h, -7), IO); EXPECT(rtParameter1i(h, 1 << 20), IV); EXPECT(rtParameter1i(h, -7), OK);
    rtGetParameterfv(h, read);
    CHECK(read[0] == -7);
    EXPECT(rtParameter2fv(of("t_pair"), three_four), OK);
    rtBegin(RT_QUADS);
    corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1);
    rtEnd();
    instance = rtInstantiateObject(object);
    EXPECT(rtParameter3i(of("expected"), (RTint)object, (RTint)instance, 3), OK);
    CHECK(object > 3 && instance >= 1);

    EXPECT(rtRender(), OK);
    CHECK(covered() == WIDTH * HEIGHT);
    for (row = 0; row < HEIGHT; row++)
        for (column = 0; column < WIDTH; column++) {
            const float *p = frame[row][column];
            if (p[0] != 1 || p[1] != 1) {
                printf("pixel %d,%d: batch %g, services %g\n", column, row, p[0], p[1]);
                failures++;
                row = HEIGHT, column = WIDTH;
            }
        }

    /* Edits while the frame is in flight show in the next one: the text of this one stays. */
    rtStartRendering();
    rtParameterString(of("text"), "another one");
    rtDeleteInstance(instance);
    rtEndRendering();
    SHOWS(0, 0, 1, 1, 1);
    /* Geometry outside of objects has no ids. */
    rtParameterString(of("text"), "a text");
    rtParameter3i(of("expected"), 0, 0, 0);
    rtParameter1i(of("t_number"), -7), rtParameter2fv(of("t_pair"), three_four);
    rtBegin(RT_QUADS);
    corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1);
    rtEnd();
    EXPECT(rtRender(), OK);
    SHOWS(0, 0, 1, 1, 1);
    FINISH();
}
