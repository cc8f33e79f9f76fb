/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * The OpenRT API: scenes and pictures by ray tracing, in the manner of OpenGL.
 *
 * Copyright (C) the GNU RT authors. This file is part of GNU RT, which is free software: you can redistribute it
 * and/or modify it under the terms of the GNU General Public License as published by the Free Software Foundation,
 * either version 3 of the License, or (at your option) any later version. It comes WITHOUT ANY WARRANTY; see the
 * file COPYING for details.
 *
 * Additional permission under section 7 of the GNU General Public License, version 3: including this header,
 * unmodified, in the source of a shader plugin or of any other work, and compiling the types, constants, macros
 * and inline functions that it defines into that work, does not by itself cause the work to be covered by the
 * GNU General Public License. The library libOpenRT itself remains covered by it.
 */
#ifndef OPENRT_RT_H
#define OPENRT_RT_H

#include <openrt/types.h>

/*
 * Errors. A call that fails has no effect, gives RT_INVALID if it returns an id, and sets an error that rtGetError
 * returns; the first error since the last rtGetError stays. The notes below name, for each function, its errors:
 *   BE   RT_INVALID_OPERATION between rtBegin and rtEnd
 *   OBJ  RT_INVALID_OPERATION while an object is open
 *   IO   RT_INVALID_OPERATION      IV  RT_INVALID_VALUE      IE  RT_INVALID_ENUM
 * They are checked in this order: BE, OBJ, null pointers (IV), constants (IE), ids (IV), kind and state (IO).
 * Between rtBegin and rtEnd only rtVertex*, rtNormal*, rtTexCoord*, rtColor*, rtParameter* (but not
 * rtParameterHandle), rtFrameBufferUse and rtEnd may be called.
 *
 * The library has one context, made by rtInit or by the first other call. Calls from several threads are serialised.
 * Matrices are column-major, angles are degrees, the coordinate system is right-handed.
 */

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Context, errors and queries ----------------------------------------------------------------------------- */

/* Makes the context: empty scene, identity matrices, nothing bound. Both arguments may be NULL; arguments that
 * begin with --rt- are taken out of argv (--rt-threads=N sets the number of threads). IO if a context exists
 * already. */
RTAPI void RTAPIENTRY rtInit(int *argcp, char **argv);

/* Finishes a running frame and frees everything; the next call makes a fresh context. BE. */
RTAPI void RTAPIENTRY rtExit(void);

/* Returns the first error since the last call and clears it. Between rtBegin and rtEnd: RT_NO_ERROR, and BE is
 * recorded. */
RTAPI RTenum RTAPIENTRY rtGetError(void);

/* Extension. Calls `function` at every error of the calls of any thread, on that thread: with the error's code, the call
 * with its arguments as text, which lives until the function returns, and `user`. It may call rt* functions; errors of
 * those are not told again. NULL removes the function. When rtDebugCallback or rtExit returns, the function that was there is not
 * called any more, and has returned on all threads: they wait for it, so hold no lock that it wants. Called from within
 * such a function they do not wait. An exception of C++ may leave `function`: it passes through the call that failed to
 * the program. Beside this, every error is printed on the standard error output if the environment has OPENRT_DEBUG=1.
 * BE. */
RTAPI void RTAPIENTRY rtDebugCallback(RTdebugproc function, void *user);

/* RT_VENDOR, RT_RENDERER, RT_VERSION or RT_EXTENSIONS as a string that lives as long as the library. NULL on
 * error: BE, IE. */
RTAPI const RTubyte *RTAPIENTRY rtGetString(RTenum name);

/* Write the value or values named by `name`. Integers are rounded; colours and normals map [-1, 1] to the range
 * of RTint. BE; IV if `values` is NULL; IE. */
RTAPI void RTAPIENTRY rtGetIntegerv(RTenum name, RTint *values);
RTAPI void RTAPIENTRY rtGetFloatv(RTenum name, RTfloat *values);

/* Whether `id` is a generated object, an instance, a shader or a generated texture. BE. */
RTAPI RTboolean RTAPIENTRY rtIsObject(RTuint id);
RTAPI RTboolean RTAPIENTRY rtIsInstance(RTuint id);
RTAPI RTboolean RTAPIENTRY rtIsShader(RTuint id);
RTAPI RTboolean RTAPIENTRY rtIsTexture(RTuint id);

/* ---- Frame buffer and frames --------------------------------------------------------------------------------- */

