/* SPDX-License-Identifier: GPL-3.0-or-later
 * What is drawn: matrices, instances, re-definition, shaders and rates, lights, cameras, textures, formats, frames. */
#include "check.h"

static void matrices(void)
{
    RTfloat m[16];
    RTdouble rows[16] = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16 };
    int i;
    rtLoadIdentity();
    rtTranslatef(1, 2, 3);
    rtRotated(90, 0, 0, 5);
    rtScalef(2, 3, 4);
    rtRotatef(77, 0, 0, 0);
    rtGetFloatv(RT_MODELVIEW_MATRIX, m);
    {
        const RTfloat wanted[16] = { 0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 1, 2, 3, 1 };
        for (i = 0; i < 16; i++)
            NEAR(m[i], wanted[i], 1e-6);
    }
    rtLoadTransposeMatrixd(rows);
    rtGetFloatv(RT_MODELVIEW_MATRIX, m);
    CHECK(m[1] == 5 && m[4] == 2 && m[12] == 4);
    rtPushMatrix();
    rtLoadIdentity();
    rtPopMatrix();
    rtGetFloatv(RT_MODELVIEW_MATRIX, m);
    CHECK(m[15] == 16);
    rtLoadIdentity();
}

/* Every family in a few of its types; what is current can be asked. */
static void attributes(void)
{
    const RTubyte bytes[4] = { 255, 0, 51, 102 };
    const RTshort shorts[4] = { 1, -2, 3, 2 };
    const RTdouble doubles[3] = { 0.25, 0.5, 0.75 };
    RTfloat v[4];
    RTint i[4];
    rtColor4ubv(bytes);
    rtGetFloatv(RT_CURRENT_COLOR, v);
    NEAR(v[0], 1, 0); NEAR(v[1], 0, 0); NEAR(v[2], 0.2, 1e-6); NEAR(v[3], 0.4, 1e-6);
    rtGetIntegerv(RT_CURRENT_COLOR, i);
    CHECK(i[0] == 2147483647);
    rtColor3b(127, -128, 0);
    rtGetFloatv(RT_CURRENT_COLOR, v);
    NEAR(v[0], 1, 0); NEAR(v[1], -1, 0); NEAR(v[3], 1, 0);
    rtColor3dv(doubles);
    rtGetFloatv(RT_CURRENT_COLOR, v);
    CHECK(v[0] == 0.25f && v[1] == 0.5f && v[2] == 0.75f && v[3] == 1);
    rtColor3ui(4294967295u, 0, 0);
    rtGetFloatv(RT_CURRENT_COLOR, v);
    CHECK(v[0] == 1);
    rtGetFloatv(RT_CURRENT_NORMAL, v);
    CHECK(v[0] == 0 && v[1] == 0 && v[2] == 1);
    rtNormal4sv(shorts);
    rtGetFloatv(RT_CURRENT_NORMAL, v);
    CHECK(v[0] == 1 && v[1] == -2 && v[2] == 3);
    rtNormal2i(4, 5);
    rtGetFloatv(RT_CURRENT_NORMAL, v);
    CHECK(v[0] == 4 && v[1] == 5 && v[2] == 0);
    rtTexCoord1f(7);
    rtGetFloatv(RT_CURRENT_TEXTURE_COORDS, v);
    CHECK(v[0] == 7 && v[1] == 0 && v[2] == 0 && v[3] == 1);
    rtTexCoord4sv(shorts);
    rtGetFloatv(RT_CURRENT_TEXTURE_COORDS, v);
    CHECK(v[0] == 1 && v[1] == -2 && v[2] == 3 && v[3] == 2);
    rtTexCoord2f(0, 0);
    rtColor3f(1, 1, 1);
    CHECK(strcmp((const char *)rtGetString(RT_RENDERER), "GNU RT") == 0 && integer(RT_MATRIX_MODE) == RT_MODELVIEW);
    /* Homogeneous coordinates are divided. */
    constant_shader(1, 1, 1);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_QUADS);
    rtVertex4s(0, 0, 0, 2); rtVertex4s(2, 0, 0, 2); rtVertex4sv(shorts); rtVertex4i(0, 2, 0, 2);
    rtEnd();
    rtEndObject();
    rtClearInstances();
}

