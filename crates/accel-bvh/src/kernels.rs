// SPDX-License-Identifier: GPL-3.0-or-later
//! What is compiled for each level: one table of functions over wide BVHs. This is the only place where they are made, and
//! [`Kernels`] the only door to them.
//! See decision 0018 says why tables.
//! Invariant: a table's functions are called with its own token, which proves that the CPU has the level.
//! Tests: `tests/brute_force.rs` of `gnurt-accel`, which asks at every level.
//!
//! Walks of single rays are compiled for the closest hit, for any hit and once for all that a callback judges; the others,
//! where a ray spends its time elsewhere, once.

use std::marker::PhantomData;

use gnurt_accel_core::Ray;
use gnurt_accel_core::collect::Best;
use gnurt_accel_core::heading::{Heading, Headings};
use gnurt_accel_core::nearest::{AnyHit, Closest, Mode};
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::trip::{RayKind, RayTrip, TileTrip};
use gnurt_simd::{Simd, Token, by_level};

use crate::apart::walk_apart;
use crate::boxes::BoxIndex;
use crate::index::BvhIndex;
use crate::motion::MotionIndex;
use crate::spheres::SphereIndex;
use crate::tiles::walk_tile;
use crate::user::UserIndex;

/// The kernels of one level. Rays are sound and regular, trees not empty.
#[derive(Clone, Copy)]
pub struct Kernels {
    token: Token,
    table: &'static Table,
}

type OnRay<I> = fn(Token, &I, &mut RayTrip);
type EnterRay<'a> = &'a mut dyn FnMut(usize) -> f32;
type EnterTile<'a> = &'a mut dyn FnMut(usize, &mut TileTrip);
type EnterPoint<'a> = &'a mut dyn FnMut(usize) -> f64;
type OnTile<I> = fn(Token, &I, Heading, &mut TileTrip);
type OnBoxesTile = fn(Token, &BoxIndex, Heading, &mut TileTrip, EnterTile);
type OnPoint<I> = fn(Token, &I, &Probe, u32, &mut dyn NearestPoint);

struct Table {
    closest: OnRay<BvhIndex>,
    any: OnRay<BvhIndex>,
    each: OnRay<BvhIndex>,
    /// `None` where lanes are too narrow for it to pay, as below.
    tile: Option<OnTile<BvhIndex>>,
    apart: Option<fn(Token, &BvhIndex, &Headings, &mut TileTrip)>,
    point: OnPoint<BvhIndex>,
    moving: [OnRay<MotionIndex>; 3],
    spheres: OnRay<SphereIndex>,
    spheres_point: OnPoint<SphereIndex>,
    user: OnRay<UserIndex>,
    user_point: OnPoint<UserIndex>,
    boxes: fn(Token, &BoxIndex, &Ray, f32, EnterRay) -> u32,
    boxes_tile: Option<OnBoxesTile>,
    boxes_point: fn(Token, &BoxIndex, &[f64; 3], f64, EnterPoint),
}

struct For<S>(PhantomData<S>);