/* Gives the memory for the frames that start from now on: width * height pixels in tight rows, the lowest row
 * first. It stays the caller's and must live until rtEndRendering. BE; IV if NULL; IE format; IV if a size is 0 or
 * there are more than 2^31 pixels. */
RTAPI void RTAPIENTRY rtSetFrameBuffer(RTubyte *memory, RTuint width, RTuint height, RTenum format);

/* Extension. What the library does with memory that rtSetFrameBuffer was given: the sum of RT_NEXT_FRAME_BIT (frames that start
 * from now on are written to it) and RT_IN_FLIGHT_BIT (the frame in flight is). The caller may free the memory at 0. No errors,
 * also between rtBegin and rtEnd; makes no context. */
RTAPI RTuint RTAPIENTRY rtFrameBufferUse(const RTubyte *memory);

/* Takes a snapshot of scene and parameters and starts to render it in the background; the scene may be edited at
 * once. BE; OBJ; IO if a frame is in flight or there is no frame buffer; RT_OUT_OF_MEMORY if there is no room for the
 * picture, or no threads are to be had: no frame starts. IO, too, if `prepare` of a plugin fails: the frame starts and
 * goes on without that shader, see rtGetShaderClassInfoLog. */
RTAPI void RTAPIENTRY rtStartRendering(void);

/* Waits until the frame in flight is complete in its frame buffer; other threads may call meanwhile. BE; OBJ; IO if
 * none is in flight; RT_OUT_OF_MEMORY if the scene is too large. IO, too, if plugins gave NaN or infinities, threw
 * exceptions, or left too little stack for rays, all of which is shown black, see rtGetShaderClassInfoLog. */
RTAPI void RTAPIENTRY rtEndRendering(void);

/* Starts a frame if none is in flight, then ends it. BE; OBJ; IO without frame buffer. rtRenderFrame is the same. */
RTAPI void RTAPIENTRY rtRender(void);
RTAPI void RTAPIENTRY rtRenderFrame(void);

/* Ends the frame in flight, if any, then starts the next. BE; OBJ; IO without frame buffer. */
RTAPI void RTAPIENTRY rtSwapBuffers(void);

/* Extension. Asks the frame in flight to end early; rtEndRendering must follow as ever, and gives no error. The frame buffer
 * then holds what samples there are, or its old pixels if not every pixel has one. May come from another thread than
 * the one that waits in rtEndRendering. BE; IO if no frame is in flight. */
RTAPI void RTAPIENTRY rtCancelRendering(void);

/* Extension. Samples that each frame takes of each pixel, initially 1. A single one lies in the middle of the pixel;
 * several are spread over it, and their mean is shown. BE; IV if 0. */
RTAPI void RTAPIENTRY rtSetSamplesPerPixel(RTuint samples);

/* Extension. RT_TRUE: while nothing changes that the picture depends on, a frame's samples are added to those of the
 * frames before, so that the picture becomes smoother from frame to frame; after a change it starts again. The count is that of
 * RT_SAMPLE_COUNT. RT_FALSE (initial): each frame stands alone. BE. */
RTAPI void RTAPIENTRY rtProgressive(RTboolean on);

/* RT_RETAINED (initial): instances, lights, camera and environment persist. RT_IMMEDIATE: each start of a frame
 * takes them and leaves none. BE; IE. */
RTAPI void RTAPIENTRY rtSceneMode(RTenum mode);

/* Rays of a greater depth see the environment; camera rays have depth 0. Initially 16; at most 1024 is used. BE; IV
 * if negative, that is above 2^31 - 1. */
RTAPI void RTAPIENTRY rtSetMaxRayRecursionDepth(RTuint depth);

/* How far from their surface new rays begin, in units of the scene. Initially 1e-4. BE; IV if negative or not
 * finite. */
RTAPI void RTAPIENTRY rtSetRayEpsilon(RTfloat epsilon);

/* Returns the value of rtSetRayEpsilon. BE, then 0. */
RTAPI RTfloat RTAPIENTRY rtGetRayEpsilon(void);

/* ---- Matrices ------------------------------------------------------------------------------------------------ */

/* Chooses the stack of the calls below: RT_MODELVIEW (initial), RT_PROJECTION or RT_TEXTURE. BE; IE. */
RTAPI void RTAPIENTRY rtMatrixMode(RTenum mode);

/* Replaces the current matrix by the identity. BE. */
RTAPI void RTAPIENTRY rtLoadIdentity(void);

/* Multiply a scaling to the right of the current matrix. BE. */
RTAPI void RTAPIENTRY rtScalef(RTfloat x, RTfloat y, RTfloat z);
RTAPI void RTAPIENTRY rtScaled(RTdouble x, RTdouble y, RTdouble z);

