/* SPDX-License-Identifier: GPL-3.0-or-later
 * A viewer in the manner of scene graphs: reads an OBJ file with its MTL, makes a node of every group, each an OpenRT object
 * with the shaders of its materials, and renders it. Only OpenRT calls below the parser.
 *
 *   cc objview.c $(pkg-config --cflags --libs openrt) -lm -o objview
 *   ./objview scene.obj picture.ppm [--size W H] [--eye X Y Z --at X Y Z] [--up X Y Z] [--fov DEGREES] [--samples N]
 *
 * Without --eye the whole scene is seen from a corner. Faces with more than three corners are taken as convex.
 */
#include "picture.h"
#include <math.h>
#include <openrt/rt.h>
#include <stdlib.h>
#include <string.h>

/* A list of numbers that grows. */
typedef struct {
    float *v;
    size_t count, room;
} Numbers;

typedef struct {
    char name[128];
    float kd[3], ks[3], ke[3], ns, d;
    RTuint shader;
} Material;

/* A node of the scene: a group of faces. */
typedef struct {
    RTuint object;
    int has_faces;
} Node;

static Numbers positions, normals, texcoords;
static Material *materials;
static int material_count;
static Node node;
static int node_count;
static float low[3] = { 1e30f, 1e30f, 1e30f }, high[3] = { -1e30f, -1e30f, -1e30f };

static void fail(const char *what, const char *name)
{
    fprintf(stderr, "objview: %s %s\n", what, name);
    exit(1);
}

static void add_numbers(Numbers *list, const char *text, int count)
{
    int k;
    if (list->count + (size_t)count > list->room) {
        list->room = 2 * list->room + 3072;
        list->v = realloc(list->v, list->room * sizeof(float));
        if (list->v == NULL)
            fail("no memory for", "numbers");
    }
    for (k = 0; k < count; k++) {
        char *end;
        list->v[list->count++] = (float)strtod(text, &end);
        text = end;
    }
}

static void three(const char *text, float *out)
{
    char *end;
    out[0] = (float)strtod(text, &end);
    out[1] = (float)strtod(end, &end);
    out[2] = (float)strtod(end, &end);
}

/* The text after a keyword, if the line begins with it. */
static const char *after(const char *line, const char *keyword)
{
    const size_t length = strlen(keyword);
    while (*line == ' ' || *line == '\t')
        line++;
    if (strncmp(line, keyword, length) != 0 || (line[length] != ' ' && line[length] != '\t'))
        return NULL;
    line += length;
    while (*line == ' ' || *line == '\t')
        line++;
    return line;
}

/* The path of a file beside another one. */
static void beside(const char *path, const char *name, char *out, size_t size)
{
    const char *slash = strrchr(path, '/');
    snprintf(out, size, "%.*s%s", slash ? (int)(slash - path + 1) : 0, path, name);
}

static Material *new_material(const char *name)
{
    Material *m;
    materials = realloc(materials, sizeof *materials * (size_t)(material_count + 1));
    if (materials == NULL)
        fail("no memory for", name);
    m = &materials[material_count++];
    memset(m, 0, sizeof *m);
    snprintf(m->name, sizeof m->name, "%s", name);
    m->kd[0] = m->kd[1] = m->kd[2] = 0.8f;
    m->ns = 10, m->d = 1;
    return m;
}

static void read_mtl(const char *path)
{
    FILE *file = fopen(path, "r");
    char line[4096];
    Material *m = NULL;
    if (file == NULL) {
        fprintf(stderr, "objview: no material file %s\n", path);
        return;
    }
    while (fgets(line, sizeof line, file)) {
        const char *rest;
        line[strcspn(line, "\r\n")] = 0;
        if ((rest = after(line, "newmtl")))
            m = new_material(rest);
        else if (m == NULL)
            continue;
        else if ((rest = after(line, "Kd")))
            three(rest, m->kd);
        else if ((rest = after(line, "Ks")))
            three(rest, m->ks);
        else if ((rest = after(line, "Ke")))
            three(rest, m->ke);
        else if ((rest = after(line, "Ns")))
            m->ns = (float)atof(rest);
        else if ((rest = after(line, "d")))
            m->d = (float)atof(rest);
        else if ((rest = after(line, "Tr")))
            m->d = 1 - (float)atof(rest);
    }
    fclose(file);
}

