// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcIntersect1/4/8/16` and `rtcOccluded1/4/8/16`, those of traversables, and rays that user geometry sends on.
//! Source: original; Embree's manual.
//!
//! Rays of a packet go through trees together where the program says that they are coherent, there are enough of them and nobody
//! is asked about hits; else one by one.
//! Callbacks get one ray at a time (`N` is 1), as Embree's rules allow. Filters see the ray as it was asked, also inside of
//! instances. Proof: `tests/c/embree.c`, `tests/c/embree.c`.

use std::collections::HashSet;
use std::ffi::{c_int, c_uint};
use std::ptr::null_mut;

use gnurt_accel::{Coherence, Hit, Packet, PrimitiveId, Query, Ray};

use crate::device::Problem;
use crate::ffi_abi::{
    self as abi, Arguments, COHERENT, Context, FilterArguments, FilterFunction, INVALID,
    INVOKE_ARGUMENT_FILTER, UserArguments, row,
};
use crate::ffi_handle::{Handle, guarded, with};
use crate::ffi_user::{Call, Frame};
use crate::located::Located;
use crate::objects::{Committed, Kind, Scene, ask};

/// Where ray `lane` of a packet of `n` lies.
#[derive(Clone, Copy)]
struct Lane {
    first: *mut f32,
    n: usize,
}

impl Lane {
    /// # Safety
    /// `rays` points to a packet of `n` rays in which `lane` is one; of rays with hits, if hits will be written.
    #[inline(always)]
    unsafe fn new(rays: *mut f32, n: usize, lane: usize) -> Self {
        // SAFETY: the first number of the lane is in the packet.
        Self { first: unsafe { rays.add(lane) }, n }
    }

    #[inline(always)]
    fn get(self, row: usize) -> f32 {
        // SAFETY: rows of rays are there, as who made this vouched.
        unsafe { *self.first.add(row * self.n) }
    }

    #[inline(always)]
    fn set(self, row: usize, value: f32) {
        // SAFETY: as above; rows of hits are written where who made this vouched for them.
        unsafe { *self.first.add(row * self.n) = value }
    }

    #[inline(always)]
    fn set_id(self, row: usize, value: u32) {
        self.set(row, f32::from_bits(value));
    }

    #[inline(always)]
    fn vector(self, row: usize) -> [f32; 3] {
        [self.get(row), self.get(row + 1), self.get(row + 2)]
    }

    #[inline(always)]
    fn ray(self) -> Ray {
        Ray {
            org: self.vector(row::ORG),
            t_near: self.get(row::T_NEAR),
            dir: self.vector(row::DIR),
            t_far: self.get(row::T_FAR),
            mask: self.get(row::MASK).to_bits(),
            time: self.get(row::TIME),
        }
    }

    fn whole(self) -> abi::Ray {
        let Ray { org, t_near, dir, t_far, mask, time } = self.ray();
        let (id, flags) = (self.get(row::ID).to_bits(), self.get(row::FLAGS).to_bits());
        abi::Ray { org, t_near, dir, time, t_far, mask, id, flags }
    }

    #[inline(always)]
    fn write(self, t: f32, hit: &abi::Hit) {
        self.set(row::T_FAR, t);
        (0..3).for_each(|k| self.set(row::NORMAL + k, hit.normal[k]));
        self.set(row::U, hit.u);
        self.set(row::V, hit.v);
        self.set_id(row::PRIM_ID, hit.prim_id);
        self.set_id(row::GEOM_ID, hit.geom_id);
        self.set_id(row::INST_ID, hit.inst_id);
        // Programs that know no arrays of instances have no room for it.
        if hit.inst_prim_id != INVALID {
            self.set_id(row::INST_PRIM_ID, hit.inst_prim_id);
        }
    }
}

