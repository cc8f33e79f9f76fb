// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcIntersect1/4/8/16` and `rtcOccluded1/4/8/16`, and those of traversables. Source: Embree's manual.
//!
//! Rays of a packet are traced together if the program marks them as coherent, there are enough of them and
//! no callback judges hits; else one by one. Tests: `tests/c/embree.c`.

use std::ffi::c_int;

use gnurt_accel::{Coherence, Hit, Packet, Query, Ray};

use crate::ffi_abi::{self as abi, Arguments, row};
use crate::ffi_callbacks::take_thrown;
use crate::ffi_catch::Thrown;
use crate::ffi_filter::{intersect_filtered, occluded_filtered};
use crate::ffi_handle::{Handle, guarded, not_committed, with};
use crate::ffi_lane::{Lane, QueryRay, given_instance, has_arrays, hit_for_program};
use crate::ffi_present::present;
use crate::located::across;
use crate::objects::{Committed, Scene, Surface, Tree, run_query};

/// Whether functions of the program are called for hits.
#[inline(always)]
fn calls_program(committed: &Committed, query_ray: QueryRay) -> bool {
    !committed.is_plain || query_ray.filters_all()
}

/// The closest hit.
#[inline(always)]
pub(crate) fn intersect(committed: &Committed, lane: Lane, query_ray: QueryRay) {
    if calls_program(committed, query_ray) {
        intersect_filtered(committed, lane, query_ray);
    } else {
        intersect_plain(committed, lane, &lane.ray(), query_ray);
    }
}

/// The same without callbacks.
#[inline(always)]
fn intersect_plain(committed: &Committed, lane: Lane, ray: &Ray, query_ray: QueryRay) {
    let found = match &committed.tree {
        Tree::Object(tree) => tree.intersect_directly(&committed.query, ray),
        Tree::Scene(_) => None,
    };
    let Some(found) = found else { return intersect_anything(committed, lane, ray, query_ray) };
    let Some((hit, corners)) = found else { return };
    match (corners, &committed.surfaces[hit.geom_id as usize]) {
        (Some([a, b, c]), surface @ Surface { cells: None, .. }) => {
            let has_arrays = has_arrays(committed);
            let (inst_id, inst_prim_id) = given_instance(query_ray.context(), has_arrays);
            let Hit { t, u, v, prim_id, .. } = hit;
            let (normal, geom_id) = (across(a, b, c), surface.geom_id);
            lane.write(t, &abi::Hit { normal, u, v, prim_id, geom_id, inst_id, inst_prim_id }, has_arrays);
        }
        _ => write_hit(committed, lane, ray, query_ray, &hit, corners),
    }
}

/// The same in any scene.
#[inline(never)]
fn intersect_anything(committed: &Committed, lane: Lane, ray: &Ray, query_ray: QueryRay) {
    let found = run_query!(committed, tree => tree.intersect_with_corners(&committed.query, ray));
    if let Some((hit, corners)) = found {
        write_hit(committed, lane, ray, query_ray, &hit, corners);
    }
}

/// Writes a hit of any kind. A function of its own, so that the calls above need few registers.
#[inline(never)]
fn write_hit(
    committed: &Committed,
    lane: Lane,
    ray: &Ray,
    query_ray: QueryRay,
    hit: &Hit,
    corners: Option<[[f32; 3]; 3]>,
) {
    let located = committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
    let has_arrays = has_arrays(committed);
    let program_hit = hit_for_program(&located, hit, ray, corners, query_ray.context(), has_arrays);
    lane.write(hit.t, &program_hit, has_arrays);
}

/// Whether there is a hit.
#[inline(always)]
pub(crate) fn occluded(committed: &Committed, lane: Lane, query_ray: QueryRay) {
    if calls_program(committed, query_ray) {
        occluded_filtered(committed, lane, query_ray);
    } else {
        occluded_plain(committed, lane, &lane.ray());
    }
}

/// The same without callbacks.
#[inline(always)]
fn occluded_plain(committed: &Committed, lane: Lane, ray: &Ray) {
    if run_query!(committed, tree => tree.occluded_with(&committed.query, ray)) {
        lane.set(row::T_FAR, f32::NEG_INFINITY);
    }
}

