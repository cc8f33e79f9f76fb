// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcInterpolate`: values between the corners of triangles and quads. Source: Embree's manual.
//! Takes a lock that readers share, and no memory: programs call it for each hit. Tests: `tests/c/embree.c`.

use std::sync::Arc;

use crate::device::Problem;
use crate::ffi_abi::{InterpolateArguments, buffer};
use crate::ffi_arrays::no_array;
use crate::ffi_handle::{Handle, with};
use crate::objects::{Geometry, Kind};

/// Corners of a triangle: the one with the remaining weight, and those weighted by u and v; and the
/// directions in which these grow.
struct Corners {
    of: [u32; 3],
    u: f32,
    v: f32,
    sign: f32,
}

/// Computes values, and writes the requested ones.
///
/// # Safety
/// Each pointer is null or has memory for all values.
unsafe fn interpolate(geometry: &Geometry, arguments: &InterpolateArguments) -> Result<(), Problem> {
    let &InterpolateArguments { prim_id, u, v, buffer_type, slot, count, .. } = arguments;
    let settings = geometry.settings();
    let array = |of, slot| settings.arrays.get(&(of, slot)).ok_or_else(|| no_array(of, slot));
    let (rows, indices) = (&array(buffer_type, slot)?.view, &array(buffer::INDEX, 0)?.view);
    let none = || Problem::argument(format!("primitive {prim_id} is out of range"));
    let prim_id = prim_id as usize;
    let corners = match geometry.kind {
        Kind::Triangles => Corners { of: indices.get::<u32, 3>(prim_id).ok_or_else(none)?, u, v, sign: 1.0 },
        Kind::Quads => {
            let [a, b, c, d] = indices.get::<u32, 4>(prim_id).ok_or_else(none)?;
            if u + v <= 1.0 {
                Corners { of: [a, b, d], u, v, sign: 1.0 }
            } else {
                Corners { of: [c, d, b], u: 1.0 - u, v: 1.0 - v, sign: -1.0 }
            }
        }
        kind => return Err(Problem::operation(format!("interpolation is unsupported for {kind:?}"))),
    };
    let Corners { of, u, v, sign } = corners;
    let at = |corner: u32, k: usize| {
        rows.number::<f32>(corner as usize, k)
            .ok_or_else(|| Problem::argument(format!("value {k} of vertex {corner} is not in the buffer")))
    };
    // All or nothing: rows are as wide as their last value.
    for corner in of.into_iter().filter(|_| count > 0) {
        at(corner, count as usize - 1)?;
    }
    for k in 0..count as usize {
        let [a, b, c] = [at(of[0], k)?, at(of[1], k)?, at(of[2], k)?];
        let put = |to: *mut f32, value: f32| {
            if !to.is_null() {
                // SAFETY: the caller vouches for the room.
                unsafe { to.add(k).write(value) }
            }
        };
        put(arguments.values, (1.0 - u - v) * a + u * b + v * c);
        put(arguments.first[0], sign * (b - a));
        put(arguments.first[1], sign * (c - a));
        arguments.second.iter().for_each(|&to| put(to, 0.0));
    }
    Ok(())
}

/// Values between the corners of a triangle or a quad. See Embree's manual.
///
/// # Safety
/// As Embree's headers say: a geometry, and room for so many values wherever a pointer is not null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcInterpolate(arguments: *const InterpolateArguments) {
    if arguments.is_null() {
        return;
    }
    // SAFETY: passed on.
    let arguments = unsafe { &*arguments };
    let geometry: Handle = arguments.geometry;
    // SAFETY: passed on.
    unsafe { with::<Geometry, ()>(geometry, |geometry: &Arc<Geometry>| interpolate(geometry, arguments)) }
}