/* Objects in objects: placed by both matrices, masked, defined before or after, and none in itself. */
static void objects_in_objects(void)
{
    RTuint tile = rtGenObjects(1), pair = rtGenObjects(1), four = rtGenObjects(1), shown, chain, i;
    rtClearInstances();
    constant_shader(1, 0, 0);
    rtNewObject(tile, RT_DEFINE);
    rectangle(-0.1f, -0.1f, 0.1f, 0.1f, 0);
    rtEndObject();
    rtNewObject(four, RT_DEFINE);
    rtTranslatef(0, 0.5f, 0); rtNestObject(pair, ~0u); rtLoadIdentity();
    rtTranslatef(0, -0.5f, 0); rtNestObject(pair, ~0u); rtLoadIdentity();
    shown = rtInstantiateObject(four);
    rtRender();
    SHOWS(0.5, 0.5, 0, 0, 0);
    rtNewObject(pair, RT_DEFINE);
    rtTranslatef(-0.5f, 0, 0); rtNestObject(tile, ~0u); rtLoadIdentity();
    rtTranslatef(0.5f, 0, 0); rtNestObject(tile, 2); rtLoadIdentity();
    rectangle(-0.1f, -0.1f, 0.1f, 0.1f, 0);
    rtEndObject();
    CHECK(rtGetError() == RT_NO_ERROR);
    rtRender();
    SHOWS(-0.5, 0.5, 1, 0, 0); SHOWS(-0.5, -0.5, 1, 0, 0); SHOWS(0, 0.5, 1, 0, 0); SHOWS(0.5, 0.5, 0, 0, 0); SHOWS(0, 0, 0, 0, 0);
    /* An update moves what is in it; other objects are none. */
    rtNewObject(pair, RT_UPDATE);
    rtTranslatef(-0.3f, 0, 0); rtNestObject(tile, ~0u); rtLoadIdentity();
    rtTranslatef(0.5f, 0, 0); rtNestObject(tile, ~0u); rtLoadIdentity();
    rectangle(-0.1f, -0.1f, 0.1f, 0.1f, 0);
    rtEndObject();
    CHECK(rtGetError() == RT_NO_ERROR);
    rtRemoveObject(tile);
    rtRender();
    SHOWS(-0.5, 0.5, 0, 0, 0); SHOWS(-0.3, 0.5, 1, 0, 0); SHOWS(0.5, -0.5, 1, 0, 0);
    rtNewObject(pair, RT_UPDATE);
    rectangle(-0.1f, -0.1f, 0.1f, 0.1f, 0);
    rtEndObject();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtNewObject(pair, RT_DEFINE);
    rtNestObject(four, ~0u);
    rtEndObject();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtRender();
    SHOWS(-0.3, 0.5, 1, 0, 0);
    /* Sixteen matrices on the way are fine, seventeen are not. */
    for (chain = four, i = 0; i < 13; i++) {
        RTuint outer = rtGenObjects(1);
        rtNewObject(outer, RT_DEFINE);
        rtNestObject(chain, ~0u);
        rtEndObject();
        chain = outer;
    }
    CHECK(rtGetError() == RT_NO_ERROR);
    rtNewObject(RT_DEFINE);
    rtNestObject(chain, ~0u);
    rtEndObject();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtDeleteInstance(shown);
    shown = rtInstantiateObject(chain);
    rtRender();
    SHOWS(-0.3, -0.5, 1, 0, 0);
    rtDeleteInstance(shown);
}