/* Multiply a translation to the right of the current matrix. BE. */
RTAPI void RTAPIENTRY rtTranslatef(RTfloat x, RTfloat y, RTfloat z);
RTAPI void RTAPIENTRY rtTranslated(RTdouble x, RTdouble y, RTdouble z);

/* Multiply a rotation about (x, y, z), of any length, to the right; a zero axis does nothing. BE. */
RTAPI void RTAPIENTRY rtRotatef(RTfloat degrees, RTfloat x, RTfloat y, RTfloat z);
RTAPI void RTAPIENTRY rtRotated(RTdouble degrees, RTdouble x, RTdouble y, RTdouble z);

/* Replace the current matrix by a column-major one. BE; IV if NULL. */
RTAPI void RTAPIENTRY rtLoadMatrixf(const RTfloat matrix[16]);
RTAPI void RTAPIENTRY rtLoadMatrixd(const RTdouble matrix[16]);

/* Multiply a column-major matrix to the right of the current one. BE; IV if NULL. */
RTAPI void RTAPIENTRY rtMultMatrixf(const RTfloat matrix[16]);
RTAPI void RTAPIENTRY rtMultMatrixd(const RTdouble matrix[16]);

/* Replace the current matrix by a row-major one. BE; IV if NULL. */
RTAPI void RTAPIENTRY rtLoadTransposeMatrixf(const RTfloat matrix[16]);
RTAPI void RTAPIENTRY rtLoadTransposeMatrixd(const RTdouble matrix[16]);

/* Multiply a row-major matrix to the right of the current one. BE; IV if NULL. */
RTAPI void RTAPIENTRY rtMultTransposeMatrixf(const RTfloat matrix[16]);
RTAPI void RTAPIENTRY rtMultTransposeMatrixd(const RTdouble matrix[16]);

/* Push a copy of the current matrix and pop it again; each stack holds 1024 matrices. BE; RT_STACK_OVERFLOW,
 * RT_STACK_UNDERFLOW. */
RTAPI void RTAPIENTRY rtPushMatrix(void);
RTAPI void RTAPIENTRY rtPopMatrix(void);

/* ---- Objects and instances ----------------------------------------------------------------------------------- */

/* Reserves `count` consecutive unused ids of empty objects and returns the first. BE; OBJ; IV if count < 1;
 * RT_OUT_OF_MEMORY when ids run out. */
RTAPI RTuint RTAPIENTRY rtGenObjects(RTsizei count);

/* Opens object `id` for definition and returns `id`. RT_DEFINE (= RT_COMPILE) clears it first;
 * RT_DEFINE_AND_INSTANTIATE also adds an instance when it is closed; RT_UPDATE replaces vertices and must give
 * the same numbers of them. BE; OBJ; IE; IV if `id` was never generated. rtNewObject(mode) is
 * rtCreateObject(mode): see the end of this file. For callers without a prototype the function itself takes a
 * first argument of RT_DEFINE or RT_DEFINE_AND_INSTANTIATE for the mode (no object has such an id). */
RTAPI RTuint RTAPIENTRY rtNewObject(RTuint id, RTenum mode);

/* Generates an id and opens its object. BE; OBJ; IE. */
RTAPI RTuint RTAPIENTRY rtCreateObject(RTenum mode);

/* Closes the open object. BE; IO if none is open, or after RT_UPDATE with another number of vertices or other objects in it,
 * or if objects in it hold it themselves or are more than 16 deep. Then the object is closed and keeps its old geometry. */
RTAPI void RTAPIENTRY rtEndObject(void);

/* Adds an instance of the object, placed by the current RT_MODELVIEW matrix, and returns the instance's id.
 * Closes object `id` first if it is the open one. The id of an instance that is gone comes back when all others have had
 * their turn. BE; IO if another object is open; IV unknown id. */
RTAPI RTuint RTAPIENTRY rtInstantiateObject(RTuint id);

/* Puts an object into the open one, placed in it by the current RT_MODELVIEW matrix: what it shows is stored once, however often
 * it occurs. It shows what is defined under its id then, or later. `mask` says which of the rays that see the open object see it:
 * see rtInstanceMask; ~0u is all. BE; IO if no object is open, or `object` is the open one; IV unknown id. */
RTAPI void RTAPIENTRY rtNestObject(RTuint object, RTuint mask);

/* Frees the object's id; its instances remain. BE; OBJ; IV. */
RTAPI void RTAPIENTRY rtRemoveObject(RTuint id);

