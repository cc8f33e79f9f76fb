/* SPDX-License-Identifier: GPL-3.0-or-later
 * Every error of every call, function by function; and that a call that fails changes nothing. */
#include "check.h"

#define IO RT_INVALID_OPERATION
#define IV RT_INVALID_VALUE
#define IE RT_INVALID_ENUM
#define OK RT_NO_ERROR
#define NOBODY 12345u

static RTuint surface, light, camera, environment, object, instance, texture, handle, class_id;
static RTfloat floats[16];
static RTdouble doubles[16];
static RTint ints[16];

/* Calls that are not legal between rtBegin and rtEnd; each must give IO there whatever its arguments are. */
#define BE(call) \
    do { \
        rtBegin(RT_TRIANGLES); \
        (void)(call); \
        rtEnd(); \
        if (rtGetError() != IO) { \
            printf("%s:%d: not IO between rtBegin and rtEnd: %s\n", __FILE__, __LINE__, #call); \
            failures++; \
        } \
    } while (0)
#define BE_ID(call) \
    do { \
        RTuint inside_; \
        BE(inside_ = (call)); \
        CHECK(inside_ == RT_INVALID); \
    } while (0)

static void between_begin_and_end(void)
{
    rtBindShader(surface);
    BE(rtInit(NULL, NULL)); BE(rtExit()); BE(rtGetString(RT_VENDOR)); BE(rtGetIntegerv(RT_MATRIX_MODE, ints));
    BE(rtGetFloatv(RT_CURRENT_COLOR, floats)); BE(rtIsObject(object)); BE(rtIsInstance(instance));
    BE(rtIsShader(surface)); BE(rtIsTexture(texture));
    BE(rtSetFrameBuffer((RTubyte *)frame, 1, 1, RT_RGBA_32)); BE(rtSetFrameBuffer(NULL, 0, 0, 0));
    BE(rtStartRendering()); BE(rtEndRendering()); BE(rtRender()); BE(rtRenderFrame()); BE(rtSwapBuffers());
    BE(rtSceneMode(RT_RETAINED)); BE(rtSetMaxRayRecursionDepth(3)); BE(rtSetRayEpsilon(1)); BE(rtGetRayEpsilon());
    BE(rtMatrixMode(RT_MODELVIEW)); BE(rtLoadIdentity()); BE(rtScalef(1, 1, 1)); BE(rtScaled(1, 1, 1));
    BE(rtTranslatef(0, 0, 0)); BE(rtTranslated(0, 0, 0)); BE(rtRotatef(0, 1, 0, 0)); BE(rtRotated(0, 1, 0, 0));
    BE(rtLoadMatrixf(floats)); BE(rtLoadMatrixd(doubles)); BE(rtMultMatrixf(floats)); BE(rtMultMatrixd(doubles));
    BE(rtLoadTransposeMatrixf(floats)); BE(rtLoadTransposeMatrixd(doubles)); BE(rtMultTransposeMatrixf(floats));
    BE(rtMultTransposeMatrixd(doubles)); BE(rtLoadMatrixf(NULL)); BE(rtPushMatrix()); BE(rtPopMatrix());
    BE_ID(rtGenObjects(1)); BE_ID(rtNewObject(object, RT_DEFINE)); BE_ID(rtNewObject(RT_DEFINE));
    BE_ID(rtCreateObject(RT_DEFINE)); BE(rtEndObject()); BE_ID(rtInstantiateObject(object)); BE(rtRemoveObject(object));
    BE(rtNestObject(object, 1)); BE(rtUpdateInstance(instance)); BE(rtInstanceMask(instance, 1)); BE(rtDeleteInstance(instance)); BE(rtClearInstances());
    BE(rtGetInstanceMatrixf(instance, floats)); BE(rtBegin(RT_QUADS)); BE(rtBegin(0));
    BE_ID(rtGenNewShaderClass("sample", NULL)); BE(rtBindShaderClass(class_id)); BE_ID(rtGenNewShader());
    BE(rtBindShader(surface)); BE_ID(rtParameterHandle("value")); BE(rtGetParameterfv(handle, floats));
    BE(rtDeleteShader(surface)); BE(rtGetShaderClassInfoLog()); BE_ID(rtGenTextures(1));
    BE(rtBindTexture(RT_TEXTURE_2D, texture)); BE(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_S, RT_REPEAT));
    BE(rtTexImage2D(RT_TEXTURE_2D, 0, 3, 1, 1, 0, RT_RGB, RT_UNSIGNED_BYTE, floats)); BE(rtDeleteTexture(texture));
    BE(rtUseLight(light)); BE(rtUseLightFast(light)); BE(rtRemoveLight(light)); BE(rtUseCamera(camera));
    BE(rtUseEnvironmentShader(environment)); BE(rtUseRenderingObject(surface));
    BE(rtLookAt(0, 0, 1, 0, 0, 0, 0, 1, 0)); BE(rtPerspective(60, 1, 2)); BE(rtFrustum(-1, 1, -1, 1, 1, 2));
    BE(rtOrtho(-1, 1, -1, 1, 1, 2));
    /* All of it had no effect. */
    CHECK(rtIsObject(object) && rtIsInstance(instance) && rtIsShader(surface) && rtIsTexture(texture));
    CHECK(integer(RT_INSTANCE_COUNT) == 1);

    /* rtGetError itself: no error is told inside, one is noted. */
    rtBegin(RT_TRIANGLES);
    CHECK(rtGetError() == OK);
    rtEnd();
    CHECK(rtGetError() == IO);

    /* Legal inside. */
    rtBegin(RT_TRIANGLES);
    rtNormal3f(0, 0, 1); rtTexCoord2f(0, 0); rtColor3f(1, 1, 1); rtParameter3f(handle, 1, 1, 1);
    rtParameter3fv(handle, floats); rtParameterRaw(handle, floats, 12); rtVertex3f(0, 0, 0);
    rtEnd();
    CHECK(rtGetError() == OK);
}