impl<S: Simd> For<S> {
    const TABLE: Table = Table {
        closest: search::<S, Closest>,
        any: search::<S, AnyHit>,
        each: search_each::<S>,
        tile: if S::HAS_TILES { Some(tile::<S>) } else { None },
        apart: if S::HAS_TILES { Some(apart::<S>) } else { None },
        point: |token, index, probe, slot, nearest| {
            let simd = S::from_token(token);
            simd.vectorize(
                #[inline(always)]
                || index.nearest(simd, probe, slot, nearest),
            );
        },
        moving: [moving::<S, Closest>, moving::<S, AnyHit>, moving_each::<S>],
        spheres: |token, index, trip| {
            let simd = S::from_token(token);
            simd.vectorize(
                #[inline(always)]
                || index.search(simd, trip),
            );
        },
        spheres_point: |token, index, probe, slot, nearest| {
            let simd = S::from_token(token);
            simd.vectorize(
                #[inline(always)]
                || index.nearest(simd, probe, slot, nearest),
            );
        },
        user: |token, index, trip| {
            let simd = S::from_token(token);
            simd.vectorize(
                #[inline(always)]
                || index.search(simd, trip),
            );
        },
        user_point: |token, index, probe, slot, nearest| {
            let simd = S::from_token(token);
            simd.vectorize(
                #[inline(always)]
                || index.nearest(simd, probe, slot, nearest),
            );
        },
        boxes: |token, index, ray, reach, enter| {
            let simd = S::from_token(token);
            simd.vectorize(
                #[inline(always)]
                || index.search(simd, ray, reach, enter),
            )
        },
        boxes_tile: if S::HAS_TILES { Some(boxes_tile::<S>) } else { None },
        boxes_point: |token, index, point, radius, enter| {
            let simd = S::from_token(token);
            simd.vectorize(
                #[inline(always)]
                || index.near(simd, point, radius, enter),
            );
        },
    };
}

fn search<S: Simd, M: Mode>(token: Token, index: &BvhIndex, trip: &mut RayTrip) {
    let simd = S::from_token(token);
    if index.is_compact() {
        return search_compact(simd, index, trip);
    }
    simd.vectorize(
        #[inline(always)]
        || {
            // The trip as a whole: its fields would be copied, in other sizes than they were written in.
            let trip = &mut *trip;
            let mut best = Best::<M>::new(trip.nearest);
            index.search(simd, trip.ray, trip.slot, &mut best, trip.counters);
        },
    );
}

/// A compact tree, whatever is looked for. Cold, so that the kernels above keep their registers.
#[cold]
#[inline(never)]
fn search_compact<S: Simd>(simd: S, index: &BvhIndex, trip: &mut RayTrip) {
    simd.vectorize(
        #[inline(always)]
        || index.search_compact(simd, trip),
    );
}

fn search_each<S: Simd>(token: Token, index: &BvhIndex, trip: &mut RayTrip) {
    let simd = S::from_token(token);
    if index.is_compact() {
        return search_compact(simd, index, trip);
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let trip = &mut *trip;
            let (ray, slot, mut counters) = (trip.ray, trip.slot, *trip.counters);
            index.search(simd, ray, slot, trip, &mut counters);
            *trip.counters = counters;
        },
    );
}

fn moving<S: Simd, M: Mode>(token: Token, index: &MotionIndex, trip: &mut RayTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || {
            let trip = &mut *trip;
            let mut best = Best::<M>::new(trip.nearest);
            index.search(simd, trip.ray, trip.slot, &mut best, trip.counters);
        },
    );
}

fn moving_each<S: Simd>(token: Token, index: &MotionIndex, trip: &mut RayTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || {
            let trip = &mut *trip;
            let (ray, slot, mut counters) = (trip.ray, trip.slot, *trip.counters);
            index.search(simd, ray, slot, trip, &mut counters);
            *trip.counters = counters;
        },
    );
}

fn tile<S: Simd>(token: Token, index: &BvhIndex, heading: Heading, trip: &mut TileTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || walk_tile(simd, index, heading, trip),
    );
}

fn apart<S: Simd>(token: Token, index: &BvhIndex, headings: &Headings, trip: &mut TileTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || walk_apart(simd, index, headings, trip),
    );
}

fn boxes_tile<S: Simd>(
    token: Token,
    index: &BoxIndex,
    heading: Heading,
    trip: &mut TileTrip,
    enter: &mut dyn FnMut(usize, &mut TileTrip),
) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || index.search_tile(simd, heading, trip, enter),
    );
}

impl Kernels {
    /// Those of a level.
    #[must_use]
    pub fn of(token: Token) -> Self {
        Self { token, table: by_level!(token, S => &For::<S>::TABLE) }
    }