/* Replaces an instance's matrix by the current RT_MODELVIEW matrix. BE; IV. */
RTAPI void RTAPIENTRY rtUpdateInstance(RTuint instance);

/* Which rays see an instance, as bits: 1 those from the camera to the first surface and straight on through transparent ones,
 * 2 shadow rays, 4 all others (reflected, refracted, scattered, and light that lamps send out). New instances are seen by all
 * rays. BE; IV. */
RTAPI void RTAPIENTRY rtInstanceMask(RTuint instance, RTuint mask);

/* Removes an instance. BE; IV. */
RTAPI void RTAPIENTRY rtDeleteInstance(RTuint instance);

/* Removes all instances. BE. */
RTAPI void RTAPIENTRY rtClearInstances(void);

/* Writes an instance's matrix, column-major. BE; IV, also if `matrix` is NULL. */
RTAPI void RTAPIENTRY rtGetInstanceMatrixf(RTuint instance, RTfloat matrix[16]);

/* ---- Geometry ------------------------------------------------------------------------------------------------ */

/* Begins a block of vertices. Vertices go to the open object; with none open, to an unnamed object that is drawn
 * once, in the next frame, where its vertices say. A block of fewer vertices than one RT_TRIANGLES (3) or
 * RT_QUADS (4) primitive needs is continued by the next such block of the same mode, object and shader. BE; IE. */
RTAPI void RTAPIENTRY rtBegin(RTenum mode);

/* Ends the block. IO outside of one. */
RTAPI void RTAPIENTRY rtEnd(void);

/* Give a vertex: the RT_MODELVIEW matrix is applied at once, z = 0 and w = 1 where not given, and the current
 * normal, colour, texture coordinates and parameter values go with it. IV if `v` is NULL; IO outside rtBegin and
 * rtEnd; IO if no surface shader is bound; RT_OUT_OF_MEMORY if there is no room for it. */
RTAPI void RTAPIENTRY rtVertex2s(RTshort x, RTshort y);
RTAPI void RTAPIENTRY rtVertex2i(RTint x, RTint y);
RTAPI void RTAPIENTRY rtVertex2f(RTfloat x, RTfloat y);
RTAPI void RTAPIENTRY rtVertex2d(RTdouble x, RTdouble y);
RTAPI void RTAPIENTRY rtVertex3s(RTshort x, RTshort y, RTshort z);
RTAPI void RTAPIENTRY rtVertex3i(RTint x, RTint y, RTint z);
RTAPI void RTAPIENTRY rtVertex3f(RTfloat x, RTfloat y, RTfloat z);
RTAPI void RTAPIENTRY rtVertex3d(RTdouble x, RTdouble y, RTdouble z);
RTAPI void RTAPIENTRY rtVertex4s(RTshort x, RTshort y, RTshort z, RTshort w);
RTAPI void RTAPIENTRY rtVertex4i(RTint x, RTint y, RTint z, RTint w);
RTAPI void RTAPIENTRY rtVertex4f(RTfloat x, RTfloat y, RTfloat z, RTfloat w);
RTAPI void RTAPIENTRY rtVertex4d(RTdouble x, RTdouble y, RTdouble z, RTdouble w);
RTAPI void RTAPIENTRY rtVertex2sv(const RTshort *v);
RTAPI void RTAPIENTRY rtVertex2iv(const RTint *v);
RTAPI void RTAPIENTRY rtVertex2fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtVertex2dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtVertex3sv(const RTshort *v);
RTAPI void RTAPIENTRY rtVertex3iv(const RTint *v);
RTAPI void RTAPIENTRY rtVertex3fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtVertex3dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtVertex4sv(const RTshort *v);
RTAPI void RTAPIENTRY rtVertex4iv(const RTint *v);
RTAPI void RTAPIENTRY rtVertex4fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtVertex4dv(const RTdouble *v);

/* Set the current normal, of any length; z = 0 where not given, w is ignored, integers are not rescaled. Vertices
 * given before the first rtNormal* of an object have no normal, and their triangles are flat. IV if `v` is NULL. */
