/* SPDX-License-Identifier: GPL-3.0-or-later
 * A window: a teapot on a mirror that turns by itself, or with the mouse.
 *
 *   cc window.c $(pkg-config --cflags --libs rtut) -lm -o window && ./window
 *
 * Drag to turn, wheel or + and - to come nearer, space to let it turn or stand, Esc to leave. Without a window:
 *
 *   RTUT_HEADLESS=1 RTUT_FRAMES=8 RTUT_SAVE=frame ./window
 */
#include <math.h>
#include <openrt/rt.h>
#include <openrt/rtut.h>
#include <stdio.h>

#define PI 3.14159265358979

static RTuint teapot;
static double longitude = 30, latitude = 20, distance = 6;
static int turns = 1, last_x, last_y;

static void define_scene(void)
{
    rtGenNewShaderClass("SpotLightShader", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("radiance"), 60, 55, 48);
    rtParameter3f(rtParameterHandle("position"), 4, 7, 5);
    rtGenNewShaderClass("ConstantEnvironmentShader", NULL);
    rtUseEnvironmentShader(rtGenNewShader());
    rtParameter3f(rtParameterHandle("value"), 0.25f, 0.4f, 0.65f);

    rtGenNewShaderClass("MirrorShader", NULL);
    rtGenNewShader();
    rtParameter1f(rtParameterHandle("attenuation"), 0.5f);
    rtCreateObject(RT_DEFINE_AND_INSTANTIATE);
    rtNormal3f(0, 1, 0);
    rtBegin(RT_QUADS);
    rtVertex3f(-3, -0.8f, 3), rtVertex3f(3, -0.8f, 3), rtVertex3f(3, -0.8f, -3), rtVertex3f(-3, -0.8f, -3);
    rtEnd();
    rtEndObject();

    rtGenNewShaderClass("Phong", NULL);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("diffuseColor"), 0.8f, 0.3f, 0.15f);
    rtParameter3f(rtParameterHandle("specularColor"), 0.6f, 0.6f, 0.6f);
    teapot = rtCreateObject(RT_DEFINE);
    rtutTeapot(1);
    rtEndObject();
    teapot = rtInstantiateObject(teapot);
}

static void display(void)
{
    const double x = distance * cos(latitude * PI / 180) * sin(longitude * PI / 180);
    const double z = distance * cos(latitude * PI / 180) * cos(longitude * PI / 180);
    rtLookAt(x, distance * sin(latitude * PI / 180), z, 0, 0, 0, 0, 1, 0);
    rtLoadIdentity();
    if (turns)
        rtRotated(rtutElapsedTime() * 0.05, 0, 1, 0);
    rtUpdateInstance(teapot);
    rtutSwapBuffers();
}

static void idle(void)
{
    rtutPostRedisplay();
}

static void keyboard(RTubyte key, RTint x, RTint y)
{
    (void)x, (void)y;
    switch (key) {
    case 27:
        rtutLeaveMainLoop();
        break;
    case ' ':
        turns = !turns;
        rtutIdleFunc(turns ? idle : NULL);
        printf(turns ? "turns\n" : "stands\n");
        fflush(stdout);
        break;
    case '+':
        distance *= 0.9;
        break;
    case '-':
        distance /= 0.9;
        break;
    }
    rtutPostRedisplay();
}

static void mouse(RTint button, RTint state, RTint x, RTint y)
{
    if (state == RTUT_DOWN && button == RTUT_WHEEL_UP)
        distance *= 0.9;
    if (state == RTUT_DOWN && button == RTUT_WHEEL_DOWN)
        distance /= 0.9;
    last_x = x, last_y = y;
    rtutPostRedisplay();
}

static void drag(RTint x, RTint y)
{
    longitude -= 0.5 * (x - last_x);
    latitude += 0.5 * (y - last_y);
    latitude = latitude > 89 ? 89 : latitude < -5 ? -5 : latitude;
    last_x = x, last_y = y;
    rtutPostRedisplay();
}

int main(void)
{
    define_scene();
    rtPerspective(45, 0.1, 100);
    rtutInitWindow(640, 480, "OpenRT: a teapot");
    rtutDisplayFunc(display);
    rtutIdleFunc(idle);
    rtutKeyboardFunc(keyboard);
    rtutMouseFunc(mouse);
    rtutMotionFunc(drag);
    if (!rtutMainLoop()) {
        fprintf(stderr, "%s\n", rtutErrorString());
        return 1;
    }
    if (rtGetError() != RT_NO_ERROR)
        return 1;
    printf("longitude %.1f latitude %.1f\n", longitude, latitude);
    rtExit();
    return 0;
}
