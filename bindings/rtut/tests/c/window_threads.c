/* SPDX-License-Identifier: GPL-3.0-or-later
 * A window that rests hears of what another thread asks for. Ends with status 0 after two frames; a window that sleeps on is ended by
 * a signal. */
#define _XOPEN_SOURCE 600
#include <openrt/rtut.h>
#include <pthread.h>
#include <time.h>
#include <unistd.h>

static volatile int frames = 0;

static void rest(long milliseconds)
{
    struct timespec time;
    time.tv_sec = milliseconds / 1000, time.tv_nsec = milliseconds % 1000 * 1000000;
    nanosleep(&time, NULL);
}

static void display(void)
{
    static const RTubyte pixel[3] = { 0, 0, 255 };
    frames++;
    rtutShowPixels(pixel, 1, 1, RT_RGB_8);
}

static void *ask(void *unused)
{
    while (frames == 0)
        rest(10);
    /* Whatever a window is told of when it opens. */
    rest(700);
    frames = 0;
    rtutPostRedisplay();
    while (frames == 0)
        rest(10);
    rest(300);
    rtutLeaveMainLoop();
    return unused;
}

int main(void)
{
    pthread_t other;
    alarm(20);
    rtutInitWindow(64, 48, "threads");
    rtutDisplayFunc(display);
    if (pthread_create(&other, NULL, ask, NULL) != 0 || !rtutMainLoop())
        return 1;
    pthread_join(other, NULL);
    return frames < 1;
}
