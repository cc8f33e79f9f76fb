/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * Shapes for programs that use OpenRT.
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
 * Each call gives triangles to where rtBegin would give them: to the open object or to the next frame. It wants a
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

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* OPENRT_RTUT_H */
