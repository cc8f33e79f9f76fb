// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a batch's answers go. Tests: `tests/brute_force.rs`.

use gnurt_accel_core::bits::each;
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::tile::NearestTile;

use crate::HitBatch;
use crate::engine::Engine;
use crate::target::Target;

/// As long as the batch.
pub(crate) enum Answers<'a> {
    /// Closest hits of a target; all are misses at first.
    Hits(Target<'a>, &'a mut HitBatch),
    /// One flag for each ray; none is set at first.
    Flags(&'a mut [bool]),
}

impl Answers<'_> {
    /// Ray `i` has hit.
    #[inline]
    pub(crate) fn one(&mut self, i: usize, nearest: &Nearest) {
        match self {
            Self::Hits(target, hits) => hits.set(i, target.hit(nearest)),
            Self::Flags(flags) => flags[i] = true,
        }
    }

    /// Rays from `first` on, those in `active`, have been traced.
    pub(crate) fn tile(&mut self, engine: &Engine, first: usize, active: u64, nearest: &NearestTile) {
        match self {
            Self::Hits(target, hits) => {
                let hit = active & engine.tiles.hit(nearest);
                if active == u64::MAX
                    && let Some((ids, object)) = target.only_object()
                    && let Some(starts) = object.few_starts()
                    // Where few rays hit something, their ids are found sooner one by one.
                    && starts.len() <= 4 * hit.count_ones() as usize
                {
                    return engine.tiles.store(nearest, (ids, starts), hits, first);
                }
                target.write(nearest, hit, first, hits);
            }
            Self::Flags(flags) => each(active & engine.tiles.hit(nearest), |i| flags[first + i] = true),
        }
    }
}