/// What a program is to see of a hit.
#[inline(always)]
fn shown(located: &Located, hit: &Hit, ray: &Ray, context: *const Context) -> abi::Hit {
    let (inst_id, inst_prim_id) = match located.place {
        Some(place) => (place.geom_id, place.prim_id.unwrap_or(INVALID)),
        // Who sends rays through instances of his own says so here.
        // SAFETY: a context that is not null begins with this number.
        None if !context.is_null() => (unsafe { (*context).inst_id }, INVALID),
        None => (INVALID, INVALID),
    };
    abi::Hit {
        normal: located.normal(hit, ray.org, ray.dir),
        u: hit.u,
        v: hit.v,
        prim_id: hit.prim_id,
        geom_id: located.surface.geom_id,
        inst_id,
        inst_prim_id,
    }
}

/// What is asked.
#[derive(Clone, Copy)]
struct Asked {
    arguments: *const Arguments,
}

impl Asked {
    #[inline(always)]
    fn get(self) -> Option<Arguments> {
        // SAFETY: the program's arguments are null or live during the call; all fields are in all versions.
        (!self.arguments.is_null()).then(|| unsafe { *self.arguments })
    }

    /// Whether a filter of the arguments is for all geometries.
    #[inline(always)]
    fn filters_all(self) -> bool {
        self.get().is_some_and(|a| a.flags & INVOKE_ARGUMENT_FILTER != 0 && a.filter.is_some())
    }

    /// Whether the rays of a packet go much the same way.
    #[inline(always)]
    fn is_coherent(self) -> bool {
        self.get().is_some_and(|a| a.flags & COHERENT != 0)
    }

    #[inline(always)]
    fn context(self) -> *mut Context {
        self.get().map_or(null_mut(), |a| a.context)
    }
}

/// The closest hit.
#[inline(always)]
fn intersect(committed: &Committed, lane: Lane, asked: Asked) {
    if !committed.is_plain || asked.filters_all() {
        return intersect_told(committed, lane, asked);
    }
    let ray = lane.ray();
    if let Some(hit) = ask!(committed, tree => tree.intersect_with(&committed.query, &ray)) {
        let located = committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
        lane.write(hit.t, &shown(&located, &hit, &ray, asked.context()));
    }
}

/// Whether there is a hit.
#[inline(always)]
fn occluded(committed: &Committed, lane: Lane, asked: Asked) {
    let is_hit = if committed.is_plain && !asked.filters_all() {
        ask!(committed, tree => tree.occluded_with(&committed.query, &lane.ray()))
    } else {
        occluded_told(committed, lane, asked)
    };
    if is_hit {
        lane.set(row::T_FAR, f32::NEG_INFINITY);
    }
}

/// Rays of a packet that are asked for, together, and which lane each of them is.
struct Together<'a> {
    query: Query,
    committed: &'a Committed,
    packet: Packet,
    lanes: [Option<Lane>; Packet::MOST],
}

impl<'a> Together<'a> {
    fn new(committed: &'a Committed, lanes: impl Iterator<Item = Lane>) -> Self {
        let query = Query { coherence: Coherence::Coherent, ..committed.query };
        let mut together = Self { query, committed, packet: Packet::new(), lanes: [None; Packet::MOST] };
        for (at, lane) in lanes.enumerate().take(Packet::MOST) {
            together.packet.push(&lane.ray());
            together.lanes[at] = Some(lane);
        }
        together
    }

    fn intersect(self, asked: Asked) {
        let Self { query, committed, packet, lanes } = self;
        ask!(committed, tree => tree.intersect_packet(&query, packet, |at, hit| {
            if let Some(lane) = lanes[at] {
                let located = committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
                lane.write(hit.t, &shown(&located, &hit, &lane.ray(), asked.context()));
            }
        }));
    }

    fn occluded(self) {
        let Self { query, committed, packet, lanes } = self;
        let hit = ask!(committed, tree => tree.occluded_packet(&query, packet));
        for (at, lane) in lanes.into_iter().enumerate() {
            if let Some(lane) = lane.filter(|_| hit >> at & 1 == 1) {
                lane.set(row::T_FAR, f32::NEG_INFINITY);
            }
        }
    }
}

