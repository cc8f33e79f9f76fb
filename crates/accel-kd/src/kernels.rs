// SPDX-License-Identifier: GPL-3.0-or-later
//! What is compiled for each level: one table of functions over kd-trees, interval hierarchies and grids. This is the only place where they are made, and
//! [`Kernels`] the only door to them.
//! See decision 0018 says why tables. Walks are compiled once for all that rays may look for.
//! Invariant: a table's functions are called with its own token, which proves that the CPU has the level.
//! Tests: `tests/brute_force.rs` of `gnurt-accel`, which asks at every level.

use std::marker::PhantomData;

use gnurt_accel_core::heading::Heading;
use gnurt_accel_core::trip::{RayTrip, TileTrip};
use gnurt_simd::{Simd, Token, by_level};

use crate::grid::GridIndex;
use crate::index::KdIndex;
use crate::interval::IntervalIndex;

/// The kernels of one level. Rays are sound and regular.
#[derive(Clone, Copy)]
pub struct Kernels {
    token: Token,
    table: &'static Table,
}

struct Table {
    ray: fn(Token, &KdIndex, &mut RayTrip),
    /// `None` where lanes are too narrow for it to pay.
    tile: Option<fn(Token, &KdIndex, Heading, &mut TileTrip)>,
    interval: fn(Token, &IntervalIndex, &mut RayTrip),
    interval_tile: Option<fn(Token, &IntervalIndex, Heading, &mut TileTrip)>,
    grid: fn(Token, &GridIndex, &mut RayTrip),
    grid_tile: Option<fn(Token, &GridIndex, Heading, &mut TileTrip)>,
}

struct For<S>(PhantomData<S>);

impl<S: Simd> For<S> {
    const TABLE: Table = Table {
        ray: ray::<S>,
        tile: if S::HAS_TILES { Some(tile::<S>) } else { None },
        interval: interval::<S>,
        interval_tile: if S::HAS_TILES { Some(interval_tile::<S>) } else { None },
        grid: grid::<S>,
        grid_tile: if S::HAS_TILES { Some(grid_tile::<S>) } else { None },
    };
}

fn ray<S: Simd>(token: Token, index: &KdIndex, trip: &mut RayTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || index.search(simd, trip),
    );
}

fn tile<S: Simd>(token: Token, index: &KdIndex, heading: Heading, trip: &mut TileTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || index.search_tile(simd, heading, trip),
    );
}

fn interval<S: Simd>(token: Token, index: &IntervalIndex, trip: &mut RayTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || index.search(simd, trip),
    );
}

fn interval_tile<S: Simd>(token: Token, index: &IntervalIndex, heading: Heading, trip: &mut TileTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || index.search_tile(simd, heading, trip),
    );
}

fn grid<S: Simd>(token: Token, index: &GridIndex, trip: &mut RayTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || index.search(simd, trip),
    );
}

fn grid_tile<S: Simd>(token: Token, index: &GridIndex, heading: Heading, trip: &mut TileTrip) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || index.search_tile(simd, heading, trip),
    );
}

impl Kernels {
    /// Those of a level.
    #[must_use]
    pub fn of(token: Token) -> Self {
        Self { token, table: by_level!(token, S => &For::<S>::TABLE) }
    }

    /// One ray through the tree.
    #[inline]
    pub fn ray(&self, index: &KdIndex, trip: &mut RayTrip) {
        (self.table.ray)(self.token, index, trip);
    }

    /// A tile's first rays, all of them active and of one heading. Lanes beyond them up to the next multiple of 16 hold
    /// copies of rays that look for nothing (`t` is -inf). Whether there is a kernel for it.
    #[inline]
    pub fn tile(&self, index: &KdIndex, heading: Heading, trip: &mut TileTrip) -> bool {
        self.table.tile.inspect(|kernel| kernel(self.token, index, heading, trip)).is_some()
    }

    /// One ray through an interval hierarchy.
    #[inline]
    pub fn interval(&self, index: &IntervalIndex, trip: &mut RayTrip) {
        (self.table.interval)(self.token, index, trip);
    }

    /// A tile as [`tile`](Self::tile) takes it. Whether there is a kernel for it.
    #[inline]
    pub fn interval_tile(&self, index: &IntervalIndex, heading: Heading, trip: &mut TileTrip) -> bool {
        self.table.interval_tile.inspect(|kernel| kernel(self.token, index, heading, trip)).is_some()
    }

    /// One ray through a grid.
    #[inline]
    pub fn grid(&self, index: &GridIndex, trip: &mut RayTrip) {
        (self.table.grid)(self.token, index, trip);
    }

    /// A tile as [`tile`](Self::tile) takes it. Whether there is a kernel for it.
    #[inline]
    pub fn grid_tile(&self, index: &GridIndex, heading: Heading, trip: &mut TileTrip) -> bool {
        self.table.grid_tile.inspect(|kernel| kernel(self.token, index, heading, trip)).is_some()
    }
}
