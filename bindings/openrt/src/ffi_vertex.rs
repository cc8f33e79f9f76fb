// SPDX-License-Identifier: GPL-3.0-or-later
//! Exported calls: vertices and their attributes, in all their forms. One line per pair of functions: by
//! value, by pointer, the numbers' type, the names given, all numbers. Cost: one uncontended lock per call,
//! no allocation beyond the growth of arrays.
//! Tests: tests/c/scene.c; tests/c/many_vertices.c (time).

use crate::context::Context;
use crate::ffi::call;
use crate::ffi_pointers::array;
use crate::state::error::{Error, Result};

macro_rules! family {
    ($set:path, $number:ident;
     $($by_value:ident $by_pointer:ident $type:ty: ($($given:ident),+) => [$($all:expr),+];)*) => {$(
        #[unsafe(no_mangle)]
        extern "C-unwind" fn $by_value($($given: $type),+) {
            call!($by_value($($given),+), (), |context| {
                $(let $given = $number::from_c($given);)+
                $set(context, [$($all),+])
            });
        }

        /// # Safety
        /// As openrt/rt.h says: the pointer is null or points to as many numbers as the name says.
        #[unsafe(no_mangle)]
        unsafe extern "C-unwind" fn $by_pointer(numbers: *const $type) {
            // SAFETY: the caller vouches for the numbers.
            let numbers: Option<[$type; [$(stringify!($given)),+].len()]> = unsafe { array(numbers) };
            call!($by_pointer(numbers), (), |context| {
                let [$($given),+] = numbers.ok_or(Error::InvalidValue)?;
                $(let $given = $number::from_c($given);)+
                $set(context, [$($all),+])
            });
        }
    )*};
}

/// Coordinates are taken as they are.
struct Coordinate;

impl Coordinate {
    fn from_c(number: impl Into<f64>) -> f64 {
        number.into()
    }
}

/// Colours: integers map their range to [0, 1], signed ones to [-1, 1].
struct Intensity;

impl Intensity {
    fn from_c<T: ColorNumber>(number: T) -> f32 {
        number.intensity()
    }
}

/// A number of a colour.
trait ColorNumber {
    fn intensity(self) -> f32;
}

macro_rules! color_numbers {
    ($($type:ty: |$number:ident| $intensity:expr;)*) => {$(
        impl ColorNumber for $type {
            #[inline]
            fn intensity(self) -> f32 {
                let $number = f64::from(self);
                let intensity: f64 = $intensity;
                intensity as f32
            }
        }
    )*};
}

color_numbers! {
    i8: |c| (2.0 * c + 1.0) / f64::from(u8::MAX);
    i16: |c| (2.0 * c + 1.0) / f64::from(u16::MAX);
    i32: |c| (2.0 * c + 1.0) / f64::from(u32::MAX);
    u8: |c| c / f64::from(u8::MAX);
    u16: |c| c / f64::from(u16::MAX);
    u32: |c| c / f64::from(u32::MAX);
    f32: |c| c;
    f64: |c| c;
}

fn normal(context: &mut Context, [x, y, z, _w]: [f64; 4]) -> Result<()> {
    context.normal([x, y, z]);
    Ok(())
}

fn tex_coord(context: &mut Context, texcoord: [f64; 4]) -> Result<()> {
    context.tex_coord(texcoord);
    Ok(())
}

fn color(context: &mut Context, color: [f32; 4]) -> Result<()> {
    context.color(color);
    Ok(())
}

family! {
    Context::vertex, Coordinate;
    rtVertex2s rtVertex2sv i16: (x, y) => [x, y, 0.0, 1.0];
    rtVertex2i rtVertex2iv i32: (x, y) => [x, y, 0.0, 1.0];
    rtVertex2f rtVertex2fv f32: (x, y) => [x, y, 0.0, 1.0];
    rtVertex2d rtVertex2dv f64: (x, y) => [x, y, 0.0, 1.0];
    rtVertex3s rtVertex3sv i16: (x, y, z) => [x, y, z, 1.0];
    rtVertex3i rtVertex3iv i32: (x, y, z) => [x, y, z, 1.0];
    rtVertex3f rtVertex3fv f32: (x, y, z) => [x, y, z, 1.0];
    rtVertex3d rtVertex3dv f64: (x, y, z) => [x, y, z, 1.0];
    rtVertex4s rtVertex4sv i16: (x, y, z, w) => [x, y, z, w];
    rtVertex4i rtVertex4iv i32: (x, y, z, w) => [x, y, z, w];
    rtVertex4f rtVertex4fv f32: (x, y, z, w) => [x, y, z, w];
    rtVertex4d rtVertex4dv f64: (x, y, z, w) => [x, y, z, w];
}