/// What is asked of each ray.
trait Trace {
    /// Coherent packets of so many rays go together: fewer are faster one by one (bench/record/embree-calls-2026-11-23.md).
    const WORTH_IT: usize;
    fn one(committed: &Committed, lane: Lane, asked: Asked);
    fn together(rays: Together, asked: Asked);
}

struct Intersect;
struct Occluded;

impl Trace for Intersect {
    const WORTH_IT: usize = 8;

    #[inline(always)]
    fn one(committed: &Committed, lane: Lane, asked: Asked) {
        intersect(committed, lane, asked);
    }

    fn together(rays: Together, asked: Asked) {
        rays.intersect(asked);
    }
}

impl Trace for Occluded {
    const WORTH_IT: usize = 16;

    #[inline(always)]
    fn one(committed: &Committed, lane: Lane, asked: Asked) {
        occluded(committed, lane, asked);
    }

    fn together(rays: Together, _: Asked) {
        rays.occluded();
    }
}

/// A query during which the program is asked.
struct Told<'a> {
    committed: &'a Committed,
    frame: &'a Frame,
    ray: Ray,
    /// The ray as callbacks see it: the program's own memory where that is of one lane.
    seen: *mut f32,
    /// The hit that was let pass last, and what the filter made of it.
    passed: Option<(Hit, abi::Hit)>,
    /// Hits that were rejected: leaves list some primitives twice, and filters are asked once.
    rejected: Rejected,
}

/// A few are looked through, many looked up.
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

impl Told<'_> {
    /// Whether filters let a hit pass.
    fn accept(&mut self, hit: &Hit) -> bool {
        let located = self.committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
        // User geometry asks its filters itself.
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
        let mut seen = shown(&located, hit, &self.ray, frame.context);
        let mut valid: c_int = -1;
        // SAFETY: the ray is of one lane, in the program's memory or ours, and the context is never null here.
        let (before, inst_id) = unsafe { (*self.seen.add(row::T_FAR), (*frame.context).inst_id) };
        let arguments = FilterArguments {
            valid: &raw mut valid,
            user_data: located.surface.geometry.user_data(),
            context: frame.context,
            ray: self.seen,
            hit: &raw mut seen,
            n: 1,
        };
        // SAFETY: as above; the program gave the filters to be called like this.
        unsafe {
            *self.seen.add(row::T_FAR) = hit.t;
            (*frame.context).inst_id = seen.inst_id;
            for filter in both.into_iter().flatten() {
                filter(&raw const arguments);
                if (&raw const valid).read_volatile() == 0 {
                    break;
                }
            }
            *self.seen.add(row::T_FAR) = before;
            (*frame.context).inst_id = inst_id;
            if (&raw const valid).read_volatile() == 0 {
                self.rejected.insert(key);
                return false;
            }
            self.passed = Some((*hit, (&raw const seen).read_volatile()));
        }
        true
    }
}

/// Prepares frame, context and ray, and asks.
fn tell<R>(
    committed: &Committed,
    lane: Lane,
    asked: Asked,
    is_occlusion: bool,
    query: impl FnOnce(&mut Told) -> R,
) -> R {
    let none = Arguments { flags: 0, features: u32::MAX, context: null_mut(), filter: None, callback: None };
    let mut arguments = asked.get().unwrap_or(none);
    let mut context = Context { inst_id: INVALID, inst_prim_id: INVALID };
    if arguments.context.is_null() {
        arguments.context = &raw mut context;
    }
    let ray = lane.whole();
    let mut copy = abi::RayHit { ray, hit: abi::Hit::NONE };
    let seen = if lane.n == 1 { lane.first } else { (&raw mut copy).cast() };
    let frame = Frame::new(is_occlusion, arguments, arguments.context, &ray);
    let mut told =
        Told { committed, frame: &frame, ray: lane.ray(), seen, passed: None, rejected: Rejected::default() };
    frame.run(|| query(&mut told))
}

