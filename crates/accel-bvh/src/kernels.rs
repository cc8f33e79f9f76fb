// SPDX-License-Identifier: GPL-3.0-or-later
//! Code compiled for each level: one table of functions over wide BVHs. Tables are made only here, and
//! reached only through [`Kernels`]. Decision 0018 gives the reasons for tables.
//! Invariant: a table's functions are called with its own token, which proves that the CPU has the level.
//! Tests: `tests/brute_force.rs` of `gnurt-accel`, which runs at every level.
//!
//! Traversals of single rays are compiled for the closest hit and for any hit, each with counters and without,
//! and once for all hits that a callback judges; the others, where a ray spends its time elsewhere, once.

use std::marker::PhantomData;

use gnurt_accel_core::collect::Best;
use gnurt_accel_core::direction_class::{DirectionClass, DirectionClasses};
use gnurt_accel_core::nearest::{AnyHit, Closest, Mode, Nearest};
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::traversal::{RayKind, RayTraversal, TileTraversal};
use gnurt_accel_core::{Counters, Ray};
use gnurt_simd::{Level, Simd, Token, by_level, by_level_of_two, kernel, tile_kernel};

use crate::blocks::BlockIndex;
use crate::boxes::{BoxIndex, EnterMembers, MetBlock};
use crate::incoherent::walk_incoherent;
use crate::index::BvhIndex;
use crate::motion::MotionIndex;
use crate::moving_user::MovingUserIndex;
use crate::tiles::walk_tile;

/// The kernels of one level. Rays are valid and regular, trees not empty.
#[derive(Clone, Copy)]
pub struct Kernels {
    token: Token,
    table: &'static Table,
    token_of_two: Token,
    others: &'static Others,
}

type OnRay<I> = fn(Token, &I, &mut RayTraversal);
/// Whether the ray is valid and regular, and the tree fast; if not, nothing is done.
type Straight = fn(Token, &BvhIndex, &Ray, &mut Nearest) -> bool;
/// The same of an object among others, counted. As many arguments as registers take.
type Counted = fn(Token, &BvhIndex, &Ray, u32, &mut Nearest, &mut Counters) -> bool;
type EnterRay<'a> = &'a mut dyn FnMut(MetBlock) -> f32;
type EnterTile<'a> = &'a mut dyn EnterMembers;
type EnterPoint<'a> = &'a mut dyn FnMut(usize) -> f64;
type OnTile<I> = fn(Token, &I, DirectionClass, &mut TileTraversal);
type OnBoxesTile = fn(Token, &BoxIndex, DirectionClass, &mut TileTraversal, EnterTile);
type OnPoint<I> = fn(Token, &I, &Probe, u32, &mut dyn NearestPoint);

struct Table {
    straight: [Straight; 2],
    closest: Counted,
    any: Counted,
    each: OnRay<BvhIndex>,
    /// `None` where lanes are too narrow for it to pay, as below.
    tile: Option<OnTile<BvhIndex>>,
    incoherent: Option<fn(Token, &BvhIndex, &DirectionClasses, &mut TileTraversal)>,
    boxes: fn(Token, &BoxIndex, &Ray, f32, EnterRay) -> u32,
    boxes_tile: Option<OnBoxesTile>,
}

/// What is compiled for two levels only, AVX2 or NEON and none: eight lanes gain little from AVX-512, and each level
/// takes seconds to compile.
struct Others {
    point: OnPoint<BvhIndex>,
    moving: [OnRay<MotionIndex>; 3],
    moving_user: OnRay<MovingUserIndex>,
    moving_user_point: OnPoint<MovingUserIndex>,
    blocks: OnRay<BlockIndex>,
    blocks_tile: fn(Token, &BlockIndex, &mut TileTraversal) -> bool,
    blocks_point: OnPoint<BlockIndex>,
    boxes_point: fn(Token, &BoxIndex, &[f64; 3], f64, EnterPoint),
}

struct For<S>(PhantomData<S>);

