/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * The interface between libOpenRT and shader plugins, version 1.1.
 *
 * Copyright (C) the GNU RT authors. This file is part of GNU RT, which is free software: you can redistribute it
 * and/or modify it under the terms of the GNU General Public License as published by the Free Software Foundation,
 * either version 3 of the License, or (at your option) any later version. It comes WITHOUT ANY WARRANTY; see the
 * file COPYING for details.
 *
 * Additional permission under section 7 of the GNU General Public License, version 3: including this header,
 * unmodified, in the source of a shader plugin or of any other work, and compiling the types, constants, macros
 * and inline functions that it defines into that work, does not by itself cause the work to be covered by the
 * GNU General Public License. Shader plugins that use only this header and types.h may carry
 * any licence.
 *
 * A plugin is a shared library that exports one function, rts_module. A program loads a class of it with
 * rtGenNewShaderClass("name", "file.so"). It is not linked with libOpenRT: what it needs comes as a table of functions,
 * RTShost. Build one with
 *
 *     cc -std=c99 -O3 -shared -fPIC shader.c -o shader.so
 *
 * Rules for plugins
 *
 *  1. rts_module returns NULL if it cannot serve the host's major version. The host refuses modules of another major
 *     version, takes any minor one, and reads no member beyond a structure's struct_size; nor must a plugin. New
 *     members come at the end only.
 *  2. What rts_module returns is constant and stays where it is as long as the library is loaded.
 *  3. init, fini and prepare are called by one thread at a time; all other callbacks by many threads at once. Blocks
 *     are read-only during a frame. Keep no global variables that change.
 *  4. A callback must fill lanes 0 to n-1 of its output; n is any number >= 1. Arrays that come from the host begin at
 *     multiples of 64 bytes and have room for a multiple of 16 floats: vector loops may read and write beyond n up
 *     to there. What the lanes beyond n hold means nothing.
 *  5. trace, occluded, illuminate and texture take whole batches and return when all is done. Ask for many rays at
 *     once: the host traces them together and shades what they hit in batches of one shader each. Rays deeper than
 *     the limit of rtSetMaxRayRecursionDepth see the environment. Rays that trace is asked for when less than 5 MiB of
 *     the thread's 16 MiB of stack are left are not traced: they see black, and the frame has an error.
 *  6. param hides how often a parameter changes: the value per shader is copied to each lane, that per triangle is
 *     gathered, that per vertex interpolated.
 *  7. Let no exception or panic leave a function. One that does ends in libOpenRT where the system allows that (Linux on
 *     x86-64 and aarch64) and becomes an error of the call or the frame, with words in rtGetShaderClassInfoLog; elsewhere
 *     it ends the program. longjmp must not leave a function. Callbacks must not call rt* functions.
 *  8. An offset is within the block of the parameter's own rate. init writes the defaults of the block per shader; values
 *     per triangle and per vertex start as zero. Only surface classes have the latter two.
 *  9. Classes of kind RT_RENDERING_OBJECT cannot be plugins yet.
 *
 * Lanes that a callback leaves unwritten, or fills with NaN or infinities, become black (a surface, the environment),
 * unlit (a light) or see nothing (a camera); they are counted, libOpenRT says so once per frame and class on the standard
 * error stream and in rtGetShaderClassInfoLog, and rtEndRendering gives RT_INVALID_OPERATION. The frame is finished.
 */
#ifndef OPENRT_RTS_H
#define OPENRT_RTS_H

#include <stddef.h>
#include <stdint.h>

#include <openrt/types.h>

#if defined(_WIN32)
#define RTS_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define RTS_EXPORT __attribute__((visibility("default")))
#else
#define RTS_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version that this header describes: major << 16 | minor. */
#define RTS_ABI 0x00010001u

/* Three floats per lane: lane i is (x[i], y[i], z[i]). */
typedef struct { const float *x, *y, *z; } RTSvec;
typedef struct { float *x, *y, *z; } RTSvecm;

/* What a call belongs to; only good as an argument of the host's functions until the callback returns. */
typedef struct RTSctx RTSctx;