RTAPI void RTAPIENTRY rtNormal2s(RTshort x, RTshort y);
RTAPI void RTAPIENTRY rtNormal2i(RTint x, RTint y);
RTAPI void RTAPIENTRY rtNormal2f(RTfloat x, RTfloat y);
RTAPI void RTAPIENTRY rtNormal2d(RTdouble x, RTdouble y);
RTAPI void RTAPIENTRY rtNormal3s(RTshort x, RTshort y, RTshort z);
RTAPI void RTAPIENTRY rtNormal3i(RTint x, RTint y, RTint z);
RTAPI void RTAPIENTRY rtNormal3f(RTfloat x, RTfloat y, RTfloat z);
RTAPI void RTAPIENTRY rtNormal3d(RTdouble x, RTdouble y, RTdouble z);
RTAPI void RTAPIENTRY rtNormal4s(RTshort x, RTshort y, RTshort z, RTshort w);
RTAPI void RTAPIENTRY rtNormal4i(RTint x, RTint y, RTint z, RTint w);
RTAPI void RTAPIENTRY rtNormal4f(RTfloat x, RTfloat y, RTfloat z, RTfloat w);
RTAPI void RTAPIENTRY rtNormal4d(RTdouble x, RTdouble y, RTdouble z, RTdouble w);
RTAPI void RTAPIENTRY rtNormal2sv(const RTshort *v);
RTAPI void RTAPIENTRY rtNormal2iv(const RTint *v);
RTAPI void RTAPIENTRY rtNormal2fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtNormal2dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtNormal3sv(const RTshort *v);
RTAPI void RTAPIENTRY rtNormal3iv(const RTint *v);
RTAPI void RTAPIENTRY rtNormal3fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtNormal3dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtNormal4sv(const RTshort *v);
RTAPI void RTAPIENTRY rtNormal4iv(const RTint *v);
RTAPI void RTAPIENTRY rtNormal4fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtNormal4dv(const RTdouble *v);

/* Set the current texture coordinates: t = 0, r = 0, q = 1 where not given; the RT_TEXTURE matrix is applied at
 * the vertex. Shaders see s/q, t/q and r/q, divided where the ray hits. IV if `v` is NULL. */
RTAPI void RTAPIENTRY rtTexCoord1s(RTshort s);
RTAPI void RTAPIENTRY rtTexCoord1i(RTint s);
RTAPI void RTAPIENTRY rtTexCoord1f(RTfloat s);
RTAPI void RTAPIENTRY rtTexCoord1d(RTdouble s);
RTAPI void RTAPIENTRY rtTexCoord2s(RTshort s, RTshort t);
RTAPI void RTAPIENTRY rtTexCoord2i(RTint s, RTint t);
RTAPI void RTAPIENTRY rtTexCoord2f(RTfloat s, RTfloat t);
RTAPI void RTAPIENTRY rtTexCoord2d(RTdouble s, RTdouble t);
RTAPI void RTAPIENTRY rtTexCoord3s(RTshort s, RTshort t, RTshort r);
RTAPI void RTAPIENTRY rtTexCoord3i(RTint s, RTint t, RTint r);
RTAPI void RTAPIENTRY rtTexCoord3f(RTfloat s, RTfloat t, RTfloat r);
RTAPI void RTAPIENTRY rtTexCoord3d(RTdouble s, RTdouble t, RTdouble r);
RTAPI void RTAPIENTRY rtTexCoord4s(RTshort s, RTshort t, RTshort r, RTshort q);
RTAPI void RTAPIENTRY rtTexCoord4i(RTint s, RTint t, RTint r, RTint q);
RTAPI void RTAPIENTRY rtTexCoord4f(RTfloat s, RTfloat t, RTfloat r, RTfloat q);
RTAPI void RTAPIENTRY rtTexCoord4d(RTdouble s, RTdouble t, RTdouble r, RTdouble q);
RTAPI void RTAPIENTRY rtTexCoord1sv(const RTshort *v);
RTAPI void RTAPIENTRY rtTexCoord1iv(const RTint *v);
RTAPI void RTAPIENTRY rtTexCoord1fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtTexCoord1dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtTexCoord2sv(const RTshort *v);
RTAPI void RTAPIENTRY rtTexCoord2iv(const RTint *v);
RTAPI void RTAPIENTRY rtTexCoord2fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtTexCoord2dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtTexCoord3sv(const RTshort *v);
RTAPI void RTAPIENTRY rtTexCoord3iv(const RTint *v);
RTAPI void RTAPIENTRY rtTexCoord3fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtTexCoord3dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtTexCoord4sv(const RTshort *v);
RTAPI void RTAPIENTRY rtTexCoord4iv(const RTint *v);
RTAPI void RTAPIENTRY rtTexCoord4fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtTexCoord4dv(const RTdouble *v);

/* Set the current colour: alpha = 1 where not given; the range of unsigned integers maps to [0, 1], that of
 * signed ones to [-1, 1]. IV if `v` is NULL. */
