/* SPDX-License-Identifier: GPL-3.0-or-later
 * Where pixels are and what is written for them: centres to the last pixel of a large picture, all formats, and
 * nothing beside the buffer. */
#include "check.h"

/* Red is x, green is y over the square, both in [0, 1]. */
static void gradient(void)
{
    RTuint vertex;
    rtGenNewShaderClass("sample", NULL);
    rtGenNewShader();
    vertex = rtParameterHandle("vertex_color");
    rtParameter3f(rtParameterHandle("shader_color"), 0, 0, 0);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtParameter3f(rtParameterHandle("triangle_color"), 0, 0, 0);
    rtBegin(RT_QUADS);
    rtParameter3f(vertex, 0, 0, 0); rtVertex2f(-1, -1);
    rtParameter3f(vertex, 3, 0, 0); rtVertex2f(1, -1);
    rtParameter3f(vertex, 3, 3, 0); rtVertex2f(1, 1);
    rtParameter3f(vertex, 0, 3, 0); rtVertex2f(-1, 1);
    rtEnd();
    rtEndObject();
}

static void centres(void)
{
    enum { COLUMNS = 4096, ROWS = 64 };
    static float picture[ROWS][COLUMNS][3];
    int row, column, wrong = 0;
    gradient();
    rtSetFrameBuffer((RTubyte *)picture, COLUMNS, ROWS, RT_RGB_32);
    rtRender();
    for (row = 0; row < ROWS; row++)
        for (column = 0; column < COLUMNS; column++) {
            const float *p = picture[row][column];
            wrong += fabs(p[0] * COLUMNS - (column + 0.5)) > 0.25 || fabs(p[1] * ROWS - (row + 0.5)) > 0.25;
        }
    if (wrong > 0)
        printf("%d pixels are not seen at their centre\n", wrong);
    CHECK(wrong == 0);
    rtClearInstances();
}

static double srgb_byte(double linear)
{
    const double x = linear < 0 ? 0 : linear > 1 ? 1 : linear;
    return floor(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055) + 0.5);
}

/* Three columns and two rows; a surface fills the lower row. */
static void format(RTenum code, const char *order, int is_float)
{
    const float surface[4] = { 0.5f, -1, 0.0029f, 1 };
    const size_t numbers = strlen(order), number_size = is_float ? 4 : 1, size = 6 * numbers * number_size;
    RTubyte memory[200];
    size_t i, k;
    memset(memory, 0xAB, sizeof memory);
    /* One byte off any alignment. */
    rtSetFrameBuffer(memory + 1, 3, 2, code);
    rtRender();
    for (i = 0; i < 6; i++)
        for (k = 0; k < numbers; k++) {
            const RTubyte *at_number = memory + 1 + (i * numbers + k) * number_size;
            const size_t channel = (size_t)(strchr("rgba", order[k]) - "rgba");
            const double linear = i < 3 ? surface[channel] : 0;
            float number = *at_number;
            if (is_float)
                memcpy(&number, at_number, 4);
            NEAR(number, is_float ? linear : channel == 3 ? 255 * linear : srgb_byte(linear), 1e-6);
        }
    CHECK(memory[0] == 0xAB);
    for (i = 1 + size; i < sizeof memory; i++)
        CHECK(memory[i] == 0xAB);
}

int main(void)
{
    helpers_are_used();
    look_at_square();
    centres();
    constant_shader(0.5f, -1, 0.0029f);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 0, 0);
    rtEndObject();
    format(RT_BGR_32, "bgr", 1); format(RT_RGB_32, "rgb", 1); format(RT_RGBA_32, "rgba", 1);
    format(RT_BGRA_32, "bgra", 1); format(RT_RGB_8, "rgb", 0); format(RT_RGBA_8, "rgba", 0);
    format(RT_BGR_8, "bgr", 0); format(RT_BGRA_8, "bgra", 0);
    FINISH();
}