static void general_rules(void)
{
    /* The first error stays, and is cleared when read. */
    rtBegin(77);
    rtBindShader(NOBODY);
    rtPopMatrix();
    CHECK(rtGetError() == IE);
    CHECK(rtGetError() == OK);
    EXPECT(rtInit(NULL, NULL), IO);
    /* Order: null pointers, constants, ids, state. */
    EXPECT(rtTexImage2D(0, 0, 3, 1, 1, 0, 0, 0, NULL), IV);
    EXPECT(rtSetFrameBuffer(NULL, 1, 1, 0), IV);
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 0, 1, 0), IE);
    EXPECT(rtGetFloatv(0, NULL), IV);
    EXPECT_ID(rtNewObject(NOBODY, 0), IE);
    EXPECT(rtBindTexture(0, NOBODY), IE);
    EXPECT(rtVertex3fv(NULL), IV);
    EXPECT(rtParameter3fv(NOBODY, NULL), IV);
}

static void queries(void)
{
    EXPECT(rtGetString(0), IE); EXPECT(rtGetIntegerv(0, ints), IE); EXPECT(rtGetFloatv(0, floats), IE);
    EXPECT(rtGetIntegerv(RT_MATRIX_MODE, NULL), IV);
    CHECK(!rtIsObject(0) && !rtIsInstance(0) && !rtIsShader(0) && !rtIsTexture(0) && !rtIsObject(NOBODY));
}

