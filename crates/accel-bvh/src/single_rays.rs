// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays of a tile that are traced singly but prepared together, sixteen at a time: all of them if they are
//! incoherent, the last few of a subtree otherwise.
//! Source: the arithmetic of [`NodeRay::new`] and [`BlockRay::new`] in lanes, with the same bits.
//! Tests: `tests/brute_force.rs` of `gnurt-accel`.

use gnurt_accel_core::Aabb;
use gnurt_accel_core::bits::{TILE, each};
use gnurt_accel_core::blocks::{BlockRay, TriangleBlock};
use gnurt_accel_core::collect::{Best, BestOf, Collect};
use gnurt_accel_core::direction_class::{DirectionClass, DirectionClasses};
use gnurt_accel_core::nearest::{AnyHit, Closest, Kind, Mode};
use gnurt_accel_core::tile::{LANES, PerRay, RayTile};
use gnurt_accel_core::traversal::TileTraversal;
use gnurt_accel_core::triangle::{Sheared, SingleRay, axes_from, shear};
use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*};

use crate::index::BvhIndex;
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::planes::TilePlanes;
use crate::triangles::Prepared;

/// Direction classes of rays.
#[derive(Clone, Copy)]
pub(super) enum ClassesOf {
    /// All of them.
    One(DirectionClass),
    /// Each with its own.
    Each(DirectionClasses),
}

/// Rays prepared for nodes and blocks. Those of irregular length are not.
#[derive(Clone, Copy)]
pub(super) struct SingleRays<'a> {
    pub(super) planes: &'a TilePlanes,
    /// Along the axes of each ray's own sheared space.
    pub(super) org: [&'a PerRay; 3],
    pub(super) shear: &'a [PerRay; 3],
    /// Along x, y and z.
    pub(super) dir: &'a [PerRay; 3],
    pub(super) t_near: &'a PerRay,
    pub(super) classes: ClassesOf,
}

impl SingleRays<'_> {
    #[inline(always)]
    pub(super) fn direction_class(&self, i: usize) -> DirectionClass {
        match &self.classes {
            ClassesOf::One(direction_class) => *direction_class,
            ClassesOf::Each(direction_classes) => direction_classes.of(i),
        }
    }

    /// Ray `i` for nodes, whose nearer planes are in `rows`.
    #[inline(always)]
    pub(super) fn for_nodes<S: Simd>(&self, simd: S, i: usize, rows: [usize; 3]) -> NodeRay<S> {
        self.planes.single_rays(simd, i, rows, self.t_near[i % TILE])
    }

    /// Ray `i` for blocks, given the axis along which it moves most.
    #[inline(always)]
    pub(super) fn for_blocks<S: Simd>(&self, simd: S, i: usize, longest_axis: usize) -> BlockRay<S> {
        let i = i % TILE;
        let ([x, y, z], [a, b, c]) = (self.org, self.shear);
        let sheared = Sheared { org: [x[i], y[i], z[i]], shear: [a[i], b[i], c[i]] };
        let [along_x, along_y, along_z] = axes_from(longest_axis);
        let dir = [self.dir[along_x][i], self.dir[along_y][i], self.dir[along_z][i]];
        BlockRay::sheared(simd, [along_x, along_y, along_z], SingleRay { sheared, dir }, self.t_near[i])
    }

    /// Ray `i`.
    #[inline(always)]
    fn prepared<S: Simd>(&self, simd: S, i: usize) -> Prepared<S> {
        let direction_class = self.direction_class(i);
        Prepared {
            for_nodes: self.for_nodes(simd, i, direction_class.rows()),
            for_blocks: self.for_blocks(simd, i, direction_class.longest_axis),
        }
    }

    /// Each active ray of a traversal from `start` on, one after the other; returns the chunks in which an
    /// end came nearer. A separate function, so that traversals are compiled once for all tiles.
    #[inline(always)]
    pub(super) fn walk<S: Simd>(
        &self,
        simd: S,
        index: &BvhIndex,
        start: Child,
        traversal: &mut TileTraversal,
    ) -> u32 {
        match traversal.kind {
            _ if index.is_compact() => self.walk_compact(simd, index, start, traversal),
            Kind::Closest => self.walk_for::<S, Closest>(simd, index, start, traversal),
            Kind::Any => self.walk_for::<S, AnyHit>(simd, index, start, traversal),
        }
    }

    #[inline(never)]
    fn walk_for<S: Simd, M: Mode>(
        &self,
        simd: S,
        index: &BvhIndex,
        start: Child,
        traversal: &mut TileTraversal,
    ) -> u32 {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut touched = 0;
                each(
                    traversal.active,
                    #[inline(always)]
                    |i| {
                        let before = traversal.nearest.t[i % TILE];
                        let mut found = traversal.nearest.get(i);
                        let mut best = Best::<M>::new(&mut found);
                        let ray = self.prepared(simd, i);
                        index.walk(simd, start, &ray, traversal.slot, &mut best, traversal.counters);
                        // Also where `t` stays: a triangle with a lower number may lie there.
                        traversal.nearest.set(i, &found);
                        touched |= u32::from(found.t != before) << (i / LANES);
                    },
                );
                touched
            },
        )
    }

    /// The same in a compact tree.
    #[inline(never)]
    fn walk_compact<S: Simd>(
        &self,
        simd: S,
        index: &BvhIndex,
        start: Child,
        traversal: &mut TileTraversal,
    ) -> u32 {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut touched = 0;
                each(
                    traversal.active,
                    #[inline(always)]
                    |i| {
                        let before = traversal.nearest.t[i % TILE];
                        let ray = self.prepared(simd, i);
                        traversal.only(1 << i).one_by_one(
                            #[inline(always)]
                            |traversal| index.walk_compact(simd, start, &ray, traversal),
                        );
                        touched |= u32::from(traversal.nearest.t[i % TILE] != before) << (i / LANES);
                    },
                );
                touched
            },
        )
    }

    /// Each active and unfinished ray of a traversal against the triangles of a block; returns as
    /// [`walk`](Self::walk) does.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, block: &TriangleBlock, traversal: &mut TileTraversal) -> u32 {
        let mut touched = 0;
        each(
            traversal.active,
            #[inline(always)]
            |i| {
                let before = traversal.nearest.t[i % TILE];
                let mut best = BestOf { nearest: traversal.nearest.get(i), kind: traversal.kind };
                if !best.is_done() {
                    let ray = self.for_blocks(simd, i, self.direction_class(i).longest_axis);
                    traversal.counters.triangles += WIDTH as u64;
                    block.meet(simd, &ray, traversal.slot, &mut best);
                    traversal.nearest.set(i, &best.nearest);
                    touched |= u32::from(best.nearest.t != before) << (i / LANES);
                }
            },
        );
        touched
    }
}

