/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * Types and constants of the OpenRT API.
 *
 * Copyright (C) the GNU RT authors. This file is part of GNU RT, which is free software: you can redistribute it
 * and/or modify it under the terms of the GNU General Public License as published by the Free Software Foundation,
 * either version 3 of the License, or (at your option) any later version. It comes WITHOUT ANY WARRANTY; see the
 * file COPYING for details.
 *
 * Additional permission under section 7 of the GNU General Public License, version 3: including this header,
 * unmodified, in the source of a shader plugin or of any other work, and compiling the types, constants, macros
 * and inline functions that it defines into that work, does not by itself cause the work to be covered by the
 * GNU General Public License. Shader plugins that use only rts.h and this header may carry
 * any licence.
 */
#ifndef OPENRT_TYPES_H
#define OPENRT_TYPES_H

/* RTAPI marks what libOpenRT exports, RTAPIENTRY its calling convention. */
#if defined(_WIN32)
#define RTAPI extern __declspec(dllimport)
#else
#define RTAPI extern
#endif
#define RTAPIENTRY

typedef unsigned int RTenum;        /* one of the RT_ constants below */
typedef unsigned char RTboolean;    /* 0 = false, anything else = true */
typedef RTboolean RTbool;
typedef unsigned int RTbitfield;
typedef void RTvoid;
typedef signed char RTbyte;
typedef short RTshort;
typedef int RTint;
typedef unsigned char RTubyte;
typedef RTubyte RTuchar;
typedef unsigned short RTushort;
typedef unsigned int RTuint;
typedef int RTsizei;                /* a number of things */
typedef float RTfloat;
typedef float RTclampf;             /* in [0, 1] */
typedef double RTdouble;
typedef double RTclampd;            /* in [0, 1] */
typedef long RTlong;                /* as large as the platform says: no function below uses these two */
typedef unsigned long RTulong;

/* What rtDebugCallback calls: the error, the call with its arguments, the program's pointer. */
typedef void (*RTdebugproc)(RTenum error, const char *call, void *user);

#define RT_FALSE 0u
#define RT_TRUE 1u

/* The upper 24 bits of a constant say to which group it belongs. */
#define RT_TYPE_OF(value) ((value) & 0xFFFFFF00u)

/* Groups. */
#define RT_TYPE_GEOMETRY_MODE 0x100u
#define RT_TYPE_NEWOBJECT_MODE 0x200u
#define RT_TYPE_FB_FORMAT 0x300u
#define RT_TYPE_SHADERTYPE 0x400u
#define RT_TYPE_DATATYPE 0x1400u
#define RT_TYPE_ERROR 0xFFFFFE00u
#define RT_TYPE_INVALID 0xFFFFFF00u

/* Errors, see rtGetError. */
#define RT_NO_ERROR 0u
#define RT_INVALID_ENUM 0xFFFFFE01u
#define RT_INVALID_VALUE 0xFFFFFE02u
#define RT_INVALID_OPERATION 0xFFFFFE03u
#define RT_STACK_OVERFLOW 0xFFFFFE04u
#define RT_STACK_UNDERFLOW 0xFFFFFE05u
#define RT_OUT_OF_MEMORY 0xFFFFFE06u

/* What calls that return an id give when they fail; 0 is never an id either. */
#define RT_INVALID 0xFFFFFFFFu

/* Primitives, see rtBegin. */
#define RT_TRIANGLES 0x100u
#define RT_TRIANGLE_STRIP 0x101u
#define RT_TRIANGLE_FAN 0x102u
#define RT_QUADS 0x103u
#define RT_QUAD_STRIP 0x104u
#define RT_POLYGON 0x105u

/* Modes of rtNewObject. */
#define RT_DEFINE 0x200u
#define RT_COMPILE 0x200u
#define RT_DEFINE_AND_INSTANTIATE 0x201u
#define RT_UPDATE 0x202u

/* Frame buffer formats: three or four 32-bit floats (linear, unclamped) or 8-bit numbers (sRGB, clamped). */
#define RT_BGR_32 0x300u
#define RT_RGB_32 0x301u
#define RT_RGBA_32 0x302u
#define RT_BGRA_32 0x303u
#define RT_RGB_8 0x310u
#define RT_RGBA_8 0x311u
#define RT_BGR_8 0x312u
#define RT_BGRA_8 0x313u

