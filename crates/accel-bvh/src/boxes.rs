// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes under a wide BVH, entered by the caller: the top tree over the instances of a scene.
//! Source: [WBS03a] for the two levels. A kd-tree would list large instances again and again, and an object costs far
//! more than a triangle to test twice. A leaf block is eight boxes again, with their places as children, so that a ray
//! meets eight of them in one test.
//! Space: that of the boxes, which are relative to an origin. Proof: `tests::every_box_is_in_one_block`,
//! `tests/instances.rs` of `gnurt-accel`.

use gnurt_accel_core::beam::{Beam, Slopes};
use gnurt_accel_core::bits::{TILE, all};
use gnurt_accel_core::heading::Heading;
use gnurt_accel_core::trip::TileTrip;
use gnurt_accel_core::{Aabb, INVALID_ID, Memory, Quality, Ray, Threads, TreeStats};
use gnurt_simd::{Simd, prelude::*};

use crate::blocked::Blocked;
use crate::node::{Child, Node8, WIDTH};
use crate::node_ray::NodeRay;
use crate::point::{Around, square_of};
use crate::walk::walk;

/// Tree over boxes by their places in a list.
#[derive(Debug)]
pub struct BoxIndex {
    over: Blocked<Node8>,
    /// Boxes are relative to it.
    origin: [f32; 3],
}

impl BoxIndex {
    /// Over boxes relative to `origin`, none of them empty.
    ///
    /// # Panics
    /// If there are more than about 2^30.
    #[must_use]
    pub fn build(boxes: &[Aabb], origin: [f32; 3]) -> Self {
        let block = |places: &[u32; WIDTH]| {
            let mut block = Node8::EMPTY;
            for (lane, &place) in places.iter().enumerate().filter(|&(_, &place)| place != INVALID_ID) {
                block.set(lane, &boxes[place as usize], Child::node(place as usize));
            }
            block
        };
        let over = Blocked::build(&boxes, Quality::Medium, Memory::Fast, Threads::Single, block);
        // A billion instances take a hundred times the memory of their tree before.
        Self { over: over.expect("there are fewer than 2^30 boxes"), origin }
    }

    pub(crate) fn over(&self) -> &Blocked<Node8> {
        &self.over
    }

    /// What boxes are relative to.
    #[must_use]
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// Box around everything, relative to the origin.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.over.bounds()
    }

    /// Size and shape; blocks count to the tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let stats = self.over.stats();
        TreeStats { tree_bytes: stats.tree_bytes + stats.primitive_bytes, ..stats }
    }

    /// Calls `enter` with the places of boxes that `ray`, which is regular and relative to the origin, meets before
    /// `reach`, nearer ones first; it answers with the new reach. Returns the number of nodes visited. There are boxes.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        mut reach: f32,
        enter: &mut dyn FnMut(usize) -> f32,
    ) -> u32 {
        let Blocked { tree, blocks, greatest, .. } = &self.over;
        let for_nodes = NodeRay::new(simd, ray, *greatest);
        walk(
            tree,
            simd,
            Child::node(0),
            &for_nodes,
            reach,
            #[inline(always)]
            |range| {
                for block in &blocks[range] {
                    let (mut bits, _) = for_nodes.meet(simd, block, reach);
                    while bits != 0 {
                        let place = block.child(bits.trailing_zeros() as usize).index();
                        bits &= bits - 1;
                        reach = enter(place);
                    }
                }
                reach
            },
        )
    }

    /// The same for a tile's first rays, all of them active and of one heading: `enter` gets the trip of those that still
    /// look for something.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(
        &self,
        simd: S,
        heading: Heading,
        trip: &mut TileTrip,
        enter: &mut dyn FnMut(usize, &mut TileTrip),
    ) {
        let Blocked { tree, blocks, greatest, .. } = &self.over;
        let count = TILE - trip.active.leading_zeros() as usize;
        let mut slopes = Slopes::EMPTY;
        slopes.prepare(simd, trip.rays, count, heading);
        let whole = slopes.all_ranges(simd, trip.rays, count);
        let beam = Beam::new(&whole.relative_to(self.origin), heading, *greatest);
        let mut farthest = slopes.steps_ahead(simd, trip.nearest, count);
        let visited = tree.walk_beam(
            simd,
            &beam,
            farthest,
            #[inline(always)]
            |range| {
                for block in &blocks[range] {
                    let (mut bits, _) = beam.meet(simd, &block.rows, farthest);
                    while bits != 0 {
                        let place = block.child(bits.trailing_zeros() as usize).index();
                        bits &= bits - 1;
                        let active = all(count) & trip.nearest.looking(simd);
                        enter(place, &mut trip.only(active));
                    }
                }
                farthest = slopes.steps_ahead(simd, trip.nearest, count);
                farthest
            },
        );
        trip.counters.nodes += u64::from(visited) * count as u64;
    }

    /// Calls `enter` with the places of boxes within `radius` of `point`, which is relative to the origin, nearer ones
    /// first; it answers with the new radius. There are boxes.
    #[inline(always)]
    pub(crate) fn near<S: Simd>(
        &self,
        simd: S,
        point: &[f64; 3],
        mut radius: f64,
        enter: &mut dyn FnMut(usize) -> f64,
    ) {
        let Blocked { tree, blocks, .. } = &self.over;
        let around = Around::new(simd, point);
        tree.near(simd, point, radius, |range| {
            for block in &blocks[range] {
                let squares = around.squares(simd, block).to_array();
                for (lane, square) in squares.into_iter().enumerate() {
                    if square <= square_of(radius) && !block.bounds(lane).is_empty() {
                        radius = enter(block.child(lane).index());
                    }
                }
            }
            radius
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_box_is_in_one_block() {
        let boxes: Vec<Aabb> = (0..500u32)
            .map(|i| {
                let corner = [i % 7, i * i % 31, i % 13].map(|x| x as f32);
                Aabb { min: corner, max: corner.map(|x| x + (i % 3) as f32) }
            })
            .collect();
        let top = BoxIndex::build(&boxes, [0.0; 3]);
        let mut seen = vec![0; boxes.len()];
        for block in &top.over.blocks {
            for lane in (0..8).filter(|&lane| !block.bounds(lane).is_empty()) {
                let place = block.child(lane).index();
                assert_eq!(block.bounds(lane), boxes[place], "a block has the boxes of its instances");
                seen[place] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n == 1), "each box is in one block");
        assert!(BoxIndex::build(&[], [0.0; 3]).over.tree.nodes.is_empty(), "nothing to see");
    }
}