static void frames(void)
{
    EXPECT(rtRender(), IO); EXPECT(rtStartRendering(), IO); EXPECT(rtSwapBuffers(), IO); EXPECT(rtEndRendering(), IO);
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 1, 1, 0x304), IE);
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 0, 1, RT_RGBA_32), IV);
    EXPECT(rtSetFrameBuffer((RTubyte *)frame, 1, 0, RT_RGBA_32), IV);
    EXPECT(use_frame(), OK);
    EXPECT(rtStartRendering(), OK); EXPECT(rtStartRendering(), IO); EXPECT(rtEndRendering(), OK);
    EXPECT(rtEndRendering(), IO);
    EXPECT(rtSwapBuffers(), OK); EXPECT(rtStartRendering(), IO); EXPECT(rtSwapBuffers(), OK); EXPECT(rtRender(), OK);
    EXPECT(rtEndRendering(), IO);
    rtCreateObject(RT_DEFINE);
    EXPECT(rtStartRendering(), IO); EXPECT(rtEndRendering(), IO); EXPECT(rtRender(), IO); EXPECT(rtRenderFrame(), IO);
    EXPECT(rtSwapBuffers(), IO);
    rtEndObject();
    EXPECT(rtSceneMode(0x602), IE); EXPECT(rtSetRayEpsilon(-1), IV); EXPECT(rtSetRayEpsilon(NAN), IV);
    EXPECT(rtSetMaxRayRecursionDepth((RTuint)-1), IV);
    NEAR(rtGetRayEpsilon(), 1e-4, 1e-9);
}

static void matrices(void)
{
    int i;
    EXPECT(rtMatrixMode(0x1703), IE);
    EXPECT(rtLoadMatrixf(NULL), IV); EXPECT(rtLoadMatrixd(NULL), IV); EXPECT(rtMultMatrixf(NULL), IV);
    EXPECT(rtMultMatrixd(NULL), IV); EXPECT(rtLoadTransposeMatrixf(NULL), IV); EXPECT(rtLoadTransposeMatrixd(NULL), IV);
    EXPECT(rtMultTransposeMatrixf(NULL), IV); EXPECT(rtMultTransposeMatrixd(NULL), IV);
    for (i = 0; i < 3; i++) {
        int pushes;
        rtMatrixMode(RT_MODELVIEW + i);
        EXPECT(rtPopMatrix(), RT_STACK_UNDERFLOW);
        for (pushes = 0; pushes < 1023; pushes++)
            rtPushMatrix();
        EXPECT(rtPushMatrix(), RT_STACK_OVERFLOW);
        for (pushes = 0; pushes < 1023; pushes++)
            rtPopMatrix();
        EXPECT(rtPopMatrix(), RT_STACK_UNDERFLOW);
    }
    rtMatrixMode(RT_MODELVIEW);
    EXPECT(rtLookAt(1, 2, 3, 1, 2, 3, 0, 1, 0), IV); EXPECT(rtPerspective(0, 1, 2), IV);
    EXPECT(rtPerspective(180, 1, 2), IV); EXPECT(rtPerspective(60, -1, -2), OK);
    EXPECT(rtFrustum(-1, 1, -1, 1, 0, 1), IV); EXPECT(rtFrustum(1, 1, -1, 1, 1, 2), IV);
    EXPECT(rtOrtho(-1, 1, 1, 1, 0, 1), IV); EXPECT(rtOrtho(-1, 1, -1, 1, 2, 2), IV);
}

