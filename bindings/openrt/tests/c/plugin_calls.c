/* SPDX-License-Identifier: GPL-3.0-or-later
 * Plugins' functions and threads: who calls what, and what is refused. Needs calls.so beside it. A hang ends by a signal. */
#define _XOPEN_SOURCE 600
#include "check.h"
#include <dlfcn.h>
#include <pthread.h>
#include <time.h>
#include <unistd.h>

static RTuint of_class(const char *name)
{
    CHECK(rtGenNewShaderClass(name, "./calls.so") != RT_INVALID);
    return rtGenNewShader();
}

static int *counter(const char *name)
{
    static int none = -99;
    void *library = dlopen("./calls.so", RTLD_NOW);
    int *found = library != NULL ? (int *)dlsym(library, name) : NULL;
    CHECK(found != NULL);
    return found != NULL ? found : &none;
}

/* The first call of another thread, while the first thread of all is within a plugin's `init`, which calls back. */
static void *call_meanwhile(void *unused)
{
    static const struct timespec until_the_other_is_inside = { 0, 50000000 };
    nanosleep(&until_the_other_is_inside, NULL);
    rtGetError();
    return unused;
}

static void calls_back(void)
{
    pthread_t other;
    CHECK(rtGenNewShaderClass("calling", "./calls.so") != RT_INVALID);
    CHECK(pthread_create(&other, NULL, call_meanwhile, NULL) == 0);
    CHECK(rtGenNewShader() != RT_INVALID);
    pthread_join(other, NULL);
    CHECK(*counter("error_within") != -1);
}

static RTuint square(void)
{
    const RTuint object = rtNewObject(RT_DEFINE_AND_INSTANTIATE);
    rectangle(-0.5f, -0.5f, 0.5f, 0.5f, 0);
    rtEndObject();
    return object;
}

/* A shader that is deleted while a frame holds it ends on a thread of the program. */
static void ends_at_home(void)
{
    const RTuint shader = of_class("homely"), object = square();
    int i;
    EXPECT(rtRender(), RT_NO_ERROR);
    SHOWS(0, 0, 0.25, 0.25, 0.25);
    rtStartRendering();
    rtDeleteShader(shader);
    rtClearInstances();
    rtRemoveObject(object);
    EXPECT(rtEndRendering(), RT_NO_ERROR);
    CHECK(*counter("ends") == 0);
    for (i = 0; i < 3; i++)
        EXPECT(rtRender(), RT_NO_ERROR);
    CHECK(*counter("ends") == 1);
    CHECK(*counter("ends_elsewhere") == 0);
}

int main(void)
{
    RTuint light;
    alarm(60);
    helpers_are_used();
    calls_back();
    use_frame();
    look_at_square();
    ends_at_home();

    rtGenNewShaderClass("SpotLightShader", NULL);
    light = rtGenNewShader();
    rtParameter3f(rtParameterHandle("radiance"), 1, 1, 1);
    rtParameter3f(rtParameterHandle("position"), 0, 0, 1);
    rtUseLight(light);
    of_class("lifted");
    square();
    EXPECT(rtRender(), RT_NO_ERROR);
    /* Half as far from the light: four times its light; at the middle of a pixel. */
    NEAR(at(0.0625, 0.0625)[0], 1 / (0.25 + 2 * 0.0625 * 0.0625), 0.05);

    rtClearInstances();
    of_class("stray");
    square();
    rtStartRendering();
    EXPECT(rtEndRendering(), RT_INVALID_OPERATION);
    SHOWS(0, 0, 0.5, 0.5, 0.5);
    CHECK(strstr(rtGetShaderClassInfoLog(), "from a thread other than that of the callback") != NULL);
    rtExit();
    FINISH();
}
