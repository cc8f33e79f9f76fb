/* SPDX-License-Identifier: GPL-3.0-or-later
 * A listener that was replaced is called no more: what it was given may be freed. Threads make errors meanwhile. */
#define _POSIX_C_SOURCE 200112L
#include "check.h"
#include <pthread.h>
#include <time.h>

#define THREADS 4

struct listener {
    volatile int alive;
};

static volatile int over = 0, late = 0, heard = 0;

static void rest(long nanoseconds)
{
    struct timespec time = { 0, 0 };
    time.tv_nsec = nanoseconds;
    nanosleep(&time, NULL);
}

static void listen(RTenum error, const char *call, void *user)
{
    struct listener *listener = user;
    (void)error, (void)call;
    heard = 1;
    late |= !listener->alive;
    rest(2000000);
    late |= !listener->alive;
}

static void *make_errors(void *unused)
{
    (void)unused;
    while (!over) {
        rtBegin(0x17);
        rtVertex3f(0, 0, 0);
    }
    return NULL;
}

/* One that replaces itself, and another that does the same meanwhile on another thread: neither waits for the other. */
static void replace(RTenum error, const char *call, void *user)
{
    (void)error, (void)call;
    rest(2000000);
    rtDebugCallback(replace, user);
}

int main(void)
{
    pthread_t threads[THREADS];
    static struct listener listeners[50];
    int i;
    helpers_are_used();
    for (i = 0; i < THREADS; i++)
        pthread_create(&threads[i], NULL, make_errors, NULL);
    for (i = 0; i < 50; i++) {
        listeners[i].alive = 1;
        rtDebugCallback(listen, &listeners[i]);
        rest(3000000);
        if (i % 10 == 9)
            rtExit();
        else
            rtDebugCallback(NULL, NULL);
        listeners[i].alive = 0;
    }
    CHECK(heard);
    CHECK(!late);
    rtDebugCallback(replace, NULL);
    rest(20000000);
    over = 1;
    for (i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    rtDebugCallback(NULL, NULL);
    rtGetError();
    FINISH();
}