static void objects(void)
{
    RTuint opened, other = rtGenObjects(1);
    EXPECT_ID(rtGenObjects(0), IV); EXPECT_ID(rtGenObjects(-1), IV); EXPECT_ID(rtNewObject(other, 0x203), IE);
    EXPECT_ID(rtNewObject(0x100u), IE); EXPECT_ID(rtNewObject(NOBODY, RT_DEFINE), IV);
    EXPECT_ID(rtNewObject(0, RT_DEFINE), IV); EXPECT(rtEndObject(), IO); EXPECT_ID(rtInstantiateObject(NOBODY), IV);
    EXPECT(rtRemoveObject(NOBODY), IV); EXPECT(rtUpdateInstance(NOBODY), IV); EXPECT(rtNestObject(other, 1), IO); EXPECT(rtInstanceMask(NOBODY, 1), IV); EXPECT(rtDeleteInstance(NOBODY), IV);
    EXPECT(rtGetInstanceMatrixf(NOBODY, floats), IV); EXPECT(rtGetInstanceMatrixf(instance, NULL), IV);
    EXPECT_ID(opened = rtNewObject(RT_DEFINE), OK);
    EXPECT(rtNestObject(NOBODY, 1), IV); EXPECT(rtNestObject(opened, 1), IO);
    EXPECT_ID(rtGenObjects(1), IO); EXPECT_ID(rtNewObject(other, RT_DEFINE), IO); EXPECT_ID(rtNewObject(RT_DEFINE), IO);
    EXPECT_ID(rtNewObject(NOBODY, 0), IO); EXPECT_ID(rtInstantiateObject(other), IO);
    EXPECT_ID(rtInstantiateObject(NOBODY), IO); EXPECT(rtRemoveObject(other), IO); EXPECT(rtRemoveObject(NOBODY), IO);
    EXPECT_ID(rtInstantiateObject(opened), OK);
    EXPECT(rtEndObject(), IO);
    EXPECT(rtRemoveObject(other), OK); EXPECT(rtRemoveObject(other), IV); EXPECT_ID(rtNewObject(other, RT_DEFINE), IV);
    EXPECT_ID(rtInstantiateObject(other), IV);
    /* An update with another number of vertices closes the object and keeps the geometry. */
    rtBindShader(surface);
    opened = rtNewObject(RT_DEFINE); rectangle(0, 0, 1, 1, 0); rtEndObject();
    {
        const int triangles = integer(RT_TRIANGLE_COUNT);
        EXPECT_ID(rtNewObject(opened, RT_UPDATE), OK); rectangle(0, 0, 2, 2, 0); EXPECT(rtEndObject(), OK);
        EXPECT_ID(rtNewObject(opened, RT_UPDATE), OK); EXPECT(rtEndObject(), IO); EXPECT(rtEndObject(), IO);
        CHECK(integer(RT_TRIANGLE_COUNT) == triangles);
    }
    EXPECT(rtDeleteInstance(instance), OK); EXPECT(rtDeleteInstance(instance), IV);
    /* Geometry. */
    EXPECT(rtBegin(0x106), IE); EXPECT(rtEnd(), IO); EXPECT(rtVertex3f(0, 0, 0), IO); EXPECT(rtVertex2sv(NULL), IV);
    EXPECT(rtNormal3fv(NULL), IV); EXPECT(rtTexCoord1dv(NULL), IV); EXPECT(rtColor4ubv(NULL), IV);
    EXPECT(rtNormal3f(0, 0, 1), OK); EXPECT(rtTexCoord2f(0, 0), OK); EXPECT(rtColor3f(1, 1, 1), OK);
    rtBindShaderClass(class_id);
    rtBegin(RT_TRIANGLES); rtVertex3f(0, 0, 0); rtEnd(); CHECK(rtGetError() == IO);
    rtBindShader(light);
    rtBegin(RT_TRIANGLES); rtVertex3f(0, 0, 0); rtEnd(); CHECK(rtGetError() == IO);
}