/// Prepared data of incoherent rays.
#[repr(C, align(64))]
pub(super) struct PreparedTile {
    planes: TilePlanes,
    /// Along the axes of each ray's own sheared space.
    sheared: Sheared<PerRay>,
}

impl PreparedTile {
    /// Prepares the first `count` rays for a tree whose greatest coordinate is `greatest`.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, rays: &RayTile, count: usize, greatest: f32) -> Self {
        let zero = [[0.0; TILE]; 3];
        let mut prepared = Self { planes: TilePlanes::EMPTY, sheared: Sheared { org: zero, shear: zero } };
        prepared.planes.prepare(simd, rays, count, greatest);
        for at in (0..count).step_by(LANES) {
            prepared.shear(simd, rays, at);
        }
        prepared
    }

    #[inline(always)]
    fn shear<S: Simd>(&mut self, simd: S, rays: &RayTile, at: usize) {
        let dir = rays.dir_lanes(simd, [0, 1, 2], at);
        let [x, y, z] = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let along = [x.simd_ge(y) & x.simd_ge(z), y.simd_ge(z)];
        let org = turned(rays.org_lanes(simd, [0, 1, 2], at), along);
        let shear = shear(turned(dir, along), f32x16::splat(simd, 1.0));
        for k in 0..3 {
            org[k].store_slice(&mut self.sheared.org[k][at..at + LANES]);
            shear[k].store_slice(&mut self.sheared.shear[k][at..at + LANES]);
        }
    }

    /// Bits of the first `count` rays that meet a box, which has no greater coordinates than the tree. The others meet nothing
    /// inside of it: its planes are rounded as those of its parts are.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(
        &self,
        simd: S,
        traversal: &TileTraversal,
        count: usize,
        bounds: &Aabb,
    ) -> u64 {
        let mut bits = 0;
        for at in (0..count).step_by(LANES) {
            bits |= self.planes.meet_box(simd, traversal, bounds, at) << at;
        }
        bits
    }

    /// The rays, of these direction classes, one by one.
    #[inline(always)]
    pub(super) fn single_rays<'a>(
        &'a self,
        rays: &'a RayTile,
        direction_classes: &DirectionClasses,
    ) -> SingleRays<'a> {
        let Self { planes, sheared: Sheared { org: [x, y, z], shear } } = self;
        let (dir, t_near) = (&rays.dir, &rays.t_near);
        SingleRays {
            planes,
            org: [x, y, z],
            shear,
            dir,
            t_near,
            classes: ClassesOf::Each(*direction_classes),
        }
    }
}

/// Along the axes of the sheared space: for rays along x, the value of axis `k + 1` in cyclic order, and so
/// on.
#[inline(always)]
fn turned<S: Simd>([x, y, z]: [f32x16<S>; 3], [along_x, along_y]: [mask32x16<S>; 2]) -> [f32x16<S>; 3] {
    [
        along_x.select(y, along_y.select(z, x)),
        along_x.select(z, along_y.select(x, y)),
        along_x.select(x, along_y.select(y, z)),
    ]
}
