// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries that call functions of the program: filters of hits, and tests of user geometry. Source: Embree's
//! manual.
//!
//! Callbacks get a packet as wide as the call's (`N`) with one active ray, in its lane: programs that work on
//! all lanes at once, regardless of `valid`, find memory there. Filters see the ray in the program's memory
//! and in the space of the geometry, which is another one inside of instances. An exception ends at the
//! callback that it leaves: no other is called in this query, which has no hit. Tests: `tests/c/embree.c`,
//! `tests/c/frames.c`, `tests/c/throws.cpp`.

use std::collections::HashSet;
use std::ffi::{c_int, c_void};
use std::ptr::null_mut;

use gnurt_accel::{Hit, PrimitiveId, Ray};

use crate::ffi_abi::{
    self as abi, Arguments, Context, FilterArguments, FilterFunction, HitFrame, HitPacketFrame, INVALID,
    INVOKE_ARGUMENT_FILTER, Valid, row,
};
use crate::ffi_callbacks::call_program;
use crate::ffi_lane::{Lane, QueryRay, has_arrays, hit_for_program};
use crate::ffi_user::Frame;
use crate::objects::{Committed, Kind, run_query};
use crate::transform::{self, Columns};

/// A query that calls functions of the program.
struct FilteredQuery<'a> {
    committed: &'a Committed,
    frame: &'a Frame,
    lane: Lane,
    ray: Ray,
    /// The hit accepted last, its form after the filter, and the ray's extent then.
    passed: Option<(Hit, abi::Hit, f32)>,
    /// How far the ray reaches: filters may shorten it.
    reach: f32,
    /// Hits that were rejected: leaves list some primitives twice, and filters are called once.
    rejected: Rejected,
}

/// A few are compared one by one, many are looked up.
#[derive(Default)]
struct Rejected {
    few: Vec<Key>,
    many: HashSet<Key>,
}

/// A primitive and where it is hit.
type Key = (PrimitiveId, u32);

impl Rejected {
    fn contains(&self, key: &Key) -> bool {
        self.few.contains(key) || (!self.many.is_empty() && self.many.contains(key))
    }

    fn insert(&mut self, key: Key) {
        if self.few.len() < 16 {
            self.few.push(key);
        } else {
            self.many.insert(key);
        }
    }
}

/// A hit for filters.
struct Candidate {
    t: f32,
    /// Of instances.
    ids: [u32; 2],
    /// The map into the instance, if it is in one.
    inward: Option<Columns>,
    user_data: *mut c_void,
}

/// The filter of a geometry, and that of the query's arguments.
type Filters = [FilterFunction; 2];

impl FilteredQuery<'_> {
    /// Whether filters let a hit pass.
    fn accept(&mut self, hit: &Hit) -> bool {
        if hit.t > self.reach {
            return false;
        }
        let located = self.committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
        // User geometry calls its filters itself.
        if located.surface.kind == Kind::User {
            return true;
        }
        let (frame, filters) = (self.frame, located.surface.filters);
        let own = if frame.is_occlusion { filters.occluded } else { filters.intersect };
        let for_all = frame.arguments.flags & INVOKE_ARGUMENT_FILTER != 0 || filters.from_arguments;
        let both = [own, frame.arguments.filter.filter(|_| for_all)];
        if both.iter().all(Option::is_none) {
            return true;
        }
        let key = (hit.primitive(), hit.t.to_bits());
        if self.rejected.contains(&key) {
            return false;
        }
        let program_hit =
            hit_for_program(&located, hit, &self.ray, None, frame.context, has_arrays(self.committed));
        let ids = [program_hit.inst_id, program_hit.inst_prim_id];
        let inward =
            located.shown_instance.map(|_| transform::inverse(&located.world_from_object(self.ray.time)));
        let user_data = located.surface.geometry.user_data();
        let shown = Candidate { t: hit.t, ids, inward, user_data };
        let (n, at) = (self.lane.n(), self.lane.at());
        let answer = if n == 1 {
            let (mut valid, mut rows) = (-1, HitFrame(program_hit));
            // SAFETY: a lane of one, and rows of one hit, which the program may have written.
            unsafe {
                let t = self.run_query(&both, &shown, &raw mut valid, (&raw mut rows).cast());
                t.map(|t| ((&raw const rows).read_volatile().0, t))
            }
        } else {
            let (mut valid, mut rows) = (Valid::only(at), HitPacketFrame([0.0; 9 * 16]));
            let (valid, rows): (*mut c_int, *mut f32) = ((&raw mut valid).cast(), (&raw mut rows).cast());
            // SAFETY: there is room for nine rows of sixteen, and no packet is wider. Of the lane only rows of the hit are touched.
            unsafe {
                let hit_lane = Lane::of_hits(rows, n, at);
                hit_lane.put_hit(&program_hit, true);
                self.run_query(&both, &shown, valid, rows).map(|t| (hit_lane.hit(), t))
            }
        };
        let Some((program_hit, t)) = answer else {
            self.rejected.insert(key);
            return false;
        };
        self.reach = self.reach.min(t);
        self.passed = Some((*hit, program_hit, t));
        true
    }

    /// Calls filters; returns how far the hit is then. `None` where one rejects it, or throws.
    ///
    /// # Safety
    /// `valid` are as many numbers as the packet has lanes, `rows` as many hits.
    unsafe fn run_query(
        &self,
        filters: &Filters,
        candidate: &Candidate,
        valid: *mut c_int,
        rows: *mut f32,
    ) -> Option<f32> {
        let &Candidate { t, ids, ref inward, user_data } = candidate;
        let (lane, context) = (self.lane, self.frame.context);
        let has_arrays = has_arrays(self.committed);
        let (packet, n) = (lane.packet(), lane.n() as u32);
        let arguments = FilterArguments { valid, user_data, context, ray: packet, hit: rows, n };
        // SAFETY: the caller vouches for hits and `valid`; the ray is in the program's memory, and the context, which is never null here,
        // has a second number where arrays are known. The program gave the filters to be called like this.
        unsafe {
            let (before, of_context) = (lane.get(row::T_FAR), inst_ids(context, has_arrays));
            lane.set(row::T_FAR, t);
            if let Some(inward) = inward {
                let (org, dir) = (self.ray.org.map(f64::from), self.ray.dir.map(f64::from));
                let inside = [transform::point(inward, org), transform::linear(inward, dir)];
                lane.put_line(inside.map(|v| v.map(|x| x as f32)));
            }
            set_inst_ids(context, has_arrays, ids);
            let mut is_valid = true;
            for filter in filters.iter().flatten() {
                is_valid = call_program(&self.frame.stopped, || filter(&raw const arguments)).is_some()
                    && valid.add(lane.at()).read_volatile() != 0;
                if !is_valid {
                    break;
                }
            }
            let shortened = lane.get(row::T_FAR);
            lane.set(row::T_FAR, before);
            if inward.is_some() {
                lane.put_line([self.ray.org, self.ray.dir]);
            }
            set_inst_ids(context, has_arrays, of_context);
            // Not so of NaN.
            is_valid.then_some(if shortened < t { shortened } else { t })
        }
    }
}