static void instances_and_objects(void)
{
    RTuint red = constant_shader(1, 0, 0), object = rtGenObjects(1), a, b, handle = rtParameterHandle("value");
    RTfloat m[16];
    CHECK(rtIsObject(object));
    rtNewObject(object, RT_COMPILE);
    rectangle(-0.2f, -0.2f, 0.2f, 0.2f, 0);
    rtTranslatef(-0.5f, 0, 0);
    a = rtInstantiateObject(object);
    rtLoadIdentity();
    rtTranslatef(0.5f, 0, 0);
    b = rtInstantiateObject(object);
    CHECK(a != b && rtIsInstance(a) && rtIsInstance(b));
    rtRender();
    SHOWS(-0.5, 0, 1, 0, 0); SHOWS(0.5, 0, 1, 0, 0); SHOWS(0, 0, 0, 0, 0);
    /* Move one, and read its matrix back. */
    rtLoadIdentity();
    rtTranslatef(0, 0.5f, 0);
    rtUpdateInstance(b);
    rtGetInstanceMatrixf(b, m);
    CHECK(m[12] == 0 && m[13] == 0.5f);
    rtLoadIdentity();
    rtRender();
    SHOWS(0.5, 0, 0, 0, 0); SHOWS(0, 0.5, 1, 0, 0);
    /* A mask hides it from the camera, then from nobody. */
    rtInstanceMask(b, 2 | 4);
    rtRender();
    SHOWS(0.5, 0, 0, 0, 0); SHOWS(0, 0.5, 0, 0, 0);
    rtInstanceMask(b, ~0u);
    rtRender();
    SHOWS(0, 0.5, 1, 0, 0);
    /* A parameter recolours what is there; a new definition and an update show in all instances. */
    rtParameter3f(handle, 0, 2, 0);
    rtNewObject(object, RT_DEFINE);
    rectangle(-0.2f, -0.2f, 0.2f, 0.2f, 0);
    rectangle(0.3f, -0.2f, 0.7f, 0.2f, 0);
    rtEndObject();
    rtRender();
    SHOWS(-0.5, 0, 0, 2, 0); SHOWS(0, 0, 0, 2, 0); SHOWS(0.5, 0.5, 0, 2, 0);
    rtNewObject(object, RT_UPDATE);
    rectangle(-0.2f, -0.2f, 0.2f, 0.2f, 0);
    rectangle(-0.5f, -0.2f, -0.3f, 0.2f, 0);
    rtEndObject();
    rtRender();
    SHOWS(0.5, 0.5, 0, 0, 0); SHOWS(-0.4, 0.5, 0, 2, 0);
    /* Instances keep the geometry of a removed object, and of a deleted shader. */
    rtRemoveObject(object);
    rtDeleteShader(red);
    CHECK(!rtIsObject(object));
    rtRender();
    SHOWS(-0.5, 0, 0, 2, 0);
    rtDeleteInstance(a);
    rtRender();
    SHOWS(-0.5, 0, 0, 0, 0); SHOWS(0, 0.5, 0, 2, 0);
    rtClearInstances();
    rtRender();
    CHECK(covered() == 0 && integer(RT_INSTANCE_COUNT) == 0);
    /* Immediate mode: one frame, then nothing. */
    constant_shader(1, 1, 0);
    rtSceneMode(RT_IMMEDIATE);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    rtRender();
    CHECK(covered() == WIDTH * HEIGHT);
    rtRender();
    CHECK(covered() == 0);
    rtSceneMode(RT_RETAINED);
}

static void rates(void)
{
    RTuint triangle, vertex;
    RTfloat value[3];
    rtGenNewShaderClass("sample", NULL);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("shader_color"), 0.3f, 0, 0);
    triangle = rtParameterHandle("triangle_color"), vertex = rtParameterHandle("vertex_color");
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtGetParameterfv(triangle, value);
    CHECK(value[0] == 1 && value[1] == 1 && value[2] == 1);
    rtParameter3f(triangle, 0, 0.3f, 0);
    rtBegin(RT_QUADS);
    rtParameter3f(vertex, 0, 0, 0);
    rtVertex2f(-1, -1); rtVertex2f(1, -1);
    rtParameter3f(vertex, 0, 0, 3);
    rtVertex2f(1, 1); rtVertex2f(-1, 1);
    rtEnd();
    rtEndObject();
    rtRender();
    /* No light: seen head-on the colour is the mean; blue rises from below to above. */
    SHOWS(0.01, 0.01, 0.1, 0.1, 8.5 / 16);
    SHOWS(-0.99, -0.99, 0.1, 0.1, 0.5 / 16);
    SHOWS(0.99, 0.99, 0.1, 0.1, 15.5 / 16);
    rtClearInstances();
}

