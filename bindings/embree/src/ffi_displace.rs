// SPDX-License-Identifier: GPL-3.0-or-later
//! The program's function that moves points of a subdivision surface. Source: Embree's manual.
//! Arrays begin at multiples of 64 bytes and have room up to the next; exceptions end here. Tests: `tests/c/subdivision.c`.

use std::sync::Arc;

use crate::ffi_abi::{DisplacementArguments, DisplacementFunction};
use crate::ffi_catch::{self, Thrown};
use crate::objects::Geometry;

/// Sixteen numbers at a multiple of 64 bytes.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Sixteen([f32; 16]);

/// A point of a face: its parameters, the normal and the position there.
pub(crate) type Point = ([f32; 2], [f32; 3], [f32; 3]);

/// Lets the program move points of a face.
pub(crate) fn displace(
    function: DisplacementFunction,
    geometry: &Arc<Geometry>,
    prim_id: u32,
    time_step: u32,
    points: &mut [Point],
) -> Result<(), Thrown> {
    let Some(function) = function else { return Ok(()) };
    let blocks = points.len().div_ceil(16).max(1);
    let mut memory = vec![Sixteen([0.0; 16]); 8 * blocks];
    let start: *mut f32 = memory.as_mut_ptr().cast();
    let array = |i: usize| start.wrapping_add(i * blocks * 16);
    for (i, (uv, normal, position)) in points.iter().enumerate() {
        for (k, &x) in uv.iter().chain(normal).chain(position).enumerate() {
            // SAFETY: eight arrays of as many numbers as there are points, or more.
            unsafe { array(k).add(i).write(x) }
        }
    }
    let arguments = DisplacementArguments {
        user_data: geometry.user_data(),
        geometry: Arc::as_ptr(geometry).cast_mut().cast(),
        prim_id,
        time_step,
        u: array(0),
        v: array(1),
        normal: [array(2), array(3), array(4)],
        position: [array(5), array(6), array(7)],
        n: points.len() as u32,
    };
    // SAFETY: the program gave the function to be called like this; the arrays live during the call.
    ffi_catch::call(|| unsafe { function(&raw const arguments) })?;
    for (i, (_, _, position)) in points.iter_mut().enumerate() {
        for (k, x) in position.iter_mut().enumerate() {
            // SAFETY: as above; read again because the program wrote through pointers.
            *x = unsafe { array(5 + k).add(i).read_volatile() };
        }
    }
    Ok(())
}
