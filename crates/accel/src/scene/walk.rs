// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray, or a tile of them, through the top tree and into the objects.
//! Source: [WBS03a] for the two levels; nearer boxes first, boxes beyond the best hit skipped.
//! Space: world until an instance is entered. Proof: `tests/instances.rs`, `tests/brute_force.rs` (`ask`).

use gnurt_simd::Simd;

use super::SceneTree;
use super::instance::Placed;
use crate::bvh::{Beam, Child, NodeRay, Slopes};
use crate::nearest::{Mode, Nearest};
use crate::packet::Heading;
use crate::tile::{NearestTile, RayTile, TILE, all};
use crate::{Counters, Ray};

/// Fewer rays of one heading go one by one.
const WORTH_A_TILE: u32 = 8;

impl SceneTree {
    /// Improves `nearest`; the ray is sound.
    #[inline(never)]
    pub(super) fn search<S: Simd, M: Mode>(
        &self,
        simd: S,
        ray: &Ray,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        if let [only] = &self.placed[..] {
            return only.search::<S, M>(simd, ray, 0, nearest, counters);
        }
        simd.vectorize(
            #[inline(always)]
            || self.search_top::<S, M>(simd, ray, nearest, counters),
        );
    }

    #[inline(always)]
    fn search_top<S: Simd, M: Mode>(
        &self,
        simd: S,
        ray: &Ray,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        if self.placed.is_empty() {
            return;
        }
        let regular = (Ray::SHORTEST..=Ray::LONGEST).contains(&ray.longest());
        // Boxes are met by the regular ray; what is compared are its parameters.
        let (scaled, scale) = if regular { (*ray, 1.0) } else { ray.within(ray.t_near, nearest.t).regular() };
        // Scales are powers of two: their inverses are exact.
        let over_scale = 1.0 / scale;
        let top = &self.top;
        let for_nodes = NodeRay::new(simd, &scaled, top.reach);
        let visited = top.tree.walk(
            simd,
            Child::node(0),
            &for_nodes,
            nearest.t * over_scale,
            #[inline(always)]
            |blocks| {
                for block in &top.blocks[blocks] {
                    let (mut bits, _) = for_nodes.meet(simd, block, nearest.t * over_scale);
                    while bits != 0 {
                        let slot = block.child(bits.trailing_zeros() as usize).index();
                        bits &= bits - 1;
                        self.placed[slot].search::<S, M>(simd, ray, slot as u32, nearest, counters);
                    }
                }
                nearest.t * over_scale
            },
        );
        counters.nodes += u64::from(visited);
    }

    /// The same for the rays of a tile that are in `active`.
    #[inline(never)]
    pub(super) fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        if let [only] = &self.placed[..] {
            return only.search_tile::<S, M>(simd, rays, active, 0, nearest, counters);
        }
        if self.placed.is_empty() || active == 0 {
            return;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                let ways = rays.headings(simd);
                let mut alone = active & !ways.regular;
                let mut left = active & ways.regular;
                while left != 0 {
                    let (heading, bits) = ways.like(left.trailing_zeros() as usize, left);
                    left &= !bits;
                    if bits.count_ones() < WORTH_A_TILE {
                        alone |= bits;
                    } else if bits == u64::MAX {
                        self.sweep_top::<S, M>(simd, rays, TILE, heading, nearest, counters);
                    } else {
                        let (mut some, mut best) = (RayTile::EMPTY, NearestTile::EMPTY);
                        let count = rays.gather(nearest, bits, &mut some, &mut best);
                        self.sweep_top::<S, M>(simd, &some, count, heading, &mut best, counters);
                        nearest.scatter(bits, &best);
                    }
                }
                while alone != 0 {
                    let i = alone.trailing_zeros() as usize;
                    alone &= alone - 1;
                    let mut lane = nearest.get(i);
                    self.search::<S, M>(simd, &rays.ray(i, lane.t), &mut lane, counters);
                    nearest.set(i, &lane);
                }
            },
        );
    }

    /// The first `count` rays have one heading.
    #[inline(always)]
    fn sweep_top<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        count: usize,
        heading: Heading,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        let top = &self.top;
        let mut slopes = Slopes::EMPTY;
        let (_, whole) = slopes.prepare(simd, rays, count, heading);
        let beam = Beam::new(&whole, heading, top.reach);
        let mut farthest = slopes.steps_ahead(simd, nearest, count);
        let visited = top.tree.sweep(
            simd,
            &beam,
            farthest,
            #[inline(always)]
            |blocks| {
                for block in &top.blocks[blocks] {
                    let (mut bits, _) = beam.meet(simd, block, farthest);
                    while bits != 0 {
                        let slot = block.child(bits.trailing_zeros() as usize).index();
                        bits &= bits - 1;
                        let active = all(count) & nearest.looking(simd);
                        self.placed[slot].search_tile::<S, M>(
                            simd,
                            rays,
                            active,
                            slot as u32,
                            nearest,
                            counters,
                        );
                    }
                }
                farthest = slopes.steps_ahead(simd, nearest, count);
                farthest
            },
        );
        counters.nodes += u64::from(visited) * count as u64;
    }
}

impl Placed {
    #[inline(always)]
    fn search<S: Simd, M: Mode>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        match &self.object_from_world {
            None => self.object.search::<S, M>(simd, ray, slot, nearest, counters),
            Some(map) => {
                let inside = map.ray(ray);
                if inside.is_sound() {
                    self.object.search::<S, M>(simd, &inside, slot, nearest, counters);
                }
            }
        }
    }

    #[inline(always)]
    fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        match &self.object_from_world {
            None => self.object.search_tile::<S, M>(simd, rays, active, slot, nearest, counters),
            Some(map) => {
                let mut inside = RayTile::EMPTY;
                map.tile(simd, rays, &mut inside);
                let active = active & inside.sound(simd, nearest);
                self.object.search_tile::<S, M>(simd, &inside, active, slot, nearest, counters);
            }
        }
    }
}
