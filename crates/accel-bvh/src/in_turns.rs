// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays of a tile through primitives that are not single triangles, several of them in flight: each makes one step in its turn,
//! and requests the memory of its next one. Source: group prefetching of \[CAGM04\], as in `interleaved.rs`.
//! Invariant: the hits are those of single rays. Tests: `tests/curves.rs`, `tests/grid_meshes.rs` of `gnurt-accel`.

use gnurt_accel_core::Ray;
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};
use gnurt_simd::{Simd, StackBuffer, prefetch, prelude::*};

use crate::blocked::{BlockKind, Blocked};
use crate::node::Child;
use crate::node_ray::NodeRay;
use crate::walk::{MOST_WAIT, Nodes, nearest_first, next};

/// Rays in flight.
const AT_ONCE: usize = 8;

/// Trees below this many bytes are in a core's own cache.
const CACHED: usize = 2_000_000;

/// A ray in flight.
struct InFlight<S: Simd, B: BlockKind> {
    /// Its index in the tile.
    i: usize,
    ray: Ray,
    for_nodes: NodeRay<S>,
    ready: B::Ready<S>,
    /// Primitives whose vertices are on the way.
    waiting: B::Waiting,
    child: Child,
    /// Nothing is left to visit.
    is_over: bool,
    nearest: Nearest,
}

impl<B: BlockKind> Blocked<B> {
    /// Improves the hits of a tile's active rays, which are valid and regular, where they are many and far from each other: others
    /// find what they need in the cache. Whether they are.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(&self, simd: S, traversal: &mut TileTraversal) -> bool {
        let bytes = self.tree.node_bytes() + size_of_val(&self.blocks[..]);
        if bytes < CACHED || !traversal.rays.origins_differ(simd, traversal.active, &self.tree.bounds) {
            return false;
        }
        let (mut left, mut tested, mut visited) = (traversal.active, 0, 0);
        let mut stacks = [const { StackBuffer::<u64, MOST_WAIT>::new() }; AT_ONCE];
        let mut rays: [Option<InFlight<S, B>>; AT_ONCE] = [const { None }; AT_ONCE];
        let mut flying = 0;
        for ray in &mut rays {
            *ray = self.start(simd, &mut left, traversal);
            flying += u32::from(ray.is_some());
        }
        while flying != 0 {
            for (slot, stack) in rays.iter_mut().zip(&mut stacks) {
                let Some(ray) = slot else { continue };
                visited += 1;
                if self.step(simd, ray, stack, traversal, &mut tested) {
                    traversal.nearest.set(ray.i % TILE, &ray.nearest);
                    stack.clear();
                    *slot = self.start(simd, &mut left, traversal);
                    flying -= u32::from(slot.is_none());
                }
            }
        }
        traversal.counters.nodes += visited;
        traversal.counters.triangles += tested;
        true
    }

    /// The next of the rays that are left.
    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, left: &mut u64, traversal: &TileTraversal) -> Option<InFlight<S, B>> {
        while *left != 0 {
            let i = left.trailing_zeros() as usize;
            *left &= *left - 1;
            let nearest = traversal.nearest.get(i);
            if nearest.t > f32::NEG_INFINITY {
                let ray = traversal.rays.ray(i, nearest.t);
                let for_nodes = NodeRay::new(simd, &ray, self.greatest);
                let ready = B::ready(simd, &ray, self.greatest);
                let (waiting, child) = (B::Waiting::default(), Child::node(0));
                return Some(InFlight { i, ray, for_nodes, ready, waiting, child, is_over: false, nearest });
            }
        }
        None
    }

    /// Makes the tests that wait, and visits a node or a leaf. Whether the ray has its hit.
    #[inline(always)]
    fn step<S: Simd>(
        &self,
        simd: S,
        in_flight: &mut InFlight<S, B>,
        stack: &mut StackBuffer<u64, MOST_WAIT>,
        tile: &mut TileTraversal,
        tested: &mut u64,
    ) -> bool {
        let Self { tree, blocks, shared, .. } = self;
        let InFlight { ray, for_nodes, ready, waiting, child, is_over, nearest, .. } = in_flight;
        let (kind, slot) = (tile.kind.into(), tile.slot);
        let counters = &mut *tile.counters;
        let traversal = &mut RayTraversal { ray, origin: None, kind, slot, nearest, counters };
        *tested += B::finish(blocks, simd, ready, shared, waiting, traversal);
        let reach = traversal.reach();
        if *is_over || reach == f32::NEG_INFINITY {
            return true;
        }
        stack.resume(
            #[inline(always)]
            |stack| {
                if child.is_leaf() {
                    *tested += B::meet_leaf(blocks, child.blocks(), simd, ready, shared, waiting, traversal);
                } else {
                    let (bits, near, children) = tree.meet(simd, child.index(), for_nodes, reach);
                    if bits != 0 {
                        *child = if bits & (bits - 1) == 0 {
                            Child::at(children, bits.trailing_zeros() as usize)
                        } else {
                            nearest_first(bits, near.as_array(), children, stack)
                        };
                        return;
                    }
                }
                match next(stack, traversal.reach()) {
                    Some(next) => *child = next,
                    None => *is_over = true,
                }
            },
        );
        if child.is_leaf() {
            prefetch(blocks, child.blocks().start);
        } else {
            prefetch(&tree.nodes, child.index());
        }
        false
    }
}