/* Makes the shader of a material when a face first wants it, and binds it. */
static void use_material(const char *name)
{
    Material *m = NULL;
    int i;
    for (i = 0; i < material_count; i++)
        if (strcmp(materials[i].name, name) == 0)
            m = &materials[i];
    if (m == NULL)
        m = new_material(name);
    if (m->shader != 0) {
        rtBindShader(m->shader);
        return;
    }
    rtGenNewShaderClass("Phong", NULL);
    m->shader = rtGenNewShader();
    rtParameter3fv(rtParameterHandle("diffuseColor"), m->kd);
    rtParameter3fv(rtParameterHandle("specularColor"), m->ks);
    rtParameter3fv(rtParameterHandle("emissiveColor"), m->ke);
    rtParameter1f(rtParameterHandle("shininess"), m->ns > 128 ? 1 : m->ns / 128);
    rtParameter1f(rtParameterHandle("transparency"), 1 - m->d);
}

static void close_node(void)
{
    if (node.object == 0)
        return;
    rtEndObject();
    if (node.has_faces) {
        rtInstantiateObject(node.object);
        node_count++;
    } else
        rtRemoveObject(node.object);
    node.object = 0;
}

static void open_node(void)
{
    close_node();
    node.object = rtCreateObject(RT_DEFINE);
    node.has_faces = 0;
}

/* Item number `index` of a list, counted from 1, or from the end if negative. */
static const float *item(const Numbers *list, long index, int width)
{
    const long count = (long)list->count / width;
    const long i = index < 0 ? count + index : index - 1;
    return i >= 0 && i < count ? list->v + i * width : NULL;
}

static void corner(const long index[3])
{
    const float *p = item(&positions, index[0], 3), *t = item(&texcoords, index[1], 2), *n = item(&normals, index[2], 3);
    int k;
    if (t)
        rtTexCoord2fv(t);
    if (n)
        rtNormal3fv(n);
    rtVertex3fv(p);
    for (k = 0; k < 3; k++) {
        low[k] = p[k] < low[k] ? p[k] : low[k];
        high[k] = p[k] > high[k] ? p[k] : high[k];
    }
}