static void shaders(void)
{
    RTuint shader, tcolor, texture_handle;
    EXPECT_ID(rtGenNewShaderClass(NULL, NULL), IV); EXPECT_ID(rtGenNewShaderClass("no such class", NULL), IV);
    CHECK(strstr(rtGetShaderClassInfoLog(), "no such class") != NULL);
    EXPECT_ID(rtGenNewShaderClass("sample", "missing.so"), IV);
    CHECK(strstr(rtGetShaderClassInfoLog(), "missing.so") != NULL);
    EXPECT_ID(rtGenNewShaderClass("ConstantShader", ""), OK); CHECK(rtGetShaderClassInfoLog()[0] == 0);
    EXPECT(rtBindShaderClass(NOBODY), IO); EXPECT(rtBindShaderClass(0), IO); EXPECT(rtBindShader(NOBODY), IO);
    EXPECT_ID(rtParameterHandle(NULL), IV); EXPECT_ID(rtParameterHandle("nothing"), IV);
    /* No shader of the class is bound. */
    EXPECT(rtParameter3f(handle, 1, 1, 1), IO); EXPECT(rtGetParameterfv(handle, floats), IO);
    EXPECT_ID(shader = rtGenNewShader(), OK);
    EXPECT(rtParameter3f(handle, 1, 1, 1), OK); EXPECT(rtParameter3f(NOBODY, 1, 1, 1), IV);
    EXPECT(rtParameter3f(0, 1, 1, 1), IV); EXPECT(rtParameter3fv(handle, NULL), IV); EXPECT(rtParameter1f(handle, 1), IO);
    EXPECT(rtParameter2f(handle, 1, 1), IO); EXPECT(rtParameter4f(handle, 1, 1, 1, 1), IO);
    EXPECT(rtParameter16f(handle, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1), IO);
    EXPECT(rtParameter1fv(handle, floats), IO); EXPECT(rtParameter2fv(handle, floats), IO);
    EXPECT(rtParameter4fv(handle, floats), IO); EXPECT(rtParameter16fv(handle, floats), IO);
    EXPECT(rtParameter1i(handle, 1), IO); EXPECT(rtParameter2i(handle, 1, 1), IO); EXPECT(rtParameter3i(handle, 1, 1, 1), IO);
    EXPECT(rtParameter4i(handle, 1, 1, 1, 1), IO); EXPECT(rtParameter3iv(handle, ints), IO);
    EXPECT(rtParameter2iv(handle, NULL), IV); EXPECT(rtParameter4iv(handle, NULL), IV); EXPECT(rtParameter1d(handle, 1), IO);
    EXPECT(rtParameterRaw(handle, floats, 12), OK); EXPECT(rtParameterRaw(handle, floats, 8), IO);
    EXPECT(rtParameterRaw(handle, NULL, 12), IV); EXPECT(rtParameterString(handle, "x"), IO);
    EXPECT(rtParameterString(handle, NULL), IV); EXPECT(rtGetParameterfv(handle, NULL), IV);
    EXPECT(rtGetParameterfv(NOBODY, floats), IV); EXPECT(rtGetParameterfv(handle, floats), OK);
    EXPECT(rtDeleteShader(NOBODY), IV); EXPECT(rtDeleteShader(shader), OK); EXPECT(rtDeleteShader(shader), IV);
    CHECK(!rtIsShader(shader)); EXPECT(rtBindShader(shader), IO); EXPECT(rtParameter3f(handle, 1, 1, 1), IO);
    /* Another class is bound; per-triangle values need the class only. */
    rtGenNewShaderClass("sample", NULL);
    EXPECT(rtParameter3f(handle, 1, 1, 1), IO);
    EXPECT_ID(tcolor = rtParameterHandle("triangle_color"), OK); EXPECT(rtParameter3f(tcolor, 1, 1, 1), OK);
    EXPECT(rtParameter2f(tcolor, 1, 1), IO);
    rtGenNewShaderClass("TextureShader", NULL); rtGenNewShader(); texture_handle = rtParameterHandle("texture");
    EXPECT(rtParameter1i(texture_handle, 1), OK); EXPECT(rtParameter1f(texture_handle, 1), IO);
    EXPECT(rtParameter2i(texture_handle, 1, 1), IO);
}