    /// Whether there are kernels for tiles.
    #[must_use]
    pub fn has_tiles(&self) -> bool {
        self.table.tile.is_some()
    }

    /// One ray through triangles.
    #[inline(always)]
    pub fn ray(&self, index: &BvhIndex, trip: &mut RayTrip) {
        let kernel = match trip.kind {
            RayKind::Closest => self.table.closest,
            RayKind::Any => self.table.any,
            RayKind::Each(_) => self.table.each,
        };
        kernel(self.token, index, trip);
    }

    /// One ray through triangles that move, at its moment.
    #[inline]
    pub fn moving(&self, index: &MotionIndex, trip: &mut RayTrip) {
        let [closest, any, each] = self.table.moving;
        let kernel = match trip.kind {
            RayKind::Closest => closest,
            RayKind::Any => any,
            RayKind::Each(_) => each,
        };
        kernel(self.token, index, trip);
    }

    /// A tile's first rays, all of them active and of one heading, through triangles. Lanes beyond them up to the next
    /// multiple of 16 hold copies of rays that look for nothing (`t` is -inf). Whether there is a kernel for it.
    #[inline]
    pub fn tile(&self, index: &BvhIndex, heading: Heading, trip: &mut TileTrip) -> bool {
        self.table.tile.inspect(|kernel| kernel(self.token, index, heading, trip)).is_some()
    }

    /// A tile's active rays, which go these ways and have nothing in common, through triangles. Whether there is a kernel.
    #[inline]
    pub fn apart(&self, index: &BvhIndex, headings: &Headings, trip: &mut TileTrip) -> bool {
        self.table.apart.inspect(|kernel| kernel(self.token, index, headings, trip)).is_some()
    }

    /// The nearest point of triangles.
    pub fn point(&self, index: &BvhIndex, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        (self.table.point)(self.token, index, probe, slot, nearest);
    }

    /// One ray through spheres.
    pub fn spheres(&self, index: &SphereIndex, trip: &mut RayTrip) {
        (self.table.spheres)(self.token, index, trip);
    }

    /// The nearest point of spheres.
    pub fn spheres_point(
        &self,
        index: &SphereIndex,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    ) {
        (self.table.spheres_point)(self.token, index, probe, slot, nearest);
    }

    /// One ray through user geometry.
    pub fn user(&self, index: &UserIndex, trip: &mut RayTrip) {
        (self.table.user)(self.token, index, trip);
    }

    /// The nearest point of user geometry.
    pub fn user_point(&self, index: &UserIndex, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        (self.table.user_point)(self.token, index, probe, slot, nearest);
    }

    /// Calls `enter` with the places of boxes that `ray`, which is relative to their origin, meets before `reach`; it
    /// answers with the new reach. Returns the number of nodes visited.
    #[inline]
    pub fn boxes(&self, index: &BoxIndex, ray: &Ray, reach: f32, enter: &mut dyn FnMut(usize) -> f32) -> u32 {
        (self.table.boxes)(self.token, index, ray, reach, enter)
    }

    /// The same for a tile as [`tile`](Self::tile) takes it. Whether there is a kernel for it.
    pub fn boxes_tile(
        &self,
        index: &BoxIndex,
        heading: Heading,
        trip: &mut TileTrip,
        enter: &mut dyn FnMut(usize, &mut TileTrip),
    ) -> bool {
        self.table.boxes_tile.inspect(|kernel| kernel(self.token, index, heading, trip, enter)).is_some()
    }

    /// Calls `enter` with the places of boxes within `radius` of `point`, which is relative to their origin; it answers with
    /// the new radius.
    pub fn boxes_point(
        &self,
        index: &BoxIndex,
        point: &[f64; 3],
        radius: f64,
        enter: &mut dyn FnMut(usize) -> f64,
    ) {
        (self.table.boxes_point)(self.token, index, point, radius, enter);
    }
}