/// Active rays of a packet, together, and which lane each of them is.
struct PacketQuery<'a> {
    query: Query,
    committed: &'a Committed,
    packet: Packet,
    lanes: [Option<Lane>; Packet::MOST],
}

impl<'a> PacketQuery<'a> {
    fn new(committed: &'a Committed, lanes: impl Iterator<Item = Lane>) -> Self {
        let query = Query { coherence: Coherence::Coherent, ..committed.query };
        let mut packet_query = Self { query, committed, packet: Packet::new(), lanes: [None; Packet::MOST] };
        for (at, lane) in lanes.enumerate().take(Packet::MOST) {
            packet_query.packet.push(&lane.ray());
            packet_query.lanes[at] = Some(lane);
        }
        packet_query
    }

    fn intersect(self, query_ray: QueryRay) {
        let Self { query, committed, packet, lanes } = self;
        let has_arrays = has_arrays(committed);
        run_query!(committed, tree => tree.intersect_packet(&query, packet, |at, hit| {
            if let Some(lane) = lanes[at] {
                let located = committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
                let (ray, context) = (lane.ray(), query_ray.context());
                let program_hit = hit_for_program(&located, &hit, &ray, None, context, has_arrays);
                lane.write(hit.t, &program_hit, has_arrays);
            }
        }));
    }

    fn occluded(self) {
        let Self { query, committed, packet, lanes } = self;
        let hit = run_query!(committed, tree => tree.occluded_packet(&query, packet));
        for (at, lane) in lanes.into_iter().enumerate() {
            if let Some(lane) = lane.filter(|_| hit >> at & 1 == 1) {
                lane.set(row::T_FAR, f32::NEG_INFINITY);
            }
        }
    }
}

/// The query of each ray.
trait Trace {
    /// Coherent packets of at least this many rays are traced together: fewer are faster one by one
    /// (bench/record/embree-calls-2026-11-23.md).
    const WORTH_IT: usize;
    fn one(committed: &Committed, lane: Lane, ray: &Ray, query_ray: QueryRay);
    /// Where functions of the program are called.
    fn asking(committed: &Committed, lane: Lane, query_ray: QueryRay);
    fn packet_query(rays: PacketQuery, query_ray: QueryRay);
}

struct Intersect;
struct Occluded;

impl Trace for Intersect {
    const WORTH_IT: usize = 8;

    #[inline(always)]
    fn one(committed: &Committed, lane: Lane, ray: &Ray, query_ray: QueryRay) {
        intersect_plain(committed, lane, ray, query_ray);
    }

    fn asking(committed: &Committed, lane: Lane, query_ray: QueryRay) {
        intersect_filtered(committed, lane, query_ray);
    }

    fn packet_query(rays: PacketQuery, query_ray: QueryRay) {
        rays.intersect(query_ray);
    }
}

impl Trace for Occluded {
    const WORTH_IT: usize = 16;

    #[inline(always)]
    fn one(committed: &Committed, lane: Lane, ray: &Ray, _: QueryRay) {
        occluded_plain(committed, lane, ray);
    }

    fn asking(committed: &Committed, lane: Lane, query_ray: QueryRay) {
        occluded_filtered(committed, lane, query_ray);
    }

    fn packet_query(rays: PacketQuery, _: QueryRay) {
        rays.occluded();
    }
}

/// The committed scene of a scene handle, or of a traversable's.
///
/// # Safety
/// The handle is null or a scene's.
#[inline(always)]
pub(crate) unsafe fn committed<'a>(scene: Handle) -> Option<&'a Committed> {
    if scene.is_null() {
        // SAFETY: null is fine.
        unsafe { with::<Scene, ()>(scene, |_| Ok(())) };
        return None;
    }
    // SAFETY: a scene's handle points to it.
    let current = present(unsafe { &*scene.cast::<Scene>() });
    if current.is_none() {
        // SAFETY: the handle is a scene's.
        unsafe { with::<Scene, ()>(scene, |_| Err(not_committed())) };
    }
    current
}

