// SPDX-License-Identifier: GPL-3.0-or-later
//! User geometry of Embree's kind: bounds and tests of the program's, called ray by ray. Source: original; Embree's manual.
//!
//! A program's test writes into the ray and its hit whatever it likes: other ids, a normal, what another scene answered. A tree
//! keeps of that `t`, `u` and `v`; the rest waits in the [`Frame`] of the query, from where the answer is completed.
//! Invariant: a frame is on its thread's stack for as long as the thread is in its query. Proof: `tests/c/embree.c`.

use std::cell::{Cell, RefCell};
use std::ffi::c_int;
use std::ptr::{from_ref, null};
use std::sync::Arc;

use gnurt_accel::{Aabb, Ray, UserGeometry, UserHit};

use crate::ffi_abi::{self as abi, Arguments, Context, Hit, RayHit, UserArguments};
use crate::objects::{Filters, Geometry, UserFunctions};

/// What the program's test of a hit left, and which hit it was.
#[derive(Clone, Copy, Debug)]
struct Kept {
    owner: *const Geometry,
    prim_id: u32,
    t: f32,
    hit: Hit,
}

/// A query that is under way.
#[derive(Debug)]
pub(crate) struct Frame {
    pub(crate) is_occlusion: bool,
    pub(crate) arguments: Arguments,
    pub(crate) context: *mut Context,
    /// Of the ray as it was asked: what does not depend on the space.
    pub(crate) time: f32,
    pub(crate) mask: u32,
    pub(crate) id: u32,
    pub(crate) flags: u32,
    kept: RefCell<Vec<Kept>>,
    outer: Cell<*const Frame>,
}

thread_local! {
    static FRAME: Cell<*const Frame> = const { Cell::new(null()) };
}

/// Puts the frame before it back in place, also when a query ends in a panic.
struct Restore(*const Frame);

impl Drop for Restore {
    fn drop(&mut self) {
        FRAME.set(self.0);
    }
}

impl Frame {
    pub(crate) fn new(
        is_occlusion: bool,
        arguments: Arguments,
        context: *mut Context,
        ray: &abi::Ray,
    ) -> Self {
        let abi::Ray { time, mask, id, flags, .. } = *ray;
        let (kept, outer) = (RefCell::default(), Cell::new(null()));
        Self { is_occlusion, arguments, context, time, mask, id, flags, kept, outer }
    }

    /// Runs a query in this frame.
    pub(crate) fn run<R>(&self, query: impl FnOnce() -> R) -> R {
        let outer = FRAME.replace(self);
        let _restore = Restore(outer);
        self.outer.set(outer);
        query()
    }

    /// What was left by the test whose hit is the answer.
    pub(crate) fn kept(&self, owner: &Geometry, prim_id: u32, t: f32) -> Option<Hit> {
        let kept = self.kept.borrow();
        let mine = || kept.iter().filter(|kept| kept.owner == from_ref(owner) && kept.prim_id == prim_id);
        // Where the ray had to be scaled, `t` is another one here.
        let same = mine().find(|kept| kept.t == t);
        same.or_else(|| mine().min_by(|a, b| a.t.total_cmp(&b.t))).map(|kept| kept.hit)
    }

    /// Keeps what was left. Of hits that are not filtered, those behind the best are of no use.
    pub(crate) fn keep(&self, owner: &Geometry, prim_id: u32, t: f32, hit: Hit) {
        let mut all = self.kept.borrow_mut();
        if all.iter().all(|kept| t < kept.t) {
            all.clear();
        }
        all.push(Kept { owner: from_ref(owner), prim_id, t, hit });
    }
}

/// What the program's tests are called with: its own part, and what is needed when it calls back.
#[repr(C)]
pub(crate) struct Call {
    pub(crate) arguments: UserArguments,
    pub(crate) frame: *const Frame,
    pub(crate) filters: Filters,
}

/// A user geometry as trees see it.
#[derive(Debug)]
pub(crate) struct UserPrimitives {
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) geom_id: u32,
    pub(crate) functions: UserFunctions,
    pub(crate) filters: Filters,
    bounds: Vec<Aabb>,
}

impl UserPrimitives {
    /// Asks for all boxes.
    pub(crate) fn new(
        geometry: Arc<Geometry>,
        geom_id: u32,
        functions: UserFunctions,
        filters: Filters,
        count: u32,
    ) -> Self {
        let bounds = (0..count).map(|prim_id| bounds_of(&geometry, &functions, prim_id)).collect();
        Self { geometry, geom_id, functions, filters, bounds }
    }
}

fn bounds_of(geometry: &Geometry, functions: &UserFunctions, prim_id: u32) -> Aabb {
    let Some(function) = functions.bounds else { return Aabb::EMPTY };
    let Aabb { min: lower, max: upper } = Aabb::EMPTY;
    let mut bounds = abi::Bounds { lower, align0: 0.0, upper, align1: 0.0 };
    let user_data = geometry.user_data();
    let arguments = abi::BoundsArguments { user_data, prim_id, time_step: 0, bounds: &raw mut bounds };
    // SAFETY: the program gave the function to be called like this; the arguments live during the call.
    unsafe { function(&raw const arguments) };
    Aabb { min: bounds.lower, max: bounds.upper }
}

impl UserGeometry for UserPrimitives {
    fn count(&self) -> u32 {
        self.bounds.len() as u32
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        self.bounds[prim_id as usize]
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let frame = FRAME.get();
        if frame.is_null() {
            return;
        }
        // SAFETY: the frame of this thread's query, which is on its stack until the query is over.
        let frame = unsafe { &*frame };
        let own = if frame.is_occlusion { self.functions.occluded } else { self.functions.intersect };
        let Some(function) = frame.arguments.callback.or(own) else { return };
        let mut valid: c_int = -1;
        let Frame { time, mask, id, flags, .. } = *frame;
        let Ray { org, t_near, dir, t_far, .. } = *ray;
        let asked = abi::Ray { org, t_near, dir, time, t_far, mask, id, flags };
        let mut rays = RayHit { ray: asked, hit: Hit::NONE };
        let call = Call {
            arguments: UserArguments {
                valid: &raw mut valid,
                user_data: self.geometry.user_data(),
                prim_id,
                context: frame.context,
                rays: (&raw mut rays).cast(),
                n: 1,
                geom_id: self.geom_id,
            },
            frame,
            filters: self.filters,
        };
        // SAFETY: the program gave the function to be called like this; ray and hit are of one lane and live during the call.
        unsafe { function((&raw const call).cast()) };
        // Read anew: the program wrote through pointers.
        // SAFETY: it is our own value.
        let rays = unsafe { (&raw const rays).read_volatile() };
        if frame.is_occlusion {
            if rays.ray.t_far < 0.0 && t_far >= 0.0 {
                hit(UserHit { t: t_near, u: 0.0, v: 0.0 });
            }
            return;
        }
        let t = rays.ray.t_far;
        if (t < t_far || rays.hit.geom_id != abi::INVALID) && t >= t_near && t <= t_far {
            frame.keep(&self.geometry, prim_id, t, rays.hit);
            hit(UserHit { t, u: rays.hit.u, v: rays.hit.v });
        }
    }

    fn closest_point(&self, prim_id: u32, point: [f32; 3]) -> Option<[f32; 3]> {
        // Only the program knows; its box says how near it may be.
        let Aabb { min, max } = self.bounds[prim_id as usize];
        Some([0, 1, 2].map(|k| point[k].clamp(min[k], max[k])))
    }
}
