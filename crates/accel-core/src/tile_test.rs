// SPDX-License-Identifier: GPL-3.0-or-later
//! One triangle against sixteen rays of a tile, and the update of their best hits.
//! Source: [WBW13] in lanes of rays. Space: object. In: a triangle that a chunk's rays may meet.
//! Invariant: each ray gets the hit that it would get as a single ray. Tests: `tests/brute_force.rs` of
//! `gnurt-accel`.

use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};

use crate::beam::Slopes;
use crate::blocks::TriangleBlock;
use crate::chunks::Candidate;
use crate::direction_class::DirectionClass;
use crate::nearest::{AnyHit, Closest, Kind, closer};
use crate::tile::{LANES, NearestTile, PerRay, RayTile, chunk};
use crate::triangle::{
    Sheared, SingleRay, TriangleHits, axes_from, meet_inside, meet_inside_in_lanes, meet_single, pass_edges,
};

/// A tile of one direction class, for tests of triangles.
pub struct TileTest<'a, S: Simd> {
    pub simd: S,
    pub rays: &'a RayTile,
    pub kind: Kind,
    pub slot: u32,
    pub direction_class: DirectionClass,
}

impl<S: Simd> TileTest<'_, S> {
    /// One triangle against one chunk; whether any ray hits.
    #[inline(always)]
    pub fn meet(
        &self,
        block: &TriangleBlock,
        candidate: &Candidate<S>,
        slopes: &Slopes,
        nearest: &mut NearestTile,
    ) -> bool {
        let simd = self.simd;
        let (lane, at) = (candidate.lane, candidate.chunk * LANES);
        let shear = [
            chunk(simd, &slopes.shear[0], at),
            chunk(simd, &slopes.shear[1], at),
            chunk(simd, &slopes.shear[2], at),
        ];
        let edges = pass_edges(simd, candidate.corners, &shear);
        if !edges.inside.any_true() {
            return false;
        }
        let best = chunk(simd, &nearest.t, at);
        let t_near = chunk(simd, &self.rays.t_near, at);
        let reached = edges.reach(shear[2], t_near, best);
        if !reached.lanes.any_true() {
            return false;
        }
        let (TriangleHits { t, u, v, mut hit }, uncertain) = reached.meet(simd);
        let mut found = false;
        if self.kind == Kind::Closest {
            let doubtful = reached.doubtful(simd, t) & !uncertain;
            if doubtful.any_true() {
                hit &= !doubtful;
                found = self.meet_inside(block, lane, slopes, at, doubtful.to_bitmask(), nearest);
            }
        }
        if uncertain.any_true() {
            found |= self.meet_single(block, lane, slopes, at, uncertain.to_bitmask(), nearest);
        }
        if !hit.any_true() {
            return found;
        }
        self.take(block.numbers[lane & 7], at, &TriangleHits { t, u, v, hit }, nearest);
        true
    }

    /// Stores the lanes' hits where they are nearer.
    #[inline(always)]
    fn take(&self, number: u32, at: usize, hits: &TriangleHits<S, f32x16<S>>, nearest: &mut NearestTile) {
        let simd = self.simd;
        let TriangleHits { t, u, v, hit } = *hits;
        let best = chunk(simd, &nearest.t, at);
        let number = u32x16::splat(simd, number);
        let slot = u32x16::splat(simd, self.slot);
        let old_number = u32x16::from_slice(simd, &nearest.number[at..at + LANES]);
        let old_slot = u32x16::from_slice(simd, &nearest.slot[at..at + LANES]);
        let (t, better) = match self.kind {
            Kind::Any => (f32x16::splat(simd, f32::NEG_INFINITY), hit),
            Kind::Closest => (t, hit & closer([t, best], [slot, old_slot], [number, old_number])),
        };
        store(simd, &mut nearest.t, at, better, t);
        store(simd, &mut nearest.u, at, better, u);
        store(simd, &mut nearest.v, at, better, v);
        better.select(number, old_number).store_slice(&mut nearest.number[at..at + LANES]);
        better.select(slot, old_slot).store_slice(&mut nearest.slot[at..at + LANES]);
    }

    /// Lanes that pass inside, but whose `t` floats cannot determine: in doubles, and those that are still
    /// undecided one by one.
    #[cold]
    #[inline(never)]
    fn meet_inside(
        &self,
        block: &TriangleBlock,
        lane: usize,
        slopes: &Slopes,
        at: usize,
        bits: u64,
        nearest: &mut NearestTile,
    ) -> bool {
        let axes = axes_from(self.direction_class.longest_axis);
        let corners = block.corners_of(lane, axes);
        let simd = self.simd;
        let (mut found, mut left) = simd.vectorize(
            #[inline(always)]
            || {
                let org = self.rays.org_lanes(simd, axes, at);
                let dir = self.rays.dir_lanes(simd, axes, at);
                let over_dir = chunk(simd, &slopes.shear[2], at);
                let ([t, u, v], sure) = meet_inside_in_lanes(simd, &corners, &org, &dir, over_dir);
                let (t_near, best) = (chunk(simd, &self.rays.t_near, at), chunk(simd, &nearest.t, at));
                let lanes = mask32x16::from_bitmask(simd, bits & sure);
                let hit = lanes & t.simd_ge(t_near) & t.simd_le(best);
                let found = hit.any_true();
                if found {
                    self.take(block.numbers[lane & 7], at, &TriangleHits { t, u, v, hit }, nearest);
                }
                (found, bits & !sure)
            },
        );
        while left != 0 {
            let i = at + left.trailing_zeros() as usize;
            left &= left - 1;
            let (single, t_near) = (self.single(slopes, axes, i), self.rays.t_near[i]);
            if let Some(triangle_hit) = meet_inside(&corners, &single, t_near, nearest.t[i]) {
                let mut best = nearest.get(i);
                best.offer::<Closest>(triangle_hit, block.numbers[lane & 7], self.slot);
                nearest.set(i, &best);
                found = true;
            }
        }
        found
    }

    /// One ray, along the axes of the sheared space.
    #[inline(always)]
    fn single(&self, slopes: &Slopes, axes: [usize; 3], i: usize) -> SingleRay {
        let sheared = Sheared {
            org: axes.map(|k| self.rays.org[k][i]),
            shear: [slopes.shear[0][i], slopes.shear[1][i], slopes.shear[2][i]],
        };
        SingleRay { sheared, dir: axes.map(|k| self.rays.dir[k][i]) }
    }

    /// Lanes that floats cannot decide.
    #[cold]
    #[inline(never)]
    fn meet_single(
        &self,
        block: &TriangleBlock,
        lane: usize,
        slopes: &Slopes,
        at: usize,
        mut bits: u64,
        nearest: &mut NearestTile,
    ) -> bool {
        let axes = axes_from(self.direction_class.longest_axis);
        let corners = block.corners_of(lane, axes);
        let needs_position = self.kind == Kind::Closest;
        let mut found = false;
        while bits != 0 {
            let i = at + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let mut best = nearest.get(i);
            let single = self.single(slopes, axes, i);
            if let Some(triangle_hit) =
                meet_single(&corners, &single, needs_position, self.rays.t_near[i], best.t)
            {
                match self.kind {
                    Kind::Closest => best.offer::<Closest>(triangle_hit, block.numbers[lane & 7], self.slot),
                    Kind::Any => best.offer::<AnyHit>(triangle_hit, block.numbers[lane & 7], self.slot),
                }
                nearest.set(i, &best);
                found = true;
            }
        }
        found
    }
}

/// Overwrites the lanes in `mask`.
#[inline(always)]
fn store<S: Simd>(simd: S, values: &mut PerRay, at: usize, mask: mask32x16<S>, new: f32x16<S>) {
    let old = chunk(simd, values, at);
    mask.select(new, old).store_slice(&mut values[at..at + LANES]);
}