static void lights_and_mirrors(void)
{
    RTuint spot, sun, mirror, environment;
    rtGenNewShaderClass("SpotLightShader", NULL);
    spot = rtGenNewShader();
    rtParameter3f(rtParameterHandle("radiance"), 4, 4, 4);
    rtParameter3f(rtParameterHandle("position"), 1.0f / WIDTH, 1.0f / HEIGHT, 2);
    rtUseLight(spot);
    rtGenNewShaderClass("DiffuseShader", NULL);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("color"), 1, 0.5f, 0);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    rtRender();
    SHOWS(0.01, 0.01, 1, 0.5, 0);
    /* Deleted but in use: it goes on shining; a second one adds up. */
    rtDeleteShader(spot);
    rtGenNewShaderClass("InfiniteLightShader", NULL);
    sun = rtGenNewShader();
    rtParameter3f(rtParameterHandle("direction"), 0, 0, 7);
    rtUseLightFast(sun);
    rtUseLightFast(sun);
    rtRender();
    SHOWS(0.01, 0.01, 3, 1.5, 0);
    rtRemoveLight(sun);
    rtRemoveLight(spot);
    rtRender();
    SHOWS(0.01, 0.01, 0, 0, 0);
    /* A given normal is not turned: from behind, this light does not count. */
    rtUseLight(sun);
    rtGenNewShaderClass("DiffuseShader", NULL);
    rtGenNewShader();
    rtClearInstances();
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtNormal3f(0, 0, -1);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    rtRender();
    SHOWS(0, 0, 0, 0, 0);
    CHECK(covered() == WIDTH * HEIGHT);
    /* Shadows: TexturedDiffuseShader has them, DiffuseShader does not. */
    rtClearInstances();
    rtGenNewShaderClass("TexturedDiffuseShader", NULL);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("radiance"), 0.25f, 0.25f, 0.25f);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtTranslatef(0, 0, 11);
    rectangle(0, -1, 1, 1, 0);
    rtLoadIdentity();
    rtEndObject();
    rtRender();
    SHOWS(-0.5, 0, 1.25, 1.25, 1.25);
    SHOWS(0.5, 0, 0.25, 0.25, 0.25);
    rtRemoveLight(sun);
    /* A mirror sees the environment, attenuated; beyond the depth limit too. */
    rtClearInstances();
    rtGenNewShaderClass("ConstantEnvironmentShader", NULL);
    environment = rtGenNewShader();
    rtParameter3f(rtParameterHandle("value"), 0, 0, 4);
    rtUseEnvironmentShader(environment);
    rtGenNewShaderClass("MirrorShader", NULL);
    mirror = rtGenNewShader();
    rtParameter1f(rtParameterHandle("attenuation"), 0.5f);
    CHECK(rtIsShader(mirror));
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 0, 1, 0);
    rtEndObject();
    rtRender();
    SHOWS(-0.5, 0, 0, 0, 2); SHOWS(0.5, 0, 0, 0, 4);
    CHECK(at(-0.5, 0)[3] == 1 && at(0.5, 0)[3] == 0);
    rtParameter1f(rtParameterHandle("attenuation"), 1);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 20);
    rtEndObject();
    rtRender();
    SHOWS(-0.5, 0, 0, 0, 4);
    rtClearInstances();
    rtParameter3f(rtParameterHandle("value"), 0, 0, 0);
    rtGetError();
    rtBindShader(environment);
    rtParameter3f(rtParameterHandle("value"), 0, 0, 0);
}