static void read_face(const char *text)
{
    long corners[64][3];
    int count = 0, i;
    while (count < 64) {
        char *end;
        long *c = corners[count];
        c[1] = c[2] = 0;
        c[0] = strtol(text, &end, 10);
        if (end == text)
            break;
        if (*end == '/') {
            c[1] = strtol(end + 1, &end, 10);
            if (*end == '/')
                c[2] = strtol(end + 1, &end, 10);
        }
        if (item(&positions, c[0], 3) == NULL)
            return;
        text = end;
        count++;
    }
    if (count < 3)
        return;
    if (node.object == 0)
        open_node();
    rtBegin(RT_POLYGON);
    /* Without normals of its own a face is flat: that of the polygon, since others in the object may have some. */
    if (item(&normals, corners[0][2], 3) == NULL) {
        const float *a = item(&positions, corners[0][0], 3), *b = item(&positions, corners[1][0], 3);
        const float *c = item(&positions, corners[2][0], 3);
        const float u[3] = { b[0] - a[0], b[1] - a[1], b[2] - a[2] }, v[3] = { c[0] - a[0], c[1] - a[1], c[2] - a[2] };
        rtNormal3f(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
    }
    for (i = 0; i < count; i++)
        corner(corners[i]);
    rtEnd();
    node.has_faces = 1;
}

static void read_obj(const char *path)
{
    FILE *file = fopen(path, "r");
    char line[8192], library[4096];
    if (file == NULL)
        fail("cannot read", path);
    use_material("(none)");
    while (fgets(line, sizeof line, file)) {
        const char *rest;
        line[strcspn(line, "\r\n")] = 0;
        if ((rest = after(line, "v")))
            add_numbers(&positions, rest, 3);
        else if ((rest = after(line, "vn")))
            add_numbers(&normals, rest, 3);
        else if ((rest = after(line, "vt")))
            add_numbers(&texcoords, rest, 2);
        else if ((rest = after(line, "f")))
            read_face(rest);
        else if (after(line, "g") || after(line, "o"))
            open_node();
        else if ((rest = after(line, "usemtl")))
            use_material(rest);
        else if ((rest = after(line, "mtllib"))) {
            beside(path, rest, library, sizeof library);
            read_mtl(library);
        }
    }
    fclose(file);
    close_node();
    if (node_count == 0)
        fail("no faces in", path);
}

static void sun(float x, float y, float z, float radiance)
{
    rtGenNewShaderClass("InfiniteLightShader", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("direction"), x, y, z);
    rtParameter3f(rtParameterHandle("radiance"), radiance, radiance, radiance);
}

int main(int argc, char **argv)
{
    double eye[3], at[3], up[3] = { 0, 1, 0 }, fov = 45, reach = 0, distance = 0;
    int width = 640, height = 480, samples = 4, has_eye = 0, failed, i, k;
    RTubyte *pixels;
    RTint triangles;
    rtInit(&argc, argv);
    if (argc < 3) {
        fprintf(stderr, "usage: objview scene.obj picture.ppm [--size W H] [--eye X Y Z --at X Y Z] [--up X Y Z] "
                        "[--fov DEGREES] [--samples N]\n");
        return 2;
    }
    read_obj(argv[1]);
    for (k = 0; k < 3; k++) {
        at[k] = 0.5 * (low[k] + high[k]);
        reach = fmax(reach, high[k] - low[k]);
    }
    eye[0] = at[0] + 1.1 * reach, eye[1] = at[1] + 0.7 * reach, eye[2] = at[2] + 1.3 * reach;
    for (i = 3; i < argc; i++) {
        const int left = argc - i - 1;
        double *target = strcmp(argv[i], "--eye") == 0 ? eye : strcmp(argv[i], "--at") == 0 ? at : up;
        if ((target != up || strcmp(argv[i], "--up") == 0) && left >= 3) {
            for (k = 0; k < 3; k++)
                target[k] = atof(argv[++i]);
            has_eye |= target == eye;
        } else if (strcmp(argv[i], "--size") == 0 && left >= 2) {
            width = atoi(argv[++i]);
            height = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--fov") == 0 && left >= 1)
            fov = atof(argv[++i]);
        else if (strcmp(argv[i], "--samples") == 0 && left >= 1)
            samples = atoi(argv[++i]);
        else
            fail("unknown argument, or too few numbers after it:", argv[i]);
    }
    if (width < 1 || height < 1 || samples < 1)
        fail("size and samples must be positive", "");

    sun(0.5f, 1.f, 0.7f, 0.7f);
    sun(-0.6f, 0.4f, 0.3f, 0.25f);
    /* A lamp at the eye, for rooms that no sun reaches. */
    for (k = 0; k < 3; k++)
        distance += (eye[k] - at[k]) * (eye[k] - at[k]);
    rtGenNewShaderClass("SpotLightShader", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("position"), (float)eye[0], (float)eye[1], (float)eye[2]);
    rtParameter3f(rtParameterHandle("radiance"), (float)(0.4 * distance), (float)(0.4 * distance), (float)(0.4 * distance));
    rtGenNewShaderClass("ConstantEnvironmentShader", NULL);
    rtUseEnvironmentShader(rtGenNewShader());
    rtParameter3f(rtParameterHandle("value"), 0.35f, 0.42f, 0.5f);
    rtLookAt(eye[0], eye[1], eye[2], at[0], at[1], at[2], up[0], up[1], up[2]);
    rtPerspective(fov, 0.001 * reach, 100 * reach);
    rtSetRayEpsilon((RTfloat)(1e-5 * reach));
    rtSetSamplesPerPixel((RTuint)samples);
    pixels = malloc((size_t)width * (size_t)height * 3);
    rtSetFrameBuffer(pixels, (RTuint)width, (RTuint)height, RT_RGB_8);
    rtRender();
    failed = write_ppm(argv[2], pixels, width, height);
    rtGetIntegerv(RT_TRIANGLE_COUNT, &triangles);
    printf("%d nodes, %d triangles, %d materials%s\n", node_count, triangles, material_count,
           has_eye ? "" : ", seen from a corner");
    if (rtGetError() != RT_NO_ERROR)
        failed = 1;
    rtExit();
    free(pixels);
    free(positions.v);
    free(normals.v);
    free(texcoords.v);
    free(materials);
    return failed;
}
