/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * Shapes and a window for programs that use OpenRT.
 *
 * Copyright (C) the GNU RT authors. This file is part of GNU RT, which is free software: you can redistribute it
 * and/or modify it under the terms of the GNU General Public License as published by the Free Software Foundation,
 * either version 3 of the License, or (at your option) any later version. It comes WITHOUT ANY WARRANTY; see the
 * file COPYING for details.
 *
 * Additional permission under section 7 of the GNU General Public License, version 3: including this header,
 * unmodified, in the source of a shader plugin or of any other work, and compiling the types, constants, macros
 * and inline functions that it defines into that work, does not by itself cause the work to be covered by the
 * GNU General Public License. The library librtut itself remains covered by it.
 */
#ifndef OPENRT_RTUT_H
#define OPENRT_RTUT_H

#include <openrt/types.h>

/*
 * Shapes. Each call gives triangles to where rtBegin would give them: to the open object or to the next frame. It wants a
 * surface shader bound and sets the current normal and texture coordinates; vertices go through the RT_MODELVIEW and
 * RT_TEXTURE matrices as always. Triangles are counter-clockwise seen from outside and have unit normals outwards.
 * A call whose arguments are out of range does nothing. Errors are those of the rt* calls made: rtGetError tells.
 * Link with -lrtut -lOpenRT.
 */