static void textures(void)
{
    const RTubyte texels[12] = { 255, 0, 0, 0, 255, 0, 0, 0, 255, 51, 51, 51 };
    RTuint texture = rtGenTextures(1), handle;
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, 2, 2, 0, RT_RGB, RT_UNSIGNED_BYTE, texels);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER, RT_NEAREST);
    rtGenNewShaderClass("TextureShader", NULL);
    rtGenNewShader();
    handle = rtParameterHandle("texture");
    rtParameter1i(handle, (RTint)texture);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtBegin(RT_QUADS);
    rtTexCoord2f(0, 0); rtVertex2f(-1, -1);
    rtTexCoord2f(1, 0); rtVertex2f(1, -1);
    rtTexCoord2f(1, 1); rtVertex2f(1, 1);
    rtTexCoord2f(0, 1); rtVertex2f(-1, 1);
    rtEnd();
    rtEndObject();
    rtRender();
    /* The first row is below; bytes are linear. */
    SHOWS(-0.5, -0.5, 1, 0, 0); SHOWS(0.5, -0.5, 0, 1, 0); SHOWS(-0.5, 0.5, 0, 0, 1); SHOWS(0.5, 0.5, 0.2, 0.2, 0.2);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER, RT_LINEAR);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_S, RT_CLAMP);
    rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_T, RT_CLAMP_TO_EDGE);
    rtRender();
    SHOWS(-0.95, -0.95, 1, 0, 0);
    CHECK(at(0.01, -0.95)[0] > 0.3f && at(0.01, -0.95)[1] > 0.3f);
    /* A deleted texture, and none, are white. */
    rtDeleteTexture(texture);
    rtRender();
    SHOWS(-0.5, -0.5, 1, 1, 1);
    rtClearInstances();
}

static void camera_and_formats(void)
{
    static RTubyte bytes[2][2][4];
    static RTfloat bgr[2][2][3];
    RTuint camera;
    rtGenNewShaderClass("PinholeCameraShader", NULL);
    camera = rtGenNewShader();
    rtParameter3f(rtParameterHandle("origin"), 0, 0, 2);
    rtParameter3f(rtParameterHandle("lowerLeft"), -1, -1, -2);
    rtParameter3f(rtParameterHandle("vertical"), 0, 2, 0);
    rtParameter3f(rtParameterHandle("horizontal"), 2, 0, 0);
    rtUseCamera(camera);
    constant_shader(0.2158605f, 2, 0);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(0, -1, 1, 0, 0);
    rtEndObject();
    rtRender();
    SHOWS(0.5, -0.5, 0.2158605, 2, 0); SHOWS(0.5, 0.5, 0, 0, 0); SHOWS(-0.5, -0.5, 0, 0, 0);
    CHECK(covered() == WIDTH * HEIGHT / 4);
    rtSetFrameBuffer(&bytes[0][0][0], 2, 2, RT_BGRA_8);
    rtRender();
    CHECK(bytes[0][1][0] == 0 && bytes[0][1][1] == 255 && bytes[0][1][2] == 128 && bytes[0][1][3] == 255);
    CHECK(bytes[1][0][3] == 0);
    rtSetFrameBuffer((RTubyte *)bgr, 2, 2, RT_BGR_32);
    rtRender();
    CHECK(bgr[0][1][1] == 2 && bgr[0][1][0] == 0);
    NEAR(bgr[0][1][2], 0.2158605, 1e-6);
    use_frame();
}

static void frames_in_flight(void)
{
    static float second[HEIGHT][WIDTH][4];
    RTuint shader = constant_shader(1, 0, 0), handle = rtParameterHandle("value");
    rtClearInstances();
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-1, -1, 1, 1, 0);
    rtEndObject();
    rtStartRendering();
    /* Edits and a new buffer are for the next frame. */
    rtParameter3f(handle, 0, 1, 0);
    rtClearInstances();
    rtSetFrameBuffer((RTubyte *)second, WIDTH, HEIGHT, RT_RGBA_32);
    rtEndRendering();
    SHOWS(0, 0, 1, 0, 0);
    rtRender();
    CHECK(second[8][8][3] == 0);
    SHOWS(0, 0, 1, 0, 0);
    /* Geometry outside of objects is there for one frame. */
    use_frame();
    rtBindShader(shader);
    rectangle(-1, -1, 1, 1, 0);
    rtSwapBuffers();
    rtSwapBuffers();
    SHOWS(0, 0, 0, 1, 0);
    rtEndRendering();
    CHECK(covered() == 0);
}

int main(void)
{
    helpers_are_used();
    use_frame();
    look_at_square();
    matrices();
    attributes();
    instances_and_objects();
    objects_in_objects();
    rates();
    lights_and_mirrors();
    textures();
    camera_and_formats();
    frames_in_flight();
    FINISH();
}