impl<S: Simd> For<S> {
    const TABLE: Table = Table {
        straight: [search_straight::<S, Closest>, search_straight::<S, AnyHit>],
        closest: search::<S, Closest>,
        any: search::<S, AnyHit>,
        each: search_each::<S>,
        tile: tile_kernel!(S, |simd, index, class, traversal| walk_tile(simd, index, class, traversal)),
        incoherent: tile_kernel!(S, |simd, index, classes, traversal| walk_incoherent(
            simd, index, classes, traversal
        )),
        boxes: kernel!(S, |simd, index, ray, reach, enter| index.search(simd, ray, reach, enter)),
        boxes_tile: tile_kernel!(S, |simd, index, class, traversal, enter| index
            .search_tile(simd, class, traversal, enter)),
    };
    const OTHERS: Others = Others {
        point: kernel!(S, |simd, index, probe, slot, nearest| index.nearest(simd, probe, slot, nearest)),
        moving: [moving::<S, Closest>, moving::<S, AnyHit>, moving_each::<S>],
        moving_user: kernel!(S, |simd, index, traversal| index.search(simd, traversal)),
        moving_user_point: kernel!(S, |simd, index, probe, slot, nearest| index
            .nearest(simd, probe, slot, nearest)),
        blocks: kernel!(S, |simd, index, traversal| index.search(simd, traversal)),
        blocks_tile: kernel!(S, |simd, index, traversal| index.search_tile(simd, traversal)),
        blocks_point: kernel!(S, |simd, index, probe, slot, nearest| index
            .nearest(simd, probe, slot, nearest)),
        boxes_point: kernel!(S, |simd, index, point, radius, enter| index.near(simd, point, radius, enter)),
    };
}

fn search<S: Simd, M: Mode>(
    token: Token,
    index: &BvhIndex,
    ray: &Ray,
    slot: u32,
    nearest: &mut Nearest,
    counters: &mut Counters,
) -> bool {
    let simd = S::from_token(token);
    if index.is_compact() {
        return false;
    }
    simd.vectorize(
        #[inline(always)]
        move || index.search_regular(simd, ray, slot, &mut Best::<M>::new(nearest), counters),
    )
}

/// The same without counters, and of an only object: neither has a register.
fn search_straight<S: Simd, M: Mode>(
    token: Token,
    index: &BvhIndex,
    ray: &Ray,
    nearest: &mut Nearest,
) -> bool {
    let simd = S::from_token(token);
    if index.is_compact() {
        return false;
    }
    simd.vectorize(
        #[inline(always)]
        move || index.search_regular(simd, ray, 0, &mut Best::<M>::new(nearest), &mut Counters::default()),
    )
}

/// A compact tree, for all kinds of queries. Cold, so that the kernels above keep their registers.
#[cold]
#[inline(never)]
fn search_compact<S: Simd>(simd: S, index: &BvhIndex, traversal: &mut RayTraversal) {
    simd.vectorize(
        #[inline(always)]
        || index.search_compact(simd, traversal),
    );
}

fn search_each<S: Simd>(token: Token, index: &BvhIndex, traversal: &mut RayTraversal) {
    let simd = S::from_token(token);
    if index.is_compact() {
        return search_compact(simd, index, traversal);
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let traversal = &mut *traversal;
            let (ray, slot, mut counters) = (traversal.ray, traversal.slot, *traversal.counters);
            index.search(simd, ray, slot, traversal, &mut counters);
            *traversal.counters = counters;
        },
    );
}

fn moving<S: Simd, M: Mode>(token: Token, index: &MotionIndex, traversal: &mut RayTraversal) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || {
            let traversal = &mut *traversal;
            let mut best = Best::<M>::new(traversal.nearest);
            index.search(simd, traversal.ray, traversal.slot, &mut best, traversal.counters);
        },
    );
}

fn moving_each<S: Simd>(token: Token, index: &MotionIndex, traversal: &mut RayTraversal) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || {
            let traversal = &mut *traversal;
            let (ray, slot, mut counters) = (traversal.ray, traversal.slot, *traversal.counters);
            index.search(simd, ray, slot, traversal, &mut counters);
            *traversal.counters = counters;
        },
    );
}

impl Kernels {
    /// Those of a level.
    #[must_use]
    pub fn of(level: Level) -> Self {
        let (token, token_of_two) = (level.token(), level.token_of_two());
        Self {
            token,
            table: by_level!(token, S => &For::<S>::TABLE),
            token_of_two,
            others: by_level_of_two!(token_of_two, S => &For::<S>::OTHERS),
        }
    }

    /// Whether there are kernels for tiles.
    #[must_use]
    pub fn has_tiles(&self) -> bool {
        self.table.tile.is_some()
    }

    /// One ray through triangles.
    #[inline(always)]
    pub fn ray(&self, index: &BvhIndex, traversal: &mut RayTraversal) {
        let RayTraversal { ray, slot, ref mut nearest, ref mut counters, .. } = *traversal;
        let is_done = match traversal.kind {
            RayKind::Closest => (self.table.closest)(self.token, index, ray, slot, nearest, counters),
            RayKind::Any => (self.table.any)(self.token, index, ray, slot, nearest, counters),
            RayKind::Each(_) => false,
        };
        if !is_done {
            (self.table.each)(self.token, index, traversal);
        }
    }

