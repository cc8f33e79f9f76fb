// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcInterpolate`, `rtcInterpolateN`: values between vertices. Source: Embree's manual.
//! Takes a lock that readers share. Tests: as of `interpolate.rs`.

use std::ffi::{c_int, c_uint};
use std::sync::Arc;

use crate::device::Problem;
use crate::ffi_abi::{InterpolateArguments, InterpolateManyArguments};
use crate::ffi_handle::{Handle, with};
use crate::interpolate::{Jet, Query, interpolate, rows};
use crate::objects::{Geometry, Settings};

/// Where values and their derivatives go: value `k` to number `k * stride + at`.
struct Room {
    pointers: [*mut f32; 6],
    stride: usize,
    at: usize,
}

impl Room {
    /// # Safety
    /// Each pointer is null or has memory for all values.
    unsafe fn put(&self, k: usize, jet: Jet) {
        for (to, value) in self.pointers.into_iter().zip(jet).filter(|(to, _)| !to.is_null()) {
            // SAFETY: the caller vouches for the room.
            unsafe { to.add(k * self.stride + self.at).write(value) }
        }
    }
}

fn pointers(values: *mut f32, first: [*mut f32; 2], second: [*mut f32; 3]) -> [*mut f32; 6] {
    let ([u, v], [uu, vv, uv]) = (first, second);
    [values, u, v, uu, vv, uv]
}

/// Runs a query.
///
/// # Safety
/// Rows have as many values as are asked for, where they are so far apart: so Embree's manual has it, which asks for room behind
/// the last row.
unsafe fn run(
    geometry: &Geometry,
    settings: &Settings,
    query: Query,
    each: &mut dyn FnMut(usize, Jet),
) -> Result<(), Problem> {
    let rows = rows(settings, &query)?;
    let bytes = 4 * query.count as usize;
    // SAFETY: passed on; the settings keep the memory meanwhile.
    let wide = unsafe { rows.widened(bytes) };
    interpolate(geometry.kind, settings, wide.as_ref().unwrap_or(rows), query, each)
}

/// Values between the vertices of a primitive. See Embree's manual.
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
    let &InterpolateArguments { prim_id, u, v, buffer_type, slot, count, .. } = arguments;
    let room =
        Room { pointers: pointers(arguments.values, arguments.first, arguments.second), stride: 1, at: 0 };
    let query = Query { prim_id, uv: [u, v], buffer: buffer_type, slot, count };
    let one = |geometry: &Arc<Geometry>| {
        // SAFETY: passed on.
        let mut put = |k: usize, jet: Jet| unsafe { room.put(k, jet) };
        // SAFETY: passed on.
        unsafe { run(geometry, &geometry.settings(), query, &mut put) }
    };
    let geometry: Handle = arguments.geometry;
    // SAFETY: passed on.
    unsafe { with::<Geometry, ()>(geometry, one) }
}

/// The same at many points, in rows of as many values.
///
/// # Safety
/// As Embree's headers say: a geometry, `N` numbers of primitives and parameters, `valid` for each or null, and room for `N` times so
/// many values wherever a pointer is not null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcInterpolateN(arguments: *const InterpolateManyArguments) {
    if arguments.is_null() {
        return;
    }
    // SAFETY: passed on.
    let arguments = unsafe { &*arguments };
    let &InterpolateManyArguments { valid, prim_ids, u, v, n, buffer_type, slot, count, .. } = arguments;
    let all = |geometry: &Arc<Geometry>| {
        if n > 0 && (prim_ids.is_null() || u.is_null() || v.is_null()) {
            return Err(Problem::argument("primIDs, u or v is a null pointer"));
        }
        let (settings, valid): (_, *const c_int) = (geometry.settings(), valid.cast());
        let of = pointers(arguments.values, arguments.first, arguments.second);
        for at in 0..n as usize {
            // SAFETY: passed on: there are `N` of each.
            let (is_valid, prim_id, uv): (bool, c_uint, _) = unsafe {
                let is_valid = valid.is_null() || *valid.add(at) != 0;
                (is_valid, *prim_ids.add(at), [*u.add(at), *v.add(at)])
            };
            if is_valid {
                let room = Room { pointers: of, stride: n as usize, at };
                // SAFETY: passed on.
                let mut put = |k: usize, jet: Jet| unsafe { room.put(k, jet) };
                let query = Query { prim_id, uv, buffer: buffer_type, slot, count };
                // SAFETY: passed on.
                unsafe { run(geometry, &settings, query, &mut put) }?;
            }
        }
        Ok(())
    };
    let geometry: Handle = arguments.geometry;
    // SAFETY: passed on.
    unsafe { with::<Geometry, ()>(geometry, all) }
}