static void textures(void)
{
#define IMAGE(target, level, internal, w, h, border, format, type) \
    rtTexImage2D(target, level, internal, w, h, border, format, type, floats)
    EXPECT_ID(rtGenTextures(0), IV); EXPECT(rtBindTexture(0, texture), IE); EXPECT(rtBindTexture(RT_TEXTURE_2D, NOBODY), IV);
    EXPECT(rtBindTexture(RT_TEXTURE_2D, 0), OK);
    EXPECT(IMAGE(RT_TEXTURE_2D, 0, 3, 1, 1, 0, RT_RGB, RT_FLOAT), IO);
    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_S, RT_REPEAT), IO);
    EXPECT(rtBindTexture(RT_TEXTURE_2D, texture), OK);
    EXPECT(IMAGE(RT_TEXTURE_2D, 0, 3, 1, 1, 0, RT_RGB, RT_FLOAT), OK);
    EXPECT(rtTexImage2D(RT_TEXTURE_2D, 0, 3, 1, 1, 0, RT_RGB, RT_FLOAT, NULL), IV);
    EXPECT(IMAGE(0, 0, 3, 1, 1, 0, RT_RGB, RT_FLOAT), IE); EXPECT(IMAGE(RT_TEXTURE_2D, 0, 3, 1, 1, 0, 0, RT_FLOAT), IE);
    EXPECT(IMAGE(RT_TEXTURE_2D, 0, 3, 1, 1, 0, RT_RGB, RT_STRING), IE);
    EXPECT(IMAGE(RT_TEXTURE_2D, -1, 3, 1, 1, 0, RT_RGB, RT_FLOAT), IV);
    EXPECT(IMAGE(RT_TEXTURE_2D, 0, 7, 1, 1, 0, RT_RGB, RT_FLOAT), IV);
    EXPECT(IMAGE(RT_TEXTURE_2D, 0, 3, -1, 1, 0, RT_RGB, RT_FLOAT), IV);
    EXPECT(IMAGE(RT_TEXTURE_2D, 0, 3, 1, 1 << 20, 0, RT_RGB, RT_FLOAT), IV);
    EXPECT(IMAGE(RT_TEXTURE_2D, 0, 3, 1, 1, 1, RT_RGB, RT_FLOAT), IV);
    EXPECT(rtTexParameteri(0, RT_TEXTURE_WRAP_S, RT_REPEAT), IE); EXPECT(rtTexParameteri(RT_TEXTURE_2D, 0, RT_REPEAT), IE);
    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_S, RT_LINEAR), IE);
    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER, -1), IE);
    EXPECT(rtDeleteTexture(0), IV); EXPECT(rtDeleteTexture(NOBODY), IV); EXPECT(rtDeleteTexture(texture), OK);
    EXPECT(rtDeleteTexture(texture), IV); CHECK(!rtIsTexture(texture));
    EXPECT(rtTexParameteri(RT_TEXTURE_2D, RT_TEXTURE_WRAP_S, RT_REPEAT), IO);
}

static void usage(void)
{
    EXPECT(rtUseLight(NOBODY), IV); EXPECT(rtUseLight(surface), IO); EXPECT(rtUseLight(light), OK);
    EXPECT(rtUseLight(light), IO); EXPECT(rtUseLightFast(NOBODY), IV); EXPECT(rtUseLightFast(camera), IO);
    EXPECT(rtUseLightFast(light), OK); EXPECT(rtRemoveLight(NOBODY), IV); EXPECT(rtRemoveLight(surface), IV);
    EXPECT(rtRemoveLight(light), OK); EXPECT(rtRemoveLight(light), IV); EXPECT(rtUseCamera(NOBODY), IV);
    EXPECT(rtUseCamera(light), IO); EXPECT(rtUseCamera(camera), OK); EXPECT(rtUseEnvironmentShader(NOBODY), IV);
    EXPECT(rtUseEnvironmentShader(camera), IO); EXPECT(rtUseEnvironmentShader(environment), OK);
    EXPECT(rtUseRenderingObject(NOBODY), IV); EXPECT(rtUseRenderingObject(surface), IO);
}

int main(void)
{
    helpers_are_used();
    /* Nothing is bound yet: these need a class. */
    EXPECT_ID(rtGenNewShader(), IO);
    EXPECT_ID(rtParameterHandle("value"), IO);
    class_id = rtGenNewShaderClass("ConstantShader", NULL);
    surface = rtGenNewShader();
    handle = rtParameterHandle("value");
    rtGenNewShaderClass("SpotLightShader", NULL), light = rtGenNewShader();
    rtGenNewShaderClass("PinholeCameraShader", NULL), camera = rtGenNewShader();
    rtGenNewShaderClass("ConstantEnvironmentShader", NULL), environment = rtGenNewShader();
    object = rtGenObjects(1);
    instance = rtInstantiateObject(object);
    texture = rtGenTextures(1);
    between_begin_and_end();
    general_rules();
    queries();
    frames();
    matrices();
    shaders();
    usage();
    textures();
    objects();
    rtExit();
    FINISH();
}
