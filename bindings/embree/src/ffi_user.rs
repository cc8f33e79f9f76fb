// SPDX-License-Identifier: GPL-3.0-or-later
//! User geometry of Embree's kind: bounds and tests of the program's, called ray by ray, each in a packet as wide as the call's. Source: Embree's manual.
//!
//! A program's test may write any values into the ray and its hit: other ids, a normal, the result of another
//! scene. A tree keeps `t`, `u` and `v` of that; the rest stays in the [`Frame`] of the query, which
//! completes the result.
//! Invariant: a frame is on its thread's stack for as long as the thread is in its query. Tests: `tests/c/embree.c`.

use std::cell::{Cell, RefCell};
use std::ffi::c_int;
use std::ptr::{from_ref, null};
use std::sync::Arc;

use gnurt_accel::{Aabb, KeyInterval, Ray, UserGeometry, UserHit};

use crate::device::Problem;
use crate::ffi_abi::{
    self as abi, Arguments, Context, Hit, RayHit, RayHitPacketFrame, UserArguments, UserTest, Valid, row,
};
use crate::ffi_callbacks::call_program;
use crate::ffi_catch;
use crate::ffi_lane::Lane;
use crate::objects::{Filters, Geometry, UserFunctions};

/// The output of the program's test, and its hit.
#[derive(Clone, Copy, Debug)]
struct PendingHit {
    owner: *const Geometry,
    prim_id: u32,
    t: f32,
    hit: Hit,
}

/// A query in progress.
pub(crate) struct Frame {
    pub(crate) is_occlusion: bool,
    pub(crate) arguments: Arguments,
    pub(crate) context: *mut Context,
    /// The current ray, in its packet.
    pub(crate) lane: Lane,
    /// The fields of the original ray that do not depend on the space.
    time: f32,
    mask: u32,
    id: u32,
    flags: u32,
    pending_hits: RefCell<Vec<PendingHit>>,
    /// After an exception: no function of the program is called any more.
    pub(crate) stopped: Cell<bool>,
}

thread_local! {
    static FRAME: Cell<*const Frame> = const { Cell::new(null()) };
}

/// Restores the frame before it, also when a query ends in a panic.
struct Restore(*const Frame);

impl Drop for Restore {
    fn drop(&mut self) {
        FRAME.set(self.0);
    }
}

impl Frame {
    #[inline(always)]
    pub(crate) fn new(is_occlusion: bool, arguments: Arguments, context: *mut Context, lane: Lane) -> Self {
        let (pending_hits, stopped) = (RefCell::default(), Cell::new(false));
        let row_bits = |row: usize| lane.get(row).to_bits();
        let (time, mask) = (lane.get(row::TIME), row_bits(row::MASK));
        let (id, flags) = (row_bits(row::ID), row_bits(row::FLAGS));
        Self { is_occlusion, arguments, context, lane, time, mask, id, flags, pending_hits, stopped }
    }

    /// Runs a query in this frame.
    #[inline]
    pub(crate) fn run<R>(&self, query: impl FnOnce() -> R) -> R {
        let _restore = Restore(FRAME.replace(self));
        query()
    }

    /// The output of the test whose hit is the result.
    pub(crate) fn pending_hits(&self, owner: &Geometry, prim_id: u32, t: f32) -> Option<Hit> {
        let pending_hits = self.pending_hits.borrow();
        let mine = || {
            pending_hits.iter().filter(|pending_hits| {
                pending_hits.owner == from_ref(owner) && pending_hits.prim_id == prim_id
            })
        };
        // Where the ray had to be scaled, `t` is another one here.
        let same = mine().find(|pending_hits| pending_hits.t == t);
        same.or_else(|| mine().min_by(|a, b| a.t.total_cmp(&b.t))).map(|pending_hits| pending_hits.hit)
    }

    /// Keeps the output of a test. Of unfiltered hits, those behind the best are dropped.
    pub(crate) fn keep(&self, owner: &Geometry, prim_id: u32, t: f32, hit: Hit) {
        let mut all = self.pending_hits.borrow_mut();
        if all.iter().all(|pending_hits| t < pending_hits.t) {
            all.clear();
        }
        all.push(PendingHit { owner: from_ref(owner), prim_id, t, hit });
    }
}

/// The arguments of the program's tests: its own part, and the data for calls back.
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
    /// How many time steps there are.
    steps: u32,
    /// By primitive and time step.
    bounds: Vec<Aabb>,
}

impl UserPrimitives {
    /// Calls the program for all boxes.
    ///
    /// # Errors
    /// The program's function has thrown an exception.
    pub(crate) fn new(
        geometry: Arc<Geometry>,
        geom_id: u32,
        functions: UserFunctions,
        filters: Filters,
        count: u32,
        steps: u32,
    ) -> Result<Self, Problem> {
        let all = (0..count).flat_map(|prim_id| (0..steps).map(move |step| (prim_id, step)));
        let bounds = all.map(|(prim_id, step)| bounds_of(&geometry, &functions, prim_id, step));
        let bounds = bounds.collect::<Result<_, _>>()?;
        Ok(Self { geometry, geom_id, functions, filters, steps, bounds })
    }

