// SPDX-License-Identifier: GPL-3.0-or-later
//! Code compiled for each level: one table of functions over kd-trees, interval hierarchies and grids. Tables
//! are made only here, and reached only through [`Kernels`]. Decision 0018 gives the reasons for tables.
//! Traversals are compiled once for all kinds of queries.
//! Invariant: a table's functions are called with its own token, which proves that the CPU has the level.
//! Tests: `tests/brute_force.rs` of `gnurt-accel`, which runs at every level.

use std::marker::PhantomData;

use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};
use gnurt_simd::{Simd, Token, by_level, kernel, tile_kernel};

use crate::any::ResearchIndex;
use crate::grid::GridIndex;
use crate::index::KdIndex;
use crate::interval::IntervalIndex;

/// The kernels of one level. Rays are valid and regular.
#[derive(Clone, Copy)]
pub struct Kernels {
    token: Token,
    table: &'static Table,
}

struct Table {
    ray: fn(Token, &KdIndex, &mut RayTraversal),
    /// `None` where lanes are too narrow for it to pay.
    tile: Option<fn(Token, &KdIndex, DirectionClass, &mut TileTraversal)>,
    interval: fn(Token, &IntervalIndex, &mut RayTraversal),
    interval_tile: Option<fn(Token, &IntervalIndex, DirectionClass, &mut TileTraversal)>,
    grid: fn(Token, &GridIndex, &mut RayTraversal),
    grid_tile: Option<fn(Token, &GridIndex, DirectionClass, &mut TileTraversal)>,
}

struct For<S>(PhantomData<S>);

impl<S: Simd> For<S> {
    const TABLE: Table = Table {
        ray: kernel!(S, |simd, index, traversal| index.search(simd, traversal)),
        tile: tile_kernel!(S, |simd, index, class, traversal| index.search_tile(simd, class, traversal)),
        interval: kernel!(S, |simd, index, traversal| index.search(simd, traversal)),
        interval_tile: tile_kernel!(S, |simd, index, class, traversal| index
            .search_tile(simd, class, traversal)),
        grid: kernel!(S, |simd, index, traversal| index.search(simd, traversal)),
        grid_tile: tile_kernel!(S, |simd, index, class, traversal| index.search_tile(simd, class, traversal)),
    };
}

impl Kernels {
    /// Those of a level.
    #[must_use]
    pub fn of(token: Token) -> Self {
        Self { token, table: by_level!(token, S => &For::<S>::TABLE) }
    }

    /// One ray through the structure.
    #[inline]
    pub fn ray(&self, index: &ResearchIndex, traversal: &mut RayTraversal) {
        match index {
            ResearchIndex::Kd(index) => (self.table.ray)(self.token, index, traversal),
            ResearchIndex::Interval(index) => (self.table.interval)(self.token, index, traversal),
            ResearchIndex::Grid(index) => (self.table.grid)(self.token, index, traversal),
        }
    }

    /// A tile's first rays, all of them active and of one direction class. Lanes beyond them up to the next
    /// multiple of 16 hold copies of rays without an extent (`t` is -inf). Whether there is a kernel for it.
    #[inline]
    pub fn tile(
        &self,
        index: &ResearchIndex,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
    ) -> bool {
        let token = self.token;
        match index {
            ResearchIndex::Kd(index) => {
                self.table.tile.inspect(|kernel| kernel(token, index, direction_class, traversal)).is_some()
            }
            ResearchIndex::Interval(index) => {
                let kernel = self.table.interval_tile;
                kernel.inspect(|kernel| kernel(token, index, direction_class, traversal)).is_some()
            }
            ResearchIndex::Grid(index) => {
                let kernel = self.table.grid_tile;
                kernel.inspect(|kernel| kernel(token, index, direction_class, traversal)).is_some()
            }
        }
    }
}