/* Kinds of shaders. */
#define RT_SURFACE_SHADER 0x400u
#define RT_ENV_SHADER 0x401u
#define RT_LIGHT_SHADER 0x402u
#define RT_CAMERA_SHADER 0x403u
#define RT_RENDERING_OBJECT 0x404u

/* Rates of shader parameters. */
#define RT_PER_SHADER 0x500u
#define RT_PER_VERTEX 0x501u
#define RT_PER_TRIANGLE 0x502u

/* Scene modes. */
#define RT_RETAINED 0x600u
#define RT_IMMEDIATE 0x601u

/* Data types. */
#define RT_BYTE 0x1400u
#define RT_UNSIGNED_BYTE 0x1401u
#define RT_SHORT 0x1402u
#define RT_UNSIGNED_SHORT 0x1403u
#define RT_INT 0x1404u
#define RT_UNSIGNED_INT 0x1405u
#define RT_FLOAT 0x1406u
#define RT_2_BYTES 0x1407u
#define RT_3_BYTES 0x1408u
#define RT_4_BYTES 0x1409u
#define RT_DOUBLE 0x140Au
#define RT_STRING 0x140Bu

/* Matrix modes. */
#define RT_MODELVIEW 0x1700u
#define RT_PROJECTION 0x1701u
#define RT_TEXTURE 0x1702u

/* Textures. */
#define RT_TEXTURE_2D 0x0DE1u
#define RT_RGB 0x1907u
#define RT_RGBA 0x1908u
#define RT_LUMINANCE 0x1909u
#define RT_BGR 0x80E0u
#define RT_BGRA 0x80E1u
#define RT_TEXTURE_MAG_FILTER 0x2800u
#define RT_TEXTURE_MIN_FILTER 0x2801u
#define RT_TEXTURE_WRAP_S 0x2802u
#define RT_TEXTURE_WRAP_T 0x2803u
#define RT_NEAREST 0x2600u
#define RT_LINEAR 0x2601u
#define RT_NEAREST_MIPMAP_NEAREST 0x2700u
#define RT_LINEAR_MIPMAP_NEAREST 0x2701u
#define RT_NEAREST_MIPMAP_LINEAR 0x2702u
#define RT_LINEAR_MIPMAP_LINEAR 0x2703u
#define RT_CLAMP 0x2900u
#define RT_REPEAT 0x2901u
#define RT_CLAMP_TO_EDGE 0x812Fu
#define RT_MIRRORED_REPEAT 0x8370u

/* Strings of rtGetString. */
#define RT_VENDOR 0x1F00u
#define RT_RENDERER 0x1F01u
#define RT_VERSION 0x1F02u
#define RT_EXTENSIONS 0x1F03u

/* What rtFrameBufferUse gives the sum of. */
#define RT_NEXT_FRAME_BIT 0x1u
#define RT_IN_FLIGHT_BIT 0x2u

/* Values of rtGetIntegerv and rtGetFloatv; how many numbers each gives. */
#define RT_CURRENT_COLOR 0x0B00u /* 4 */
#define RT_CURRENT_NORMAL 0x0B02u /* 3 */
#define RT_CURRENT_TEXTURE_COORDS 0x0B03u /* 4 */
#define RT_MATRIX_MODE 0x0BA0u /* 1 */
#define RT_MODELVIEW_MATRIX 0x0BA6u /* 16, column by column */
#define RT_PROJECTION_MATRIX 0x0BA7u /* 16 */
#define RT_TEXTURE_MATRIX 0x0BA8u /* 16 */
#define RT_OBJECT_COUNT 0x0700u /* 1: objects that have been defined */
#define RT_TRIANGLE_COUNT 0x0701u /* 1: triangles of the objects that have been defined */
#define RT_INSTANCE_COUNT 0x0702u /* 1: instances */
#define RT_SAMPLE_COUNT 0x0703u /* 1: samples that each pixel of the frame that ended last has */

#endif /* OPENRT_TYPES_H */
