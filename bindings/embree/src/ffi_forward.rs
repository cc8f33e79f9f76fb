// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcForwardIntersect1/4/8/16` and similar functions: rays that the test of a user geometry forwards to
//! another scene; and filters that it calls.
//! Source: Embree's manual. Tests get packets in which one ray counts: only that one is forwarded, regardless of `valid`.
//! Tests: `tests/c/embree.c`, `tests/c/frames.c`.

use std::ffi::{c_int, c_uint};
use std::sync::atomic::Ordering;

use crate::device::Problem;
use crate::ffi_abi::{self as abi, FilterArguments, FilterFunction, UserArguments, row};
use crate::ffi_callbacks::has_thrown;
use crate::ffi_filter::{inst_ids, set_inst_ids};
use crate::ffi_handle::{Handle, guarded, with};
use crate::ffi_lane::{Lane, QueryRay, has_arrays};
use crate::ffi_trace::{committed, intersect, occluded};
use crate::ffi_user::Call;
use crate::objects::{Committed, Scene};

/// Sends the ray of a user geometry's test on into another scene.
///
/// # Safety
/// `arguments` are those of the test's call, `rays` a packet of `N`, `valid` `N` numbers, or null for one
/// ray.
unsafe fn forward<const N: usize>(
    valid: *const c_int,
    arguments: *const UserArguments,
    scene: Handle,
    rays: *mut f32,
    inst_id: u32,
    inst_prim_id: Option<u32>,
    trace: impl Fn(&Committed, Lane, QueryRay),
) {
    // SAFETY: the handle is a scene's.
    let Some(committed) = (unsafe { committed(scene) }) else { return };
    // SAFETY: tests are called with the first part of a `Call`, whose frame is that of the query under way; its context
    // is never null. The rays of a call are ours, with all fields.
    unsafe {
        let call = &*arguments.cast::<Call>();
        let frame = &*call.frame;
        let (n, at) = (frame.lane.n(), frame.lane.at());
        if N != 1 && N != n {
            let message =
                format!("{N} rays are forwarded from a test of {n}: N of its arguments is their number");
            return with::<Scene, ()>(scene, |_| Err(Problem::operation(message)));
        }
        if !valid.is_null() && *valid.add(at) == 0 {
            return;
        }
        // A program with space for an instance number in an array passes that number.
        if inst_prim_id.is_some() {
            committed.device.has_arrays.store(true, Ordering::Relaxed);
        }
        let has_arrays = has_arrays(committed);
        let query_ray = Lane::new(rays, N, if N == 1 { 0 } else { at }).whole();
        let lane = Lane::new(call.arguments.rays, n, at);
        let before = lane.whole();
        lane.put_ray(&abi::Ray {
            org: query_ray.org,
            t_near: query_ray.t_near,
            dir: query_ray.dir,
            time: query_ray.time,
            ..before
        });
        let outer = inst_ids(frame.context, has_arrays);
        set_inst_ids(frame.context, has_arrays, [inst_id, inst_prim_id.unwrap_or(abi::INVALID)]);
        guarded(|| trace(committed, lane, QueryRay { arguments: &raw const frame.arguments }));
        set_inst_ids(frame.context, has_arrays, outer);
        frame.stopped.set(has_thrown());
        lane.put_ray(&abi::Ray { t_far: lane.get(row::T_FAR), ..before });
    }
}

macro_rules! forward {
    ($($name:ident, $extended:ident: $trace:ident;)*) => { $(
        /// Sends the ray of a user geometry's test on. See Embree's manual.
        ///
        /// # Safety
        /// As Embree's headers say: the arguments of the test, a scene, a ray.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $name(
            arguments: *const UserArguments,
            scene: Handle,
            ray: *mut f32,
            inst_id: c_uint,
        ) {
            // SAFETY: passed on.
            unsafe { forward::<1>(std::ptr::null(), arguments, scene, ray, inst_id, None, $trace) }
        }

        /// The same with an index in an array of instances.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $extended(
            arguments: *const UserArguments,
            scene: Handle,
            ray: *mut f32,
            inst_id: c_uint,
            inst_prim_id: c_uint,
        ) {
            // SAFETY: passed on.
            unsafe { forward::<1>(std::ptr::null(), arguments, scene, ray, inst_id, Some(inst_prim_id), $trace) }
        }
    )* };
}