#ifdef __cplusplus
extern "C" {
#endif

/* A sphere of radius 1 at the origin, its poles on the z axis. `slices` around the axis, at least 3; `stacks` from
 * pole to pole, at least 2; at most 32768 each: 2 slices (stacks - 1) triangles. s runs around from +x to +y, t from 0
 * at the pole -z to 1 at +z. */
RTAPI void RTAPIENTRY rtutSphere(RTint slices, RTint stacks);

/* A cube of edge 2 at the origin: 12 triangles, flat. Each face shows the texture from (0, 0) to (1, 1). */
RTAPI void RTAPIENTRY rtutCube(void);

/* A torus around the z axis: a tube of radius r > 0 whose middle is a circle of radius R > r. `sides` around the tube and
 * `rings` around the axis, 3 to 32768 each: 2 sides rings triangles. s runs around the axis, t around the tube. */
RTAPI void RTAPIENTRY rtutTorus(RTdouble r, RTdouble R, RTint sides, RTint rings);

/* The Utah teapot with its bottom, lid upwards along +y, spout towards +x. At `size` 1, which must be positive, it is
 * about 1.6 high and 3.2 long, around the origin, as OpenGL programs know it. Every patch shows the texture from (0, 0) to
 * (1, 1). It is not closed: lid, body, handle and spout only touch. */
RTAPI void RTAPIENTRY rtutTeapot(RTdouble size);

/* The GNU RT logo, without letters: a triangular ring in the xy plane, within a circle of radius 1 at the origin,
 * around a ball. */
RTAPI void RTAPIENTRY rtutLogo(void);

/*
 * A window, in the manner of GLUT: the program gives functions, rtutMainLoop calls them, one at a time, from the thread
 * that called it, which must be the program's main thread. They may call everything but rtutMainLoop. NULL takes a
 * function away. An exception of C++ that leaves a function passes through rtutMainLoop to the program's own handler. A program's shape:
 *
 *     static void display(void) { ...edit the scene...; rtutSwapBuffers(); }
 *     int main(void) { rtutInitWindow(640, 480, "A scene"); rtutDisplayFunc(display); return !rtutMainLoop(); }
 *
 * Environment: RTUT_HEADLESS=1 runs without a window, RTUT_FRAMES=N leaves after N pictures (without a window 1 unless
 * given), RTUT_SAVE=PREFIX writes each picture to PREFIX000.ppm, PREFIX001.ppm, and so on.
 */

/* Asks for a window of `width` by `height` pixels, at most 16384 each, whose title is the UTF-8 text `title` (NULL: none).
 * It opens when rtutMainLoop begins. Sizes out of range are ignored. */
RTAPI void RTAPIENTRY rtutInitWindow(RTint width, RTint height, const char *title);

/* Runs until the window is closed, rtutLeaveMainLoop is called or RTUT_FRAMES pictures were shown. RT_FALSE if it could
 * not: there is no display, rtutInitWindow was not called, a picture could not be written, or this is the second time in
 * a program that had a window. */
RTAPI RTboolean RTAPIENTRY rtutMainLoop(void);

/* Lets rtutMainLoop return after the function that calls this; from another thread, soon. */
RTAPI void RTAPIENTRY rtutLeaveMainLoop(void);

/* Why the last rtutMainLoop could not, or ""; valid until the next one ends. */
RTAPI const char *RTAPIENTRY rtutErrorString(void);

/* `function` is called when a frame is wanted: at first, after rtutPostRedisplay, and when the size has changed. */
RTAPI void RTAPIENTRY rtutDisplayFunc(void (*function)(void));

/* `function` is called whenever there is nothing else to do. Programs that animate call rtutPostRedisplay in it. */
RTAPI void RTAPIENTRY rtutIdleFunc(void (*function)(void));

/* `function` is called with the size of the window, at first and when it changes. */
RTAPI void RTAPIENTRY rtutReshapeFunc(void (*function)(RTint width, RTint height));

/* `function` is called when a key with a character of Latin-1 is pressed (27 = Esc, 13 = Enter, 8 = Backspace, 9 = Tab,
 * 127 = Delete); x and y are the pixel the pointer is at, counted from the upper left one, here and below. */
RTAPI void RTAPIENTRY rtutKeyboardFunc(void (*function)(RTubyte key, RTint x, RTint y));

/* `function` is called when another key is pressed: RTUT_KEY_LEFT and so on. */
RTAPI void RTAPIENTRY rtutSpecialFunc(void (*function)(RTint key, RTint x, RTint y));

/* `function` is called when a mouse button goes down (RTUT_DOWN) or up (RTUT_UP); a notch of the wheel is both. */
RTAPI void RTAPIENTRY rtutMouseFunc(void (*function)(RTint button, RTint state, RTint x, RTint y));

/* `function` is called when the pointer moves while a button is down. */
RTAPI void RTAPIENTRY rtutMotionFunc(void (*function)(RTint x, RTint y));

/* `function` is called when it moves while none is. */
RTAPI void RTAPIENTRY rtutPassiveMotionFunc(void (*function)(RTint x, RTint y));

/* Asks for another frame: the function of rtutDisplayFunc is called soon, once for any number of calls, by the
 * thread that is in rtutMainLoop. May be called from any thread. */
RTAPI void RTAPIENTRY rtutPostRedisplay(void);

/* Ends the frame that the last call began, if any, and shows it; then gives libOpenRT a frame buffer of the window's size
 * and begins the next frame: what is edited while it is rendered shows in the frame after it. A frame that no other follows
 * is shown as soon as it is done. A call that fails has no effect; errors are those of rtEndRendering, rtSetFrameBuffer and
 * rtStartRendering. Called from within itself, by the function of rtDebugCallback, it has no effect. */
RTAPI void RTAPIENTRY rtutSwapBuffers(void);

/* Shows a frame buffer of the program, which rendered it itself, in any format of rtSetFrameBuffer; formats of floats are
 * encoded as sRGB. Bad formats, sizes out of range and NULL show nothing. */
RTAPI void RTAPIENTRY rtutShowPixels(const RTubyte *pixels, RTuint width, RTuint height, RTenum format);

/* The size of the window. */
RTAPI RTint RTAPIENTRY rtutWindowWidth(void);
RTAPI RTint RTAPIENTRY rtutWindowHeight(void);

/* Milliseconds since rtutMainLoop began; without a window 40 for each frame that was begun, so that each run shows the
 * same. */
RTAPI RTint RTAPIENTRY rtutElapsedTime(void);

#define RTUT_LEFT_BUTTON 0
#define RTUT_MIDDLE_BUTTON 1
#define RTUT_RIGHT_BUTTON 2
#define RTUT_WHEEL_UP 3
#define RTUT_WHEEL_DOWN 4
#define RTUT_DOWN 0
#define RTUT_UP 1
#define RTUT_KEY_F1 1 /* to F12: 12 */
#define RTUT_KEY_LEFT 100
#define RTUT_KEY_UP 101
#define RTUT_KEY_RIGHT 102
#define RTUT_KEY_DOWN 103
#define RTUT_KEY_PAGE_UP 104
#define RTUT_KEY_PAGE_DOWN 105
#define RTUT_KEY_HOME 106
#define RTUT_KEY_END 107
#define RTUT_KEY_INSERT 108

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* OPENRT_RTUT_H */
