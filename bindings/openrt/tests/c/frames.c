/* SPDX-License-Identifier: GPL-3.0-or-later
 * Frames: what is edited after the start does not show, cancelled frames, progressive frames, formats, two buffers. */
#define _POSIX_C_SOURCE 200112L
#include "check.h"
#include <pthread.h>
#include <time.h>

#define BIG 192
static float big[2][BIG][BIG][4];

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void use_big(int n)
{
    rtSetFrameBuffer((RTubyte *)big[n], BIG, BIG, RT_RGBA_32);
}

static RTuint textured, plain, light, texture, object, instance;

static void image(float value)
{
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_LUMINANCE, 1, 1, 0, RT_LUMINANCE, RT_FLOAT, &value);
}

/* A textured left half and a lit right half. */
static void scene(void)
{
    texture = rtGenTextures(1);
    image(0.5f);
    rtGenNewShaderClass("TextureShader", NULL);
    textured = rtGenNewShader();
    rtParameter1i(rtParameterHandle("texture"), (RTint)texture);
    rtGenNewShaderClass("InfiniteLightShader", NULL);
    light = rtGenNewShader();
    rtUseLight(light);
    rtGenNewShaderClass("DiffuseShader", NULL);
    plain = rtGenNewShader();
    rtParameter3f(rtParameterHandle("color"), 0.25f, 0.5f, 0.75f);
    object = rtCreateObject(RT_DEFINE);
    rectangle(0, -1, 1, 1, 0);
    rtBindShader(textured);
    rectangle(-1, -1, 0, 1, 0);
    instance = rtInstantiateObject(object);
    look_at_square();
}

static int shows(int n, double x, double r, double g, double b)
{
    const float *p = big[n][BIG / 2][(int)((x + 1) / 2 * BIG)];
    return fabs(p[0] - r) < 1e-4 && fabs(p[1] - g) < 1e-4 && fabs(p[2] - b) < 1e-4;
}

