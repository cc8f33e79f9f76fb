// SPDX-License-Identifier: GPL-3.0-or-later
//! Pieces of curves between the test of their capsules and that of the curves: vertices are requested at once and read at
//! the next leaf, so that a ray does not wait for them. Tests: `many_curves_in_one_leaf_are_all_tested` of
//! `gnurt-accel`.

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::traversal::RayTraversal;

use gnurt_simd::Simd;

use super::block::{CurveBlock, ReadyRay};
use crate::blocked::Shared;
use crate::node::WIDTH;

/// Most pieces that wait.
pub(super) const MOST_WAIT: usize = 32;

/// Pieces whose capsules are met. They are tested at the next leaf, when their vertices have arrived.
pub struct Waiting {
    pub(super) count: usize,
    /// Lanes of all blocks.
    pub(super) places: [u32; MOST_WAIT],
    /// No hit is nearer along the ray.
    pub(super) starts: [f32; MOST_WAIT],
}

impl Default for Waiting {
    #[inline(always)]
    fn default() -> Self {
        Self { count: 0, places: [0; MOST_WAIT], starts: [0.0; MOST_WAIT] }
    }
}

impl Waiting {
    /// Tests the first pieces. Returns how many were tested.
    #[inline(always)]
    pub(super) fn test<S: Simd>(
        &mut self,
        simd: S,
        count: usize,
        blocks: &[CurveBlock],
        ready: &ReadyRay<S>,
        shared: &Shared<CurveBlock>,
        traversal: &mut RayTraversal,
    ) -> u64 {
        let mut tested = 0;
        let length = ready.rough.length;
        for i in 0..count.min(MOST_WAIT) {
            let place = self.places[i] as usize;
            if self.starts[i] <= traversal.reach() * length && !traversal.is_done() {
                tested += 1;
                blocks[place / WIDTH].meet_one(simd, place % WIDTH, ready, shared, traversal.slot, traversal);
            }
        }
        for i in count..self.count.min(MOST_WAIT) {
            (self.places[i - count], self.starts[i - count]) = (self.places[i], self.starts[i]);
        }
        self.count -= count;
        tested
    }
}