RTAPI void RTAPIENTRY rtColor3b(RTbyte red, RTbyte green, RTbyte blue);
RTAPI void RTAPIENTRY rtColor3s(RTshort red, RTshort green, RTshort blue);
RTAPI void RTAPIENTRY rtColor3i(RTint red, RTint green, RTint blue);
RTAPI void RTAPIENTRY rtColor3ub(RTubyte red, RTubyte green, RTubyte blue);
RTAPI void RTAPIENTRY rtColor3us(RTushort red, RTushort green, RTushort blue);
RTAPI void RTAPIENTRY rtColor3ui(RTuint red, RTuint green, RTuint blue);
RTAPI void RTAPIENTRY rtColor3f(RTfloat red, RTfloat green, RTfloat blue);
RTAPI void RTAPIENTRY rtColor3d(RTdouble red, RTdouble green, RTdouble blue);
RTAPI void RTAPIENTRY rtColor4b(RTbyte red, RTbyte green, RTbyte blue, RTbyte alpha);
RTAPI void RTAPIENTRY rtColor4s(RTshort red, RTshort green, RTshort blue, RTshort alpha);
RTAPI void RTAPIENTRY rtColor4i(RTint red, RTint green, RTint blue, RTint alpha);
RTAPI void RTAPIENTRY rtColor4ub(RTubyte red, RTubyte green, RTubyte blue, RTubyte alpha);
RTAPI void RTAPIENTRY rtColor4us(RTushort red, RTushort green, RTushort blue, RTushort alpha);
RTAPI void RTAPIENTRY rtColor4ui(RTuint red, RTuint green, RTuint blue, RTuint alpha);
RTAPI void RTAPIENTRY rtColor4f(RTfloat red, RTfloat green, RTfloat blue, RTfloat alpha);
RTAPI void RTAPIENTRY rtColor4d(RTdouble red, RTdouble green, RTdouble blue, RTdouble alpha);
RTAPI void RTAPIENTRY rtColor3bv(const RTbyte *v);
RTAPI void RTAPIENTRY rtColor3sv(const RTshort *v);
RTAPI void RTAPIENTRY rtColor3iv(const RTint *v);
RTAPI void RTAPIENTRY rtColor3ubv(const RTubyte *v);
RTAPI void RTAPIENTRY rtColor3usv(const RTushort *v);
RTAPI void RTAPIENTRY rtColor3uiv(const RTuint *v);
RTAPI void RTAPIENTRY rtColor3fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtColor3dv(const RTdouble *v);
RTAPI void RTAPIENTRY rtColor4bv(const RTbyte *v);
RTAPI void RTAPIENTRY rtColor4sv(const RTshort *v);
RTAPI void RTAPIENTRY rtColor4iv(const RTint *v);
RTAPI void RTAPIENTRY rtColor4ubv(const RTubyte *v);
RTAPI void RTAPIENTRY rtColor4usv(const RTushort *v);
RTAPI void RTAPIENTRY rtColor4uiv(const RTuint *v);
RTAPI void RTAPIENTRY rtColor4fv(const RTfloat *v);
RTAPI void RTAPIENTRY rtColor4dv(const RTdouble *v);

/* ---- Shader classes, shaders and parameters ------------------------------------------------------------------ */

/* Loads the shader class `name` from the shared library `file` (openrt/rts.h says how to write one), or the built-in
 * one if `file` is NULL or empty; binds the class, unbinds the shader and returns the class's id. A `file` without '/'
 * is looked for in the folders of $OPENRT_SHADER_PATH, by the system's loader, and in the working directory. BE; IV if
 * name, file or class is missing, see rtGetShaderClassInfoLog; IO if the library does not fit. */
RTAPI RTuint RTAPIENTRY rtGenNewShaderClass(const char *name, const char *file);

/* Binds a class and unbinds the shader. BE; IO unknown id. */
RTAPI void RTAPIENTRY rtBindShaderClass(RTuint shader_class);

/* Makes a shader of the bound class with the class's defaults, binds it and returns its id. BE; IO without class. IO,
 * too, if a plugin's `init` throws an exception, see rtGetShaderClassInfoLog. */
RTAPI RTuint RTAPIENTRY rtGenNewShader(void);

/* Binds a shader and its class; the current values of per-triangle and per-vertex parameters start from the
 * class's defaults. BE; IO unknown id. */
RTAPI void RTAPIENTRY rtBindShader(RTuint shader);

/* Returns the handle of a parameter of the bound class; it serves all shaders of the class. BE; IV if `name` is
 * NULL; IO without class; IV unknown name. */