static void edit_texture(void) { image(0.875f); }
static void edit_shader(void)
{
    rtBindShader(plain);
    rtParameter3f(rtParameterHandle("color"), 1, 0, 0);
}
static void edit_light(void)
{
    rtBindShader(light);
    rtParameter3f(rtParameterHandle("radiance"), 0, 2, 0);
}
static void edit_lights(void) { rtRemoveLight(light); }
static void edit_geometry(void)
{
    rtBindShader(plain);
    rtNewObject(object, RT_DEFINE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
}
static void edit_instance(void)
{
    rtLoadIdentity();
    rtScalef(-1, 1, -1);
    rtUpdateInstance(instance);
}
static void edit_instances(void) { rtDeleteInstance(instance); }
static void edit_camera(void) { rtLookAt(0, 0, -10, 0, 0, 0, 0, 1, 0); }
static void edit_buffer(void) { use_big(1); }
static void edit_remove(void)
{
    rtDeleteShader(plain);
    rtDeleteTexture(texture);
    rtClearInstances();
    rtRemoveObject(object);
}

/* Frame n is unaffected by what follows its start; frame n + 1 shows it. */
static void snapshot(void (*edit)(void), double left, double r, double g, double b)
{
    scene();
    use_big(0);
    rtSetSamplesPerPixel(4);
    memset(big, 0, sizeof big);
    rtStartRendering();
    edit();
    rtEndRendering();
    CHECK(shows(0, -0.5, 0.5, 0.5, 0.5));
    CHECK(shows(0, 0.5, 0.25, 0.5, 0.75));
    CHECK(big[1][BIG / 2][BIG / 2][3] == 0);
    rtRender();
    {
        const int n = edit == edit_buffer;
        CHECK(shows(n, -0.5, left, left, left) || (r == left && shows(n, -0.5, r, g, b)));
        if (!shows(n, 0.5, r, g, b)) {
            printf("the edit does not show: %g %g %g\n", (double)r, (double)g, (double)b);
            failures++;
        }
    }
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
}

static void snapshots(void)
{
    snapshot(edit_texture, 0.875, 0.25, 0.5, 0.75);
    snapshot(edit_shader, 0.5, 1, 0, 0);
    snapshot(edit_light, 0.5, 0, 1, 0);
    snapshot(edit_lights, 0.5, 0, 0, 0);
    snapshot(edit_geometry, 0.25, 0.25, 0.5, 0.75);
    snapshot(edit_instances, 0, 0, 0, 0);
    snapshot(edit_buffer, 0.5, 0.25, 0.5, 0.75);
    snapshot(edit_remove, 0, 0, 0, 0);
    /* Seen from behind left and right are exchanged; the light is on the other side of the wall. */
    scene();
    use_big(0);
    rtStartRendering();
    edit_camera();
    edit_instance();
    rtEndRendering();
    CHECK(shows(0, -0.5, 0.5, 0.5, 0.5));
    rtRender();
    CHECK(shows(0, -0.5, 0.5, 0.5, 0.5));
    rtLookAt(0, 0, 10, 0, 0, 0, 0, 1, 0);
    rtRender();
    CHECK(shows(0, 0.5, 0.5, 0.5, 0.5));
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
}

static void *cancel_soon(void *milliseconds)
{
    const long wait = *(long *)milliseconds;
    struct timespec time;
    time.tv_sec = wait / 1000;
    time.tv_nsec = wait % 1000 * 1000000;
    nanosleep(&time, NULL);
    rtCancelRendering();
    return NULL;
}

/* Who may write where, also when calls fail. */
static void uses(void)
{
    const RTubyte *a = (const RTubyte *)big[0], *b = (const RTubyte *)big[1];
    CHECK(rtFrameBufferUse(a) == 0 && rtFrameBufferUse(NULL) == 0);
    scene();
    use_big(0);
    CHECK(rtFrameBufferUse(a) == RT_NEXT_FRAME_BIT && rtFrameBufferUse(b) == 0);
    rtStartRendering();
    CHECK(rtFrameBufferUse(a) == RT_NEXT_FRAME_BIT + RT_IN_FLIGHT_BIT);
    use_big(1);
    CHECK(rtFrameBufferUse(a) == RT_IN_FLIGHT_BIT && rtFrameBufferUse(b) == RT_NEXT_FRAME_BIT);
    rtCreateObject(RT_DEFINE);
    EXPECT(rtEndRendering(), RT_INVALID_OPERATION);
    CHECK(rtFrameBufferUse(a) == RT_IN_FLIGHT_BIT);
    rtBindShader(plain);
    rtBegin(RT_TRIANGLES);
    rtSetFrameBuffer((RTubyte *)big[0], BIG, BIG, RT_RGBA_32);
    CHECK(rtFrameBufferUse(a) == RT_IN_FLIGHT_BIT && rtFrameBufferUse(b) == RT_NEXT_FRAME_BIT);
    rtEnd();
    rtEndObject();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtEndRendering();
    CHECK(rtFrameBufferUse(a) == 0 && rtFrameBufferUse(b) == RT_NEXT_FRAME_BIT);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
    CHECK(rtFrameBufferUse(b) == 0);
}

static void cancelled(void)
{
    pthread_t thread;
    double start;
    long milliseconds = 20;
    scene();
    EXPECT(rtCancelRendering(), RT_INVALID_OPERATION);
    EXPECT(rtSetSamplesPerPixel(0), RT_INVALID_VALUE);
    use_big(0);
    memset(big, 0, sizeof big);
    /* Hours of work. */
    rtSetSamplesPerPixel(100000000);
    start = seconds();
    rtStartRendering();
    EXPECT(rtCancelRendering(), RT_NO_ERROR);
    EXPECT(rtCancelRendering(), RT_NO_ERROR);
    EXPECT(rtEndRendering(), RT_NO_ERROR);
    CHECK(seconds() - start < 60);
    CHECK(big[0][BIG / 2][BIG - 9][3] == (integer(RT_SAMPLE_COUNT) > 0 ? 1.f : 0.f));
    /* From another thread, while this one waits; what samples there are is shown. */
    start = seconds();
    do {
        milliseconds *= 2;
        pthread_create(&thread, NULL, cancel_soon, &milliseconds);
        EXPECT(rtRender(), RT_NO_ERROR);
        pthread_join(thread, NULL);
    } while (integer(RT_SAMPLE_COUNT) == 0 && milliseconds < 20000);
    CHECK(seconds() - start < 120);
    CHECK(integer(RT_SAMPLE_COUNT) > 0);
    CHECK(shows(0, 0.5, 0.25, 0.5, 0.75));
    /* And then all is as ever. */
    rtSetSamplesPerPixel(1);
    memset(big, 0, sizeof big);
    EXPECT(rtRender(), RT_NO_ERROR);
    CHECK(shows(0, 0.5, 0.25, 0.5, 0.75));
    rtExit();
}

static int samples_of_next(void)
{
    rtRender();
    return integer(RT_SAMPLE_COUNT);
}

/* How far the pixels along the edge of a triangle, which a single sample shows as 0 or 1, are from their coverage. */
static double edge_error(void)
{
    double error = 0;
    int i;
    for (i = 0; i < BIG; i++)
        error += fabs(big[0][i][BIG - 1 - i][0] - 0.5);
    return error / BIG;
}

static void progressive(void)
{
    double one;
    scene();
    use_big(0);
    CHECK(samples_of_next() == 1);
    CHECK(samples_of_next() == 1);
    rtSetSamplesPerPixel(3);
    CHECK(samples_of_next() == 3);
    rtProgressive(RT_TRUE);
    CHECK(samples_of_next() == 3);
    CHECK(samples_of_next() == 6);
    rtSetSamplesPerPixel(2);
    CHECK(samples_of_next() == 8);
    edit_texture();
    CHECK(samples_of_next() == 2);
    CHECK(samples_of_next() == 4);
    edit_shader();
    CHECK(samples_of_next() == 2);
    edit_shader();
    CHECK(samples_of_next() == 4);
    edit_light();
    CHECK(samples_of_next() == 2);
    edit_geometry();
    CHECK(samples_of_next() == 2);
    edit_instance();
    CHECK(samples_of_next() == 2);
    edit_camera();
    CHECK(samples_of_next() == 2);
    edit_lights();
    CHECK(samples_of_next() == 2);
    rtPerspective(50, 0.1, 10);
    CHECK(samples_of_next() == 2);
    rtSetMaxRayRecursionDepth(3);
    CHECK(samples_of_next() == 2);
    rtSetRayEpsilon(1e-3f);
    CHECK(samples_of_next() == 2);
    edit_instances();
    CHECK(samples_of_next() == 2);
    CHECK(samples_of_next() == 4);
    rtSetFrameBuffer((RTubyte *)big, BIG / 2, BIG, RT_RGBA_32);
    CHECK(samples_of_next() == 2);
    rtProgressive(RT_FALSE);
    CHECK(samples_of_next() == 2);
    CHECK(samples_of_next() == 2);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();

    /* The picture becomes smoother: pixels that an edge halves. */
    constant_shader(1, 1, 1);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_TRIANGLES);
    rtVertex3f(-1, -1, 0), rtVertex3f(1, -1, 0), rtVertex3f(-1, 1, 0);
    rtEnd();
    rtEndObject();
    look_at_square();
    use_big(0);
    rtProgressive(RT_TRUE);
    rtRender();
    one = edge_error();
    NEAR(one, 0.5, 1e-6);
    while (integer(RT_SAMPLE_COUNT) < 64)
        rtRender();
    CHECK(edge_error() < 0.05);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
}