forward! {
    rtcForwardIntersect1, rtcForwardIntersect1Ex: intersect;
    rtcForwardOccluded1, rtcForwardOccluded1Ex: occluded;
    rtcTraversableForwardIntersect1, rtcTraversableForwardIntersect1Ex: intersect;
    rtcTraversableForwardOccluded1, rtcTraversableForwardOccluded1Ex: occluded;
}

macro_rules! forward_packets {
    ($($name:ident, $extended:ident: $n:literal, $trace:ident;)*) => { $(
        /// Sends the ray of a user geometry's test of a packet on. See Embree's manual.
        ///
        /// # Safety
        /// As Embree's headers say: which rays count, the arguments of the test, a scene, a packet.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $name(
            valid: *const c_int,
            arguments: *const UserArguments,
            scene: Handle,
            rays: *mut f32,
            inst_id: c_uint,
        ) {
            // SAFETY: passed on.
            unsafe { forward::<$n>(valid, arguments, scene, rays, inst_id, None, $trace) }
        }

        /// The same with an index in an array of instances.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $extended(
            valid: *const c_int,
            arguments: *const UserArguments,
            scene: Handle,
            rays: *mut f32,
            inst_id: c_uint,
            inst_prim_id: c_uint,
        ) {
            // SAFETY: passed on.
            unsafe { forward::<$n>(valid, arguments, scene, rays, inst_id, Some(inst_prim_id), $trace) }
        }
    )* };
}

forward_packets! {
    rtcForwardIntersect4, rtcForwardIntersect4Ex: 4, intersect;
    rtcForwardIntersect8, rtcForwardIntersect8Ex: 8, intersect;
    rtcForwardIntersect16, rtcForwardIntersect16Ex: 16, intersect;
    rtcForwardOccluded4, rtcForwardOccluded4Ex: 4, occluded;
    rtcForwardOccluded8, rtcForwardOccluded8Ex: 8, occluded;
    rtcForwardOccluded16, rtcForwardOccluded16Ex: 16, occluded;
    rtcTraversableForwardIntersect4, rtcTraversableForwardIntersect4Ex: 4, intersect;
    rtcTraversableForwardIntersect8, rtcTraversableForwardIntersect8Ex: 8, intersect;
    rtcTraversableForwardIntersect16, rtcTraversableForwardIntersect16Ex: 16, intersect;
    rtcTraversableForwardOccluded4, rtcTraversableForwardOccluded4Ex: 4, occluded;
    rtcTraversableForwardOccluded8, rtcTraversableForwardOccluded8Ex: 8, occluded;
    rtcTraversableForwardOccluded16, rtcTraversableForwardOccluded16Ex: 16, occluded;
}

/// Calls the geometry's own filter from a user geometry's test.
///
/// # Safety
/// Both arguments are as Embree's headers say.
unsafe fn invoke(arguments: *const UserArguments, filter: *const FilterArguments, is_occlusion: bool) {
    // SAFETY: tests are called with the first part of a `Call`.
    let filters = unsafe { (*arguments.cast::<Call>()).filters };
    let function: FilterFunction = if is_occlusion { filters.occluded } else { filters.intersect };
    if let Some(function) = function {
        // SAFETY: the program gave the filter to be called like this, and its arguments are its own.
        unsafe { function(filter) }
    }
}

/// Calls a user geometry's filter of hits.
///
/// # Safety
/// As Embree's headers say.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcInvokeIntersectFilterFromGeometry(
    arguments: *const UserArguments,
    filter: *const FilterArguments,
) {
    // SAFETY: passed on.
    unsafe { invoke(arguments, filter, false) }
}

/// Calls a user geometry's filter of occlusion.
///
/// # Safety
/// As Embree's headers say.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcInvokeOccludedFilterFromGeometry(
    arguments: *const UserArguments,
    filter: *const FilterArguments,
) {
    // SAFETY: passed on.
    unsafe { invoke(arguments, filter, true) }
}