/// The numbers of instances in a context.
///
/// # Safety
/// A context, with two numbers where arrays are known.
pub(crate) unsafe fn inst_ids(context: *const Context, has_arrays: bool) -> [u32; 2] {
    // SAFETY: passed on.
    unsafe { [(*context).inst_id, if has_arrays { (*context).inst_prim_id } else { INVALID }] }
}

/// Sets them.
///
/// # Safety
/// As [`inst_ids`].
pub(crate) unsafe fn set_inst_ids(context: *mut Context, has_arrays: bool, ids: [u32; 2]) {
    // SAFETY: passed on.
    unsafe {
        (*context).inst_id = ids[0];
        if has_arrays {
            (*context).inst_prim_id = ids[1];
        }
    }
}

/// Prepares frame and context, and calls the function.
fn with_frame<R>(
    committed: &Committed,
    lane: Lane,
    query_ray: QueryRay,
    is_occlusion: bool,
    query: impl FnOnce(&mut FilteredQuery) -> R,
) -> R {
    let none = Arguments { flags: 0, features: u32::MAX, context: null_mut(), filter: None, callback: None };
    let mut arguments = query_ray.get().unwrap_or(none);
    let mut context = Context { inst_id: INVALID, inst_prim_id: INVALID };
    if arguments.context.is_null() {
        arguments.context = &raw mut context;
    }
    let frame = Frame::new(is_occlusion, arguments, arguments.context, lane);
    let rejected = Rejected::default();
    let (ray, reach) = (lane.ray(), f32::INFINITY);
    let mut filtered = FilteredQuery { committed, frame: &frame, lane, ray, passed: None, reach, rejected };
    frame.run(|| query(&mut filtered))
}

#[cold]
pub(crate) fn intersect_filtered(committed: &Committed, lane: Lane, query_ray: QueryRay) {
    with_frame(committed, lane, query_ray, false, |filtered| {
        let (ray, query) = (filtered.ray, &committed.query);
        let hit = run_query!(committed, tree => tree.intersect_filtered(query, &ray, |_, hit| filtered.accept(hit)));
        let Some(hit) = hit else { return };
        let located = committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
        let (context, has_arrays) = (filtered.frame.context, has_arrays(committed));
        let as_found = hit_for_program(&located, &hit, &ray, None, context, has_arrays);
        let (program_hit, t) = match (&filtered.passed, located.surface.kind) {
            (_, Kind::User) => {
                let retained = filtered.frame.pending_hits(&located.surface.geometry, hit.prim_id, hit.t);
                (retained.map_or(as_found, |retained| completed(retained, &as_found)), hit.t)
            }
            (Some((passed, program_hit, t)), _) if *passed == hit => (*program_hit, *t),
            _ => (as_found, hit.t),
        };
        lane.write(t, &program_hit, has_arrays);
    });
}

/// The result of the program's test, with the fields that only the library can fill.
fn completed(retained: abi::Hit, found: &abi::Hit) -> abi::Hit {
    let or = |retained: u32, found: u32| if retained == INVALID { found } else { retained };
    abi::Hit {
        prim_id: or(retained.prim_id, found.prim_id),
        geom_id: or(retained.geom_id, found.geom_id),
        inst_id: or(retained.inst_id, found.inst_id),
        inst_prim_id: or(retained.inst_prim_id, found.inst_prim_id),
        ..retained
    }
}

#[cold]
pub(crate) fn occluded_filtered(committed: &Committed, lane: Lane, query_ray: QueryRay) {
    let is_hit = with_frame(committed, lane, query_ray, true, |filtered| {
        let (ray, query) = (filtered.ray, &committed.query);
        run_query!(committed, tree => tree.occluded_filtered(query, &ray, |_, hit| filtered.accept(hit)))
    });
    if is_hit {
        lane.set(row::T_FAR, f32::NEG_INFINITY);
    }
}