static void immediate(void)
{
    int i;
    scene();
    rtSceneMode(RT_IMMEDIATE);
    use_big(0);
    for (i = 0; i < 3; i++) {
        use_big(i % 2);
        memset(big[i % 2], 0, sizeof big[0]);
        rtLoadIdentity();
        if (i > 0) {
            rtUseLight(light);
            rtInstantiateObject(object);
        }
        rtSwapBuffers();
        CHECK(integer(RT_INSTANCE_COUNT) == 0);
        if (i > 0)
            CHECK(shows((i - 1) % 2, 0.5, 0.25, 0.5, 0.75));
    }
    rtEndRendering();
    CHECK(shows(0, 0.5, 0.25, 0.5, 0.75));
    /* Nothing was repeated: nothing is there. */
    rtRender();
    CHECK(shows(0, 0.5, 0, 0, 0));
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
}

static void formats(void)
{
    static const struct {
        RTenum format;
        int channels, is_float, red, alpha;
    } all[] = {
        { RT_BGR_32, 3, 1, 2, -1 }, { RT_RGB_32, 3, 1, 0, -1 }, { RT_RGBA_32, 4, 1, 0, 3 }, { RT_BGRA_32, 4, 1, 2, 3 },
        { RT_RGB_8, 3, 0, 0, -1 }, { RT_RGBA_8, 4, 0, 0, 3 }, { RT_BGR_8, 3, 0, 2, -1 }, { RT_BGRA_8, 4, 0, 2, 3 },
    };
    static RTubyte memory[4 * 4 * 16 + 16];
    unsigned i;
    int x, y, k;
    constant_shader(2, 0.25f, 0.0625f);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 0, 0, 0);
    rtEndObject();
    look_at_square();
    for (i = 0; i < sizeof all / sizeof all[0]; i++) {
        const int channels = all[i].channels, size = channels * (all[i].is_float ? 4 : 1);
        memset(memory, 0xAB, sizeof memory);
        rtSetFrameBuffer(memory, 4, 4, all[i].format);
        rtRender();
        for (y = 0; y < 4; y++)
            for (x = 0; x < 4; x++) {
                const int there = x < 2 && y < 2;
                const RTubyte *pixel = memory + (y * 4 + x) * size;
                for (k = 0; k < channels; k++) {
                    const int channel = k == all[i].alpha ? 3 : k == 1 ? 1 : k == all[i].red ? 0 : 2;
                    const float floats[] = { 2, 0.25f, 0.0625f, 1 };
                    const int bytes[] = { 255, 137, 71, 255 };
                    float value;
                    if (all[i].is_float) {
                        memcpy(&value, pixel + 4 * k, 4);
                        CHECK(value == (there ? floats[channel] : 0));
                    } else
                        CHECK(pixel[k] == (there ? bytes[channel] : 0));
                }
            }
        for (k = 0; k < 16; k++)
            CHECK(memory[16 * size + k] == 0xAB);
    }
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
}

int main(void)
{
    helpers_are_used();
    snapshots();
    uses();
    cancelled();
    progressive();
    immediate();
    formats();
    FINISH();
}