    /// The closest hit of any ray with an object of one tree. Whether the ray is valid and regular, and the tree fast; if not,
    /// nothing is done.
    #[inline(always)]
    pub fn closest(&self, index: &BvhIndex, ray: &Ray, nearest: &mut Nearest) -> bool {
        let [closest, _] = self.table.straight;
        closest(self.token, index, ray, nearest)
    }

    /// Any hit; see [`closest`](Self::closest).
    #[inline(always)]
    pub fn any(&self, index: &BvhIndex, ray: &Ray, nearest: &mut Nearest) -> bool {
        let [_, any] = self.table.straight;
        any(self.token, index, ray, nearest)
    }

    /// One ray through moving triangles, at its time.
    #[inline]
    pub fn moving(&self, index: &MotionIndex, traversal: &mut RayTraversal) {
        let [closest, any, each] = self.others.moving;
        let kernel = match traversal.kind {
            RayKind::Closest => closest,
            RayKind::Any => any,
            RayKind::Each(_) => each,
        };
        kernel(self.token_of_two, index, traversal);
    }

    /// A tile's first rays, all of them active and of one direction class, through triangles. Lanes beyond
    /// them up to the next multiple of 16 hold copies of rays without an extent (`t` is -inf). Whether there
    /// is a kernel for it.
    #[inline]
    pub fn tile(
        &self,
        index: &BvhIndex,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
    ) -> bool {
        self.table.tile.inspect(|kernel| kernel(self.token, index, direction_class, traversal)).is_some()
    }

    /// A tile's active rays, of these direction classes and incoherent, through triangles. Whether there is a
    /// kernel.
    #[inline]
    pub fn incoherent(
        &self,
        index: &BvhIndex,
        direction_classes: &DirectionClasses,
        traversal: &mut TileTraversal,
    ) -> bool {
        self.table
            .incoherent
            .inspect(|kernel| kernel(self.token, index, direction_classes, traversal))
            .is_some()
    }

    /// The nearest point of triangles.
    pub fn point(&self, index: &BvhIndex, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        (self.others.point)(self.token_of_two, index, probe, slot, nearest);
    }

    /// One ray through moving user geometry, at its time.
    pub fn moving_user(&self, index: &MovingUserIndex, traversal: &mut RayTraversal) {
        (self.others.moving_user)(self.token_of_two, index, traversal);
    }

    /// Its nearest point at time 0.
    pub fn moving_user_point(
        &self,
        index: &MovingUserIndex,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    ) {
        (self.others.moving_user_point)(self.token_of_two, index, probe, slot, nearest);
    }

    /// One ray through primitives that are not triangles.
    pub fn blocks(&self, index: &BlockIndex, traversal: &mut RayTraversal) {
        (self.others.blocks)(self.token_of_two, index, traversal);
    }

    /// A tile's active rays, all of them regular and incoherent, through such primitives. Whether that is faster than one by
    /// one; if not, nothing is done.
    pub fn blocks_tile(&self, index: &BlockIndex, traversal: &mut TileTraversal) -> bool {
        (self.others.blocks_tile)(self.token_of_two, index, traversal)
    }

    /// Their nearest point.
    pub fn blocks_point(&self, index: &BlockIndex, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        (self.others.blocks_point)(self.token_of_two, index, probe, slot, nearest);
    }

    /// Calls `enter` with the blocks of boxes that `ray`, which is relative to their origin, meets before `reach`; it
    /// answers with the new reach. Returns the number of nodes visited.
    #[inline]
    pub fn boxes(&self, index: &BoxIndex, ray: &Ray, reach: f32, enter: EnterRay) -> u32 {
        (self.table.boxes)(self.token, index, ray, reach, enter)
    }

    /// The same for a tile as [`tile`](Self::tile) takes it. Whether there is a kernel for it.
    pub fn boxes_tile(
        &self,
        index: &BoxIndex,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
        enter: &mut dyn EnterMembers,
    ) -> bool {
        self.table
            .boxes_tile
            .inspect(|kernel| kernel(self.token, index, direction_class, traversal, enter))
            .is_some()
    }

    /// Calls `enter` with the indices of boxes within `radius` of `point`, which is relative to their origin;
    /// it returns the new radius.
    pub fn boxes_point(
        &self,
        index: &BoxIndex,
        point: &[f64; 3],
        radius: f64,
        enter: &mut dyn FnMut(usize) -> f64,
    ) {
        (self.others.boxes_point)(self.token_of_two, index, point, radius, enter);
    }
}
