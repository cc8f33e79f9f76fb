/* SPDX-License-Identifier: GPL-3.0-or-later
 * The scene of Figure 1 of the GNU RT paper: one shader with a parameter per shader, per triangle and per vertex.
 *
 *   cc figure1.c $(pkg-config --cflags --libs openrt) -lm -o figure1 && ./figure1 figure1.ppm
 */
#include <math.h>
#include <openrt/rt.h>
#include <stdio.h>

#define WIDTH 640
#define HEIGHT 480
#define TRIANGLES 12

static RTubyte pixels[HEIGHT][WIDTH][3];

/* PPM files begin with the top row, frame buffers with the lowest one. */
static int write_ppm(const char *path)
{
    FILE *file = fopen(path, "wb");
    int row;
    if (file == NULL)
        return 1;
    fprintf(file, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
    for (row = HEIGHT - 1; row >= 0; row--)
        fwrite(pixels[row], 3, WIDTH, file);
    return fclose(file) != 0;
}

int main(int argc, char **argv)
{
    const double turn = 2 * 3.14159265358979 / TRIANGLES;
    RTuint shader_color, triangle_color, vertex_color, object;
    int i, j;

    /* Load a built-in class, make a shader of it, find its three parameters. */
    rtGenNewShaderClass("sample", NULL);
    rtGenNewShader();
    shader_color = rtParameterHandle("shader_color");
    triangle_color = rtParameterHandle("triangle_color");
    vertex_color = rtParameterHandle("vertex_color");
    rtParameter3f(shader_color, 1.f, 0.f, 0.f);

    /* Define an object: a rosette of triangles. */
    object = rtGenObjects(1);
    rtNewObject(object, RT_COMPILE);
    for (i = 0; i < TRIANGLES; i++) {
        const float hue = (float)i / TRIANGLES;
        rtParameter3f(triangle_color, 1.f - hue, hue, 0.5f);
        rtBegin(RT_TRIANGLES);
        for (j = 0; j < 3; j++) {
            const double angle = turn * (i + (j == 1 ? 0.05 : 0.95));
            const float radius = j == 0 ? 0.f : 0.2f;
            rtParameter3f(vertex_color, j == 0, j == 1, j == 2);
            rtVertex3f(radius * (float)cos(angle), radius * (float)sin(angle), j == 0 ? 0.08f : 0.f);
        }
        rtEnd();
    }

    /* Put it into the scene, ten times as large. This closes the object too. */
    rtMatrixMode(RT_MODELVIEW);
    rtLoadIdentity();
    rtScalef(10.f, 10.f, 10.f);
    rtInstantiateObject(object);

    rtLookAt(0, -2, 4, 0, 0, 0, 0, 1, 0);
    rtSetFrameBuffer(&pixels[0][0][0], WIDTH, HEIGHT, RT_RGB_8);
    rtRender();
    if (rtGetError() != RT_NO_ERROR)
        return 1;
    return write_ppm(argc > 1 ? argv[1] : "figure1.ppm");
}