#[cold]
fn intersect_told(committed: &Committed, lane: Lane, asked: Asked) {
    tell(committed, lane, asked, false, |told| {
        let (ray, query) = (told.ray, &committed.query);
        let hit = ask!(committed, tree => tree.intersect_filtered(query, &ray, |_, hit| told.accept(hit)));
        let Some(hit) = hit else { return };
        let located = committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
        let context = told.frame.context;
        let as_found = shown(&located, &hit, &ray, context);
        let seen = match (&told.passed, located.surface.kind) {
            (_, Kind::User) => {
                let kept = told.frame.kept(&located.surface.geometry, hit.prim_id, hit.t);
                kept.map_or(as_found, |kept| completed(kept, &as_found))
            }
            (Some((passed, seen)), _) if *passed == hit => *seen,
            _ => as_found,
        };
        lane.write(hit.t, &seen);
    });
}

/// What the program's test has left, and what only we know.
fn completed(kept: abi::Hit, found: &abi::Hit) -> abi::Hit {
    let or = |kept: u32, found: u32| if kept == INVALID { found } else { kept };
    abi::Hit {
        prim_id: or(kept.prim_id, found.prim_id),
        geom_id: or(kept.geom_id, found.geom_id),
        inst_id: or(kept.inst_id, found.inst_id),
        inst_prim_id: or(kept.inst_prim_id, found.inst_prim_id),
        ..kept
    }
}

#[cold]
fn occluded_told(committed: &Committed, lane: Lane, asked: Asked) -> bool {
    tell(committed, lane, asked, true, |told| {
        let (ray, query) = (told.ray, &committed.query);
        ask!(committed, tree => tree.occluded_filtered(query, &ray, |_, hit| told.accept(hit)))
    })
}

/// What a scene handle, which is a traversable's, too, stands for.
///
/// # Safety
/// The handle is null or a scene's.
#[inline(always)]
unsafe fn committed<'a>(scene: Handle) -> Option<&'a Committed> {
    if scene.is_null() {
        // SAFETY: null is fine.
        unsafe { with::<Scene, ()>(scene, |_| Ok(())) };
        return None;
    }
    // SAFETY: a scene's handle points to it. What it shows is kept until the scene is committed twice, and programs
    // do not commit a scene while they ask it.
    let current = unsafe { (*scene.cast::<Scene>()).current() };
    if current.is_null() {
        // SAFETY: the handle is a scene's.
        unsafe { with::<Scene, ()>(scene, |_| Err(not_committed())) };
        return None;
    }
    // SAFETY: as above.
    Some(unsafe { &*current })
}

pub(crate) fn not_committed() -> Problem {
    Problem::operation("the scene is not committed: call rtcCommitScene first")
}

/// Traces the lanes of a packet that are asked for.
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
    let asked = Asked { arguments };
    guarded(|| {
        let lanes = (0..N)
            // SAFETY: there are `N` numbers in `valid`.
            .filter(|&i| N == 1 || unsafe { *valid.add(i) } != 0)
            // SAFETY: passed on.
            .map(|i| unsafe { Lane::new(rays, N, i) });
        if N >= T::WORTH_IT && committed.is_plain && asked.is_coherent() && !asked.filters_all() {
            T::together(Together::new(committed, lanes), asked);
        } else {
            lanes.for_each(|lane| T::one(committed, lane, asked));
        }
    });
}

macro_rules! packets {
    ($($name:ident, $traversable:ident: $trace:ty, $n:literal;)*) => { $(
        /// Traces a packet. See Embree's manual.
        ///
        /// # Safety
        /// As Embree's headers say: a scene, a packet of this size, which rays of it count, arguments or null.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $name(valid: *const c_int, scene: Handle, rays: *mut f32, arguments: *const Arguments) {
            // SAFETY: passed on.
            unsafe { each::<$n, $trace>(valid, scene, rays, arguments) }
        }

        /// The same; a scene is its own traversable.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $traversable(
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
        pub(crate) unsafe extern "C" fn $name(scene: Handle, ray: *mut f32, arguments: *const Arguments) {
            // SAFETY: passed on.
            unsafe { each::<1, $trace>(std::ptr::null(), scene, ray, arguments) }
        }

        /// The same; a scene is its own traversable.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $traversable(scene: Handle, ray: *mut f32, arguments: *const Arguments) {
            // SAFETY: passed on.
            unsafe { each::<1, $trace>(std::ptr::null(), scene, ray, arguments) }
        }
    )* };
}