    /// The ray as the program's test gets it.
    #[inline(always)]
    fn program_ray(frame: &Frame, ray: &Ray) -> abi::Ray {
        let Ray { org, t_near, dir, t_far, .. } = *ray;
        let Frame { time, mask, id, flags, .. } = *frame;
        abi::Ray { org, t_near, dir, time, t_far, mask, id, flags }
    }

    /// Calls the program's test for a packet. `None` where it has thrown an exception.
    ///
    /// # Safety
    /// `valid` are as many numbers as the packet of the query has lanes, `rays` as many rays and hits.
    #[inline(always)]
    unsafe fn run_query(
        &self,
        function: UserTest,
        prim_id: u32,
        frame: &Frame,
        valid: *mut c_int,
        rays: *mut f32,
    ) -> Option<()> {
        let call = Call {
            arguments: UserArguments {
                valid,
                user_data: self.geometry.user_data(),
                prim_id,
                context: frame.context,
                rays,
                n: frame.lane.n() as u32,
                geom_id: self.geom_id,
            },
            frame,
            filters: self.filters,
        };
        // SAFETY: the program gave the function to be called like this; the caller vouches for the packet.
        call_program(&frame.stopped, || unsafe { function((&raw const call).cast()) })
    }

    /// Calls the program's test for one ray; returns its new `t_far`, and its hit.
    #[inline(always)]
    fn test_one(&self, function: UserTest, prim_id: u32, frame: &Frame, ray: &Ray) -> Option<(f32, Hit)> {
        let (mut valid, mut rays) = (-1, RayHit { ray: Self::program_ray(frame, ray), hit: Hit::NONE });
        // SAFETY: one ray with a hit, read again because the program wrote through pointers.
        unsafe {
            self.run_query(function, prim_id, frame, &raw mut valid, (&raw mut rays).cast())?;
            let rays = &raw const rays;
            Some(((&raw const (*rays).ray.t_far).read_volatile(), (&raw const (*rays).hit).read_volatile()))
        }
    }

    /// The same in the lane of a packet.
    #[inline(never)]
    fn test_packet(&self, function: UserTest, prim_id: u32, frame: &Frame, ray: &Ray) -> Option<(f32, Hit)> {
        let (n, at) = (frame.lane.n(), frame.lane.at());
        let (mut valid, mut rays) = (Valid::only(at), RayHitPacketFrame([0.0; 21 * 16]));
        let rays: *mut f32 = (&raw mut rays).cast();
        // SAFETY: there is room for rows of sixteen, and no packet is wider.
        unsafe {
            let lane = Lane::new(rays, n, at);
            lane.put_ray(&Self::program_ray(frame, ray));
            lane.put_hit(&Hit::NONE, true);
            self.run_query(function, prim_id, frame, (&raw mut valid).cast(), rays)?;
            Some((lane.get(row::T_FAR), lane.hit()))
        }
    }
}

fn bounds_of(
    geometry: &Geometry,
    functions: &UserFunctions,
    prim_id: u32,
    time_step: u32,
) -> Result<Aabb, Problem> {
    let Some(function) = functions.bounds else { return Ok(Aabb::EMPTY) };
    let Aabb { min: lower, max: upper } = Aabb::EMPTY;
    let mut bounds = abi::Bounds { lower, align0: 0.0, upper, align1: 0.0 };
    let user_data = geometry.user_data();
    let arguments = abi::BoundsArguments { user_data, prim_id, time_step, bounds: &raw mut bounds };
    // SAFETY: the program gave the function to be called like this; the arguments live during the call.
    ffi_catch::call(|| unsafe { function(&raw const arguments) })?;
    Ok(Aabb { min: bounds.lower, max: bounds.upper })
}

impl UserGeometry for UserPrimitives {
    fn count(&self) -> u32 {
        self.bounds.len() as u32 / self.steps
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        self.bounds_at(prim_id, 0)
    }

    fn keys(&self) -> u32 {
        self.steps
    }

    fn bounds_at(&self, prim_id: u32, key: u32) -> Aabb {
        self.bounds[(prim_id * self.steps + key) as usize]
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
        let answer = match frame.lane.n() {
            1 => self.test_one(function, prim_id, frame, ray),
            _ => self.test_packet(function, prim_id, frame, ray),
        };
        let Some((t, found)) = answer else { return };
        let Ray { t_near, t_far, .. } = *ray;
        if frame.is_occlusion {
            if t < 0.0 && t_far >= 0.0 {
                hit(UserHit { t: t_near, u: 0.0, v: 0.0 });
            }
            return;
        }
        if (t < t_far || found.geom_id != abi::INVALID) && t >= t_near && t <= t_far {
            frame.keep(&self.geometry, prim_id, t, found);
            hit(UserHit { t, u: found.u, v: found.v });
        }
    }

    fn closest_point(&self, prim_id: u32, point: [f32; 3]) -> Option<[f32; 3]> {
        self.closest_point_at(prim_id, point, 0.0)
    }

    fn closest_point_at(&self, prim_id: u32, point: [f32; 3], time: f32) -> Option<[f32; 3]> {
        // Only the program can measure it; its box bounds how near it may be.
        let interval = KeyInterval::of(time, self.steps as usize);
        let [from, to] = [interval.key, interval.next].map(|key| self.bounds_at(prim_id, key as u32));
        let (min, max) = (interval.mix3(from.min, to.min), interval.mix3(from.max, to.max));
        Some([0, 1, 2].map(|k| point[k].clamp(min[k], max[k])))
    }
}