RTAPI RTuint RTAPIENTRY rtParameterHandle(const char *name);

/* Set a parameter: that of the bound shader, or the current per-triangle or per-vertex value, as the class
 * declares. Per-triangle values are taken when a triangle's last vertex is given, per-vertex values with each
 * vertex. IV if a pointer is NULL; IV unknown handle; IO if the handle is of another class than the bound one,
 * the parameter has another type or size, or it is per shader and no shader is bound. */
RTAPI void RTAPIENTRY rtParameter1f(RTuint handle, RTfloat x);
RTAPI void RTAPIENTRY rtParameter2f(RTuint handle, RTfloat x, RTfloat y);
RTAPI void RTAPIENTRY rtParameter3f(RTuint handle, RTfloat x, RTfloat y, RTfloat z);
RTAPI void RTAPIENTRY rtParameter4f(RTuint handle, RTfloat x, RTfloat y, RTfloat z, RTfloat w);
RTAPI void RTAPIENTRY rtParameter16f(RTuint handle, RTfloat m0, RTfloat m1, RTfloat m2, RTfloat m3,
    RTfloat m4, RTfloat m5, RTfloat m6, RTfloat m7,
    RTfloat m8, RTfloat m9, RTfloat m10, RTfloat m11,
    RTfloat m12, RTfloat m13, RTfloat m14, RTfloat m15);
RTAPI void RTAPIENTRY rtParameter1fv(RTuint handle, const RTfloat *v);
RTAPI void RTAPIENTRY rtParameter2fv(RTuint handle, const RTfloat *v);
RTAPI void RTAPIENTRY rtParameter3fv(RTuint handle, const RTfloat *v);
RTAPI void RTAPIENTRY rtParameter4fv(RTuint handle, const RTfloat *v);
RTAPI void RTAPIENTRY rtParameter16fv(RTuint handle, const RTfloat *v);
RTAPI void RTAPIENTRY rtParameter1i(RTuint handle, RTint x);
RTAPI void RTAPIENTRY rtParameter2i(RTuint handle, RTint x, RTint y);
RTAPI void RTAPIENTRY rtParameter3i(RTuint handle, RTint x, RTint y, RTint z);
RTAPI void RTAPIENTRY rtParameter4i(RTuint handle, RTint x, RTint y, RTint z, RTint w);
RTAPI void RTAPIENTRY rtParameter2iv(RTuint handle, const RTint *v);
RTAPI void RTAPIENTRY rtParameter3iv(RTuint handle, const RTint *v);
RTAPI void RTAPIENTRY rtParameter4iv(RTuint handle, const RTint *v);
RTAPI void RTAPIENTRY rtParameter1d(RTuint handle, RTdouble x);

/* Sets a parameter from the bytes of its value; errors as above, IO if `size` is not that of the parameter. */
RTAPI void RTAPIENTRY rtParameterRaw(RTuint handle, const void *value, RTuint size);

/* Sets a parameter of type RT_STRING to a copy of `text`; errors as above. */
RTAPI void RTAPIENTRY rtParameterString(RTuint handle, const char *text);

/* Writes the value that the bound shader has, or that the next triangle or vertex would take, as floats. BE;
 * errors as rtParameter*. */
RTAPI void RTAPIENTRY rtGetParameterfv(RTuint handle, RTfloat *values);

/* Deletes a shader's id; geometry, camera and lights that use it keep it. Unbinds it if it is bound. BE; IV. */
RTAPI void RTAPIENTRY rtDeleteShader(RTuint shader);

/* Why the last rtGenNewShaderClass failed, or what plugins did wrong in a shader or a frame since; empty if nothing went wrong.
 * Valid until the next call of that function, of one that starts or ends a frame, or of rtExit. NULL on error: BE. */
RTAPI const char *RTAPIENTRY rtGetShaderClassInfoLog(void);

/* ---- Textures ------------------------------------------------------------------------------------------------ */

/* Reserves `count` consecutive texture ids and returns the first; shader parameters name textures by these ids.
 * BE; IV if count < 1; RT_OUT_OF_MEMORY when ids run out. */
RTAPI RTuint RTAPIENTRY rtGenTextures(RTsizei count);

/* Binds a texture for the calls below; 0 binds none. BE; IE target; IV unknown id. */
RTAPI void RTAPIENTRY rtBindTexture(RTenum target, RTuint texture);

/* Copies an image into the bound texture: tight rows, the first one at t = 0; integers are linear, their range
 * maps to [0, 1]; floats are not clamped. Levels above 0 are checked and ignored. BE; IV if `texels` is NULL; IE
 * target, format or type; IV level, internal format, size or border; IO without bound texture; RT_OUT_OF_MEMORY if there
 * is no room for it. */
