// SPDX-License-Identifier: GPL-3.0-or-later
// Embree's own library with other settings, for programs that make the device themselves: `rtcNewDevice` with
// EMBREE_CONFIG appended to the program's text. Preloaded before `libembree4.so.4`, as judge.py does.
//
//     cc -shared -fPIC -o libembree_config.so device.c -ldl
//     EMBREE_CONFIG=isa=sse2 python judge.py ./libembree_config.so
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *(*NewDevice)(const char *);

void *rtcNewDevice(const char *config)
{
    char both[4096];
    const char *more = getenv("EMBREE_CONFIG");
    NewDevice next = (NewDevice)dlsym(RTLD_NEXT, "rtcNewDevice");
    if (!next) {
        // Libraries that were opened without RTLD_GLOBAL are not among the next ones.
        void *library = dlopen("libembree4.so.4", RTLD_NOW | RTLD_NOLOAD);
        next = library ? (NewDevice)dlsym(library, "rtcNewDevice") : NULL;
    }
    if (!next || snprintf(both, sizeof both, "%s,%s", config ? config : "", more ? more : "") >= (int)sizeof both) {
        fprintf(stderr, "device.c: no libembree4.so.4 is loaded, or EMBREE_CONFIG is too long\n");
        return NULL;
    }
    return next(both);
}