single! {
    rtcIntersect1, rtcTraversableIntersect1: Intersect;
    rtcOccluded1, rtcTraversableOccluded1: Occluded;
}

/// Sends the ray of a user geometry's test on into another scene.
///
/// # Safety
/// `arguments` are those that the test was called with, `ray` is of one lane.
unsafe fn forward(
    arguments: *const UserArguments,
    scene: Handle,
    ray: *const abi::Ray,
    inst_id: u32,
    inst_prim_id: Option<u32>,
    trace: impl Fn(&Committed, Lane, Asked),
) {
    // SAFETY: the handle is a scene's.
    let Some(committed) = (unsafe { committed(scene) }) else { return };
    // SAFETY: tests are called with the first part of a `Call`, whose frame is that of the query under way; its context
    // is never null. The rays of a call are ours, one lane, with room for all fields.
    unsafe {
        let call = &*arguments.cast::<Call>();
        let frame = &*call.frame;
        let rays = call.arguments.rays.cast::<abi::Ray>();
        let (asked, before) = (*ray, *rays);
        *rays = abi::Ray { org: asked.org, t_near: asked.t_near, dir: asked.dir, time: asked.time, ..before };
        let outer = (*frame.context).inst_id;
        (*frame.context).inst_id = inst_id;
        let inner = &raw const frame.arguments;
        guarded(|| trace(committed, Lane::new(rays.cast(), 1, 0), Asked { arguments: inner }));
        (*frame.context).inst_id = outer;
        let after = *rays;
        if !frame.is_occlusion
            && after.t_far != before.t_far
            && let Some(id) = inst_prim_id
        {
            Lane::new(rays.cast(), 1, 0).set_id(row::INST_PRIM_ID, id);
        }
        *rays = abi::Ray { t_far: after.t_far, ..before };
    }
}

macro_rules! forward {
    ($($name:ident, $extended:ident: $trace:ident;)*) => { $(
        /// Sends the ray of a user geometry's test on. See Embree's manual.
        ///
        /// # Safety
        /// As Embree's headers say: the arguments of the test, a scene, a ray.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $name(
            arguments: *const UserArguments,
            scene: Handle,
            ray: *const abi::Ray,
            inst_id: c_uint,
        ) {
            // SAFETY: passed on.
            unsafe { forward(arguments, scene, ray, inst_id, None, $trace) }
        }

        /// The same with a place in an array of instances.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $extended(
            arguments: *const UserArguments,
            scene: Handle,
            ray: *const abi::Ray,
            inst_id: c_uint,
            inst_prim_id: c_uint,
        ) {
            // SAFETY: passed on.
            unsafe { forward(arguments, scene, ray, inst_id, Some(inst_prim_id), $trace) }
        }
    )* };
}

forward! {
    rtcForwardIntersect1, rtcForwardIntersect1Ex: intersect;
    rtcForwardOccluded1, rtcForwardOccluded1Ex: occluded;
    rtcTraversableForwardIntersect1, rtcTraversableForwardIntersect1Ex: intersect;
    rtcTraversableForwardOccluded1, rtcTraversableForwardOccluded1Ex: occluded;
}

/// Asks the geometry's own filter from a user geometry's test.
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

/// Asks a user geometry's filter of hits.
///
/// # Safety
/// As Embree's headers say.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcInvokeIntersectFilterFromGeometry(
    arguments: *const UserArguments,
    filter: *const FilterArguments,
) {
    // SAFETY: passed on.
    unsafe { invoke(arguments, filter, false) }
}

/// Asks a user geometry's filter of occlusion.
///
/// # Safety
/// As Embree's headers say.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcInvokeOccludedFilterFromGeometry(
    arguments: *const UserArguments,
    filter: *const FilterArguments,
) {
    // SAFETY: passed on.
    unsafe { invoke(arguments, filter, true) }
}