/// Reports an exception that a function of the program has thrown to the scene's device.
///
/// # Safety
/// The handle is a scene's.
#[cold]
unsafe fn report_thrown(scene: Handle, thrown: Thrown) {
    // SAFETY: passed on.
    unsafe { with::<Scene, ()>(scene, |_| Err(thrown.into())) }
}

/// Traces the active lanes of a packet.
///
/// # Safety
/// The handle is a scene's, `rays` a packet of `N`, `valid` null for one ray or an array of `N`.
#[inline(always)]
unsafe fn each<const N: usize, T: Trace>(
    valid: *const c_int,
    scene: Handle,
    rays: *mut f32,
    arguments: *const Arguments,
) {
    // SAFETY: passed on.
    let Some(committed) = (unsafe { committed(scene) }) else { return };
    let query_ray = QueryRay { arguments };
    let asks = calls_program(committed, query_ray);
    guarded(move || {
        let lanes = (0..N)
            // SAFETY: there are `N` numbers in `valid`.
            .filter(|&i| N == 1 || unsafe { *valid.add(i) } != 0)
            // SAFETY: passed on.
            .map(|i| unsafe { Lane::new(rays, N, i) });
        if asks {
            lanes.for_each(|lane| T::asking(committed, lane, query_ray));
        } else if N >= T::WORTH_IT && query_ray.is_coherent() {
            T::packet_query(PacketQuery::new(committed, lanes), query_ray);
        } else {
            lanes.for_each(|lane| match N {
                // SAFETY: the ray is written after it was traced.
                1 => T::one(committed, lane, unsafe { lane.in_place() }, query_ray),
                _ => T::one(committed, lane, &lane.ray(), query_ray),
            });
        }
    });
    if asks && let Err(thrown) = take_thrown() {
        // SAFETY: passed on.
        unsafe { report_thrown(scene, thrown) }
    }
}

macro_rules! packets {
    ($($name:ident, $traversable:ident: $trace:ty, $n:literal;)*) => { $(
        /// Traces a packet. See Embree's manual.
        ///
        /// # Safety
        /// As Embree's headers say: a scene, a packet of this size, which rays of it count, arguments or null.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $name(valid: *const c_int, scene: Handle, rays: *mut f32, arguments: *const Arguments) {
            // SAFETY: passed on.
            unsafe { each::<$n, $trace>(valid, scene, rays, arguments) }
        }

        /// The same; a scene is its own traversable.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $traversable(
            valid: *const c_int,
            scene: Handle,
            rays: *mut f32,
            arguments: *const Arguments,
        ) {
            // SAFETY: passed on.
            unsafe { each::<$n, $trace>(valid, scene, rays, arguments) }
        }
    )* };
}

packets! {
    rtcIntersect4, rtcTraversableIntersect4: Intersect, 4;
    rtcIntersect8, rtcTraversableIntersect8: Intersect, 8;
    rtcIntersect16, rtcTraversableIntersect16: Intersect, 16;
    rtcOccluded4, rtcTraversableOccluded4: Occluded, 4;
    rtcOccluded8, rtcTraversableOccluded8: Occluded, 8;
    rtcOccluded16, rtcTraversableOccluded16: Occluded, 16;
}

macro_rules! single {
    ($($name:ident, $traversable:ident: $trace:ty;)*) => { $(
        /// Traces a ray. See Embree's manual.
        ///
        /// # Safety
        /// As Embree's headers say: a scene, a ray (with a hit where one is asked for), arguments or null.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $name(scene: Handle, ray: *mut f32, arguments: *const Arguments) {
            // SAFETY: passed on.
            unsafe { each::<1, $trace>(std::ptr::null(), scene, ray, arguments) }
        }

        /// The same; a scene is its own traversable.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $traversable(scene: Handle, ray: *mut f32, arguments: *const Arguments) {
            // SAFETY: passed on.
            unsafe { each::<1, $trace>(std::ptr::null(), scene, ray, arguments) }
        }
    )* };
}

single! {
    rtcIntersect1, rtcTraversableIntersect1: Intersect;
    rtcOccluded1, rtcTraversableOccluded1: Occluded;
}