RTAPI void RTAPIENTRY rtTexImage2D(RTenum target, RTint level, RTint internal_format, RTsizei width, RTsizei height,
    RTint border, RTenum format, RTenum type, const void *texels);

/* RT_TEXTURE_MAG_FILTER: RT_NEAREST, RT_LINEAR (initial). RT_TEXTURE_MIN_FILTER, for points that stand for more than a texel:
 * RT_NEAREST, RT_LINEAR (initial), RT_NEAREST_MIPMAP_NEAREST, RT_LINEAR_MIPMAP_NEAREST, RT_NEAREST_MIPMAP_LINEAR,
 * RT_LINEAR_MIPMAP_LINEAR; smaller copies are made of level 0. RT_TEXTURE_WRAP_S, RT_TEXTURE_WRAP_T: RT_REPEAT (initial),
 * RT_CLAMP = RT_CLAMP_TO_EDGE, RT_MIRRORED_REPEAT. BE; IE; IO without bound texture. */
RTAPI void RTAPIENTRY rtTexParameteri(RTenum target, RTenum name, RTint value);

/* Deletes a texture; shaders that name it see white from the next frame on. BE; IV. */
RTAPI void RTAPIENTRY rtDeleteTexture(RTuint texture);

/* ---- Lights, camera and environment -------------------------------------------------------------------------- */

/* Adds a light shader to the scene. BE; IV unknown id; IO if it is no light or in use already. */
RTAPI void RTAPIENTRY rtUseLight(RTuint shader);

/* The same without looking whether it is in use: it then shines twice. BE; IV; IO if it is no light. */
RTAPI void RTAPIENTRY rtUseLightFast(RTuint shader);

/* Takes a light out of the scene, however often it was added. BE; IV if it is not in use. */
RTAPI void RTAPIENTRY rtRemoveLight(RTuint shader);

/* Sets the camera instead of the default one. BE; IV; IO if it is no camera shader. */
RTAPI void RTAPIENTRY rtUseCamera(RTuint shader);

/* Sets what rays see that hit nothing; black without. BE; IV; IO if it is no environment shader. */
RTAPI void RTAPIENTRY rtUseEnvironmentShader(RTuint shader);

/* Sets how pictures are made: a shader of class Whitted, Eyelight or another rendering object, see openrt.md. BE;
 * IV; IO if it is none. */
RTAPI void RTAPIENTRY rtUseRenderingObject(RTuint shader);

/* Places the default camera, initially at the origin, looking along -z, y upwards. BE; IV if eye and centre
 * coincide or a value is not finite. */
RTAPI void RTAPIENTRY rtLookAt(RTdouble eyex, RTdouble eyey, RTdouble eyez, RTdouble centerx, RTdouble centery,
    RTdouble centerz, RTdouble upx, RTdouble upy, RTdouble upz);

/* Replaces the RT_PROJECTION matrix, the default camera's: vertical angle of view in degrees, initially 60; the
 * aspect is that of the frame buffer; nothing is clipped at zNear and zFar. BE; IV unless 0 < fovy < 180. */
RTAPI void RTAPIENTRY rtPerspective(RTdouble fovy, RTdouble zNear, RTdouble zFar);

/* Multiply to the right of the RT_PROJECTION matrix as glFrustum and glOrtho do. Rays of a perspective begin at
 * the eye, parallel rays at zNear. BE; IV as in OpenGL. */
RTAPI void RTAPIENTRY rtFrustum(RTdouble left, RTdouble right, RTdouble bottom, RTdouble top,
    RTdouble zNear, RTdouble zFar);
RTAPI void RTAPIENTRY rtOrtho(RTdouble left, RTdouble right, RTdouble bottom, RTdouble top,
    RTdouble zNear, RTdouble zFar);

#ifdef __cplusplus
} /* extern "C" */

/* The one-argument form of rtNewObject. */
static inline RTuint rtNewObject(RTenum mode) { return rtCreateObject(mode); }
#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 199901L
/* rtNewObject(id, mode) and rtNewObject(mode); (rtNewObject)(id, mode) and &rtNewObject reach the function. */
#define RT_NEWOBJ_PICK(a, b, f, ...) f
#define rtNewObject(...) RT_NEWOBJ_PICK(__VA_ARGS__, rtNewObject, rtCreateObject, 0)(__VA_ARGS__)
#endif

#endif /* OPENRT_RT_H */