family! {
    normal, Coordinate;
    rtNormal2s rtNormal2sv i16: (x, y) => [x, y, 0.0, 0.0];
    rtNormal2i rtNormal2iv i32: (x, y) => [x, y, 0.0, 0.0];
    rtNormal2f rtNormal2fv f32: (x, y) => [x, y, 0.0, 0.0];
    rtNormal2d rtNormal2dv f64: (x, y) => [x, y, 0.0, 0.0];
    rtNormal3s rtNormal3sv i16: (x, y, z) => [x, y, z, 0.0];
    rtNormal3i rtNormal3iv i32: (x, y, z) => [x, y, z, 0.0];
    rtNormal3f rtNormal3fv f32: (x, y, z) => [x, y, z, 0.0];
    rtNormal3d rtNormal3dv f64: (x, y, z) => [x, y, z, 0.0];
    rtNormal4s rtNormal4sv i16: (x, y, z, w) => [x, y, z, w];
    rtNormal4i rtNormal4iv i32: (x, y, z, w) => [x, y, z, w];
    rtNormal4f rtNormal4fv f32: (x, y, z, w) => [x, y, z, w];
    rtNormal4d rtNormal4dv f64: (x, y, z, w) => [x, y, z, w];
}

family! {
    tex_coord, Coordinate;
    rtTexCoord1s rtTexCoord1sv i16: (s) => [s, 0.0, 0.0, 1.0];
    rtTexCoord1i rtTexCoord1iv i32: (s) => [s, 0.0, 0.0, 1.0];
    rtTexCoord1f rtTexCoord1fv f32: (s) => [s, 0.0, 0.0, 1.0];
    rtTexCoord1d rtTexCoord1dv f64: (s) => [s, 0.0, 0.0, 1.0];
    rtTexCoord2s rtTexCoord2sv i16: (s, t) => [s, t, 0.0, 1.0];
    rtTexCoord2i rtTexCoord2iv i32: (s, t) => [s, t, 0.0, 1.0];
    rtTexCoord2f rtTexCoord2fv f32: (s, t) => [s, t, 0.0, 1.0];
    rtTexCoord2d rtTexCoord2dv f64: (s, t) => [s, t, 0.0, 1.0];
    rtTexCoord3s rtTexCoord3sv i16: (s, t, r) => [s, t, r, 1.0];
    rtTexCoord3i rtTexCoord3iv i32: (s, t, r) => [s, t, r, 1.0];
    rtTexCoord3f rtTexCoord3fv f32: (s, t, r) => [s, t, r, 1.0];
    rtTexCoord3d rtTexCoord3dv f64: (s, t, r) => [s, t, r, 1.0];
    rtTexCoord4s rtTexCoord4sv i16: (s, t, r, q) => [s, t, r, q];
    rtTexCoord4i rtTexCoord4iv i32: (s, t, r, q) => [s, t, r, q];
    rtTexCoord4f rtTexCoord4fv f32: (s, t, r, q) => [s, t, r, q];
    rtTexCoord4d rtTexCoord4dv f64: (s, t, r, q) => [s, t, r, q];
}

family! {
    color, Intensity;
    rtColor3b rtColor3bv i8: (r, g, b) => [r, g, b, 1.0];
    rtColor3s rtColor3sv i16: (r, g, b) => [r, g, b, 1.0];
    rtColor3i rtColor3iv i32: (r, g, b) => [r, g, b, 1.0];
    rtColor3ub rtColor3ubv u8: (r, g, b) => [r, g, b, 1.0];
    rtColor3us rtColor3usv u16: (r, g, b) => [r, g, b, 1.0];
    rtColor3ui rtColor3uiv u32: (r, g, b) => [r, g, b, 1.0];
    rtColor3f rtColor3fv f32: (r, g, b) => [r, g, b, 1.0];
    rtColor3d rtColor3dv f64: (r, g, b) => [r, g, b, 1.0];
    rtColor4b rtColor4bv i8: (r, g, b, a) => [r, g, b, a];
    rtColor4s rtColor4sv i16: (r, g, b, a) => [r, g, b, a];
    rtColor4i rtColor4iv i32: (r, g, b, a) => [r, g, b, a];
    rtColor4ub rtColor4ubv u8: (r, g, b, a) => [r, g, b, a];
    rtColor4us rtColor4usv u16: (r, g, b, a) => [r, g, b, a];
    rtColor4ui rtColor4uiv u32: (r, g, b, a) => [r, g, b, a];
    rtColor4f rtColor4fv f32: (r, g, b, a) => [r, g, b, a];
    rtColor4d rtColor4dv f64: (r, g, b, a) => [r, g, b, a];
}
