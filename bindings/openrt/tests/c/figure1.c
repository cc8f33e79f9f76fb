/* SPDX-License-Identifier: GPL-3.0-or-later
 * Figure 1 of the GNU RT paper, word for word but for its elisions and the shader library's name, with the calls around
 * it that draw. Usage: figure1 TRIANGLES PICTURE.ppm */
#include "check.h"

/* The library with the class "sample"; NULL = the built-in one. */
#ifndef SHADER_FILE
#define SHADER_FILE NULL
#endif

static float picture_data[120][160][3];

static void write_ppm(const char *path, const RTubyte *pixels, int width, int height)
{
    FILE *file = fopen(path, "wb");
    int row;
    CHECK(file != NULL);
    if (file == NULL)
        return;
    fprintf(file, "P6\n%d %d\n255\n", width, height);
    for (row = height - 1; row >= 0; row--)
        fwrite(pixels + (size_t)row * width * 3, 3, width, file);
    fclose(file);
}

int main(int argc, char **argv)
{
    static RTubyte bytes[120][160][3];
    int tri_nb = argc > 1 ? atoi(argv[1]) : 7, i, j;
    RTuint shaderClassId, Id, colorId, tcolorId, vcolorId, objId, instId;

    /* Creation d'un shader */
    shaderClassId =
        rtGenNewShaderClass("sample", SHADER_FILE);
    /* Le shader est instancié une fois */
    Id = rtGenNewShader();
    /* On récupère 3 paramètres de shader */
    colorId = rtParameterHandle("shader_color");
    tcolorId = rtParameterHandle("triangle_color");
    vcolorId = rtParameterHandle("vertex_color");
    rtParameter3f(colorId, 1.f, 0.f, 0.f);

    /* Création d'un objet */
    objId = rtGenObjects(1);
    rtNewObject(objId, RT_COMPILE);
    for(i = 0; i < tri_nb; i++) {
        const RTfloat tcolor[3] = { 0.f, 1.f, 0.f }, white[3] = { 1.f, 1.f, 1.f };
        const double turn = 6.283185307179586 / tri_nb;
        /* Paramètre par triangle */
        rtParameter3fv(tcolorId, tcolor);
        for(j = 0; j < 3; j++) {
            const RTfloat vcolor[3] = { 0.f, 0.f, j == 0 ? 1.f : 0.f };
            const double angle = turn * (i + (j == 1 ? 0.1 : 0.9));
            const RTfloat vertex[3] = { j == 0 ? 0.f : (RTfloat)(0.2 * cos(angle)),
                                        j == 0 ? 0.f : (RTfloat)(0.2 * sin(angle)), 0.f };
            rtBegin(RT_TRIANGLES);
            /* Paramètre par triangle */
            rtParameter3fv(vcolorId, vcolor);
            rtColor3fv(white);
            rtVertex3fv(vertex);
            rtEnd();
        }
    }

    /* Création d'une instance */
    /* Matrice de modèle associée à l'instance */
    rtMatrixMode(RT_MODELVIEW);
    rtLoadIdentity();
    rtScalef(10.f, 10.f, 10.f);
    instId = rtInstantiateObject(objId);

    CHECK(rtGetError() == RT_NO_ERROR);
    CHECK(shaderClassId != RT_INVALID && Id != RT_INVALID && objId != RT_INVALID);
    CHECK(instId != RT_INVALID && instId >= 1);
    CHECK(integer(RT_TRIANGLE_COUNT) == tri_nb);
    CHECK(integer(RT_INSTANCE_COUNT) == 1);

    rtLookAt(0, 0, 5, 0, 0, 0, 0, 1, 0);
    rtSetFrameBuffer(&bytes[0][0][0], 160, 120, RT_RGB_8);
    rtRender();
    if (argc > 2)
        write_ppm(argv[2], &bytes[0][0][0], 160, 120);

    /* The same in numbers: near the middle the mean of red, green and blue, farther out without blue. */
    rtSetFrameBuffer((RTubyte *)picture_data, 160, 120, RT_RGB_32);
    rtRender();
    if (tri_nb == 7) {
        const float *outside = picture_data[0][0];
        int row = 60 + (int)(18 * sin(6.283185307179586 / 14)), column = 80 + (int)(18 * cos(6.283185307179586 / 14));
        const float *inside = picture_data[row][column];
        CHECK(outside[0] == 0 && outside[1] == 0 && outside[2] == 0);
        CHECK(inside[0] > 0.25f && inside[0] <= 0.3334f);
        NEAR(inside[1], inside[0], 1e-5);
        CHECK(inside[2] > 0.02f && inside[2] < inside[0]);
    }
    FINISH();
}