/* A parameter of a class. */
typedef struct {
    const char *name;
    uint32_t type;   /* RT_BYTE to RT_FLOAT, RT_DOUBLE; RT_STRING, a const char * that the host owns: per shader only */
    uint32_t count;  /* how many of that type, >= 1: 3 for a colour. At most 16 if not per shader; 1 for RT_STRING */
    uint32_t rate;   /* RT_PER_SHADER, RT_PER_TRIANGLE, RT_PER_VERTEX */
    uint32_t offset; /* bytes, in the block of its rate */
} RTSparam;

/* Rays. Those that a plugin asks for need neither alignment nor room beyond n. */
typedef struct {
    uint32_t struct_size, n;
    RTSvec org, dir;         /* world; trace wants unit directions, occluded takes any length but 0 */
    const float *tmin, *tmax; /* in multiples of dir; tmax may be infinite */
    const uint32_t *parent;  /* lane of the batch that each ray serves. NULL: ray i serves lane i modulo n of the batch */
    const float *weight;     /* importance; NULL: 1. Not used yet */
} RTSrays;

/* A ray whose origin is exactly P of its parent leaves from just off the surface, so that it cannot meet it again:
 * tmin may be 0. An occluded ray of that kind with a finite tmax ends as much before it. */

/* Points of surfaces with the same shader. */
typedef struct {
    uint32_t struct_size, n;          /* lanes 0 to n-1 are all live */
    const void *shader;               /* the block per shader, as prepare left it */
    RTSvec P;                         /* points, world */
    RTSvec Ng;                        /* unit geometric normals, counter-clockwise; not turned towards the ray */
    RTSvec Ns;                        /* unit interpolated normals as the program gave them, not turned; Ng without */
    RTSvec I;                         /* unit directions of the rays that came here */
    const float *t, *b1, *b2;         /* distances that they came, barycentric weights of the 2nd and 3rd vertex */
    RTSvec color;                     /* interpolated rtColor* */
    RTSvec texcoord;                  /* interpolated rtTexCoord*: x = s/q, y = t/q, z = r/q */
    const float *alpha;               /* interpolated rtColor4* */
    const uint32_t *object, *instance; /* ids of the API; 0 for geometry outside of objects */
    const uint32_t *triangle;         /* from 0, in the order in which the object's triangles were given */
    const uint32_t *depth;            /* 0 for camera rays */
    const uint8_t *back;              /* 1 where Ng.I > 0 */
} RTShits;

/* Services of the host. Call them only during the callback that was given ctx, on its thread: on another one they do nothing, and
 * the frame has an error.
 * Camera, light and environment shaders have no lights and no rays: for them light_count is 0, illuminate lights
 * nothing, occluded gives 1 and trace 0. */
typedef struct RTShost {
    uint32_t struct_size, abi;

    /* Parameter number `index` of the class at each lane of hits, as floats: component k of lane i is out[k*n + i].
     * Textures and other integers are converted; strings give 0. */
    void (*param)(RTSctx *ctx, const RTShits *hits, uint32_t index, float *out);

    /* Lights of the scene. */
    uint32_t (*light_count)(RTSctx *ctx);

    /* Asks light number `light` about n points, which should be hits->P or lie nearby: unit directions towards it,
     * distances (infinite for distant lights), what arrives at a surface that faces it if nothing is in between, and
     * whether anything does (0 or 1). */
    void (*illuminate)(RTSctx *ctx, uint32_t light, uint32_t n, RTSvec P,
                       RTSvecm dir, float *dist, RTSvecm radiance, uint8_t *lit);

    /* What share of light comes through between tmin and tmax of each ray; 1 = nothing is in between. */
    void (*occluded)(RTSctx *ctx, const RTSrays *rays, RTSvecm transmittance);

    /* The radiance that comes against each ray, one bounce deeper than the batch. */
    void (*trace)(RTSctx *ctx, const RTSrays *rays, RTSvecm radiance);

    /* Reads texture `tex`, an id of the API; white and opaque if it has no picture. */
    void (*texture)(RTSctx *ctx, uint32_t tex, uint32_t n, const float *s, const float *t,
                    RTSvecm rgb, float *alpha);

    /* Memory at a multiple of 64 bytes that lives until the callback returns; its content is arbitrary. NULL if there
     * is none. */
    void *(*scratch)(RTSctx *ctx, size_t bytes);

    /* Says something on the standard error stream: level 0 = a note, 1 = a warning, 2 = an error. ctx may be NULL: in
     * prepare; there it also goes to rtGetShaderClassInfoLog if prepare fails. */
    void (*log)(RTSctx *ctx, int level, const char *utf8);
} RTShost;

/* A shader class. Callbacks of other kinds than its own are NULL. */
typedef struct {
    uint32_t struct_size;
    uint32_t kind;                        /* RT_SURFACE_SHADER, RT_ENV_SHADER, RT_LIGHT_SHADER, RT_CAMERA_SHADER */
    uint32_t flags;                       /* 0 */
    const char *name;
    uint32_t shader_size, shader_align;   /* the block per shader; a power of two up to 4096, 0 = 16 */
    uint32_t triangle_size, vertex_size;  /* the blocks per triangle and per vertex: what offsets count in */
    uint32_t param_count;
    const RTSparam *params;

    void (*init)(void *block);            /* writes defaults into a block of zeros; may be NULL */
    void (*fini)(void *block);            /* undoes init; may be NULL */

    /* Called before a frame with the frame's copy of the block, on which it may compute what shading needs; never
     * with the block itself. 0 = success; else the frame goes on without this shader: its surfaces are mid-grey, as
     * light it is left out, as camera or environment the default is used, rtStartRendering gives RT_INVALID_OPERATION.
     * May be NULL. Where it can, libOpenRT tries it in a child process first, so that one that crashes ends no program:
     * it should have no effects beyond the block, and keep memory that it allocates for init's block, or not at all. */
    int (*prepare)(const RTShost *host, void *snapshot);

    /* Surfaces: the radiance that leaves each point against its ray. */
    void (*shade)(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out);
    /* Surfaces: the share of light that goes straight through. NULL: none. */
    void (*transmit)(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out);

    /* Environment: the radiance that comes against each ray that hits nothing. It is infinitely far away: the rays'
     * origins are 0, tmax is infinite. */
    void (*miss)(const RTShost *host, RTSctx *ctx, const void *block, const RTSrays *rays, RTSvecm out);

    /* Lights: direction towards the light (any length), distance (infinity if it is nowhere), what arrives there at a
     * surface that faces it if nothing is in between; lit = 1 where the light reaches. Lanes with lit = 0, as all are
     * before the call, need nothing else. */
    void (*illuminate)(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, RTSvec P,
                       RTSvecm dir, float *dist, RTSvecm radiance, uint8_t *lit);

    /* Cameras: the ray through (x, y), both in [0, 1], (0, 0) = lower left; directions of any length. */
    void (*camera)(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n,
                   const float *x, const float *y, RTSvecm org, RTSvecm dir);

    /* Since 1.1. Cameras with a lens or a shutter: called in place of `camera`, which may then be NULL, but which hosts of version 1.0
     * need. lens_x, lens_y: where the ray goes through the lens, two numbers in [0, 1) that are uniform over all that lets light in;
     * 0.5, 0.5 is the middle. time: when, from 0 = the shutter opens to 1 = it closes; 0.5 where nothing moves. */
    void (*camera_lens)(const RTShost *host, RTSctx *ctx, const void *block, uint32_t n, const float *x, const float *y,
                        const float *lens_x, const float *lens_y, const float *time, RTSvecm org, RTSvecm dir);
} RTSclass;

/* What a plugin offers. */
typedef struct {
    uint32_t struct_size, abi; /* abi = RTS_ABI */
    uint32_t class_count;
    const RTSclass *const *classes;
} RTSmodule;

/* The one function that a plugin exports. */
RTS_EXPORT const RTSmodule *rts_module(uint32_t host_abi);

#ifdef __cplusplus
}
#endif

#endif /* OPENRT_RTS_H */
