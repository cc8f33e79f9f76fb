// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays with near origins but different directions: sorted by direction class, then traced in tiles.
//! Source: [RSH05] for the gain of tiles; counting sort. Tests: `tests/brute_force.rs` (`query`).

use gnurt_accel_core::bits::{TILE, all, each};
use gnurt_accel_core::direction_class::{DirectionClass, DirectionClasses};
use gnurt_accel_core::tile::{NearestTile, RayTile};

use crate::Counters;
use crate::answers::Answers;
use crate::batch_run::BatchRun;

/// Rays that are sorted at a time.
const WINDOW: usize = 4096;

/// Direction classes for sorting, and one for untraceable rays: a power of two above their number.
const BUCKETS: usize = 32;
const _: () = assert!(DirectionClasses::CODES < BUCKETS, "each heading has its place");

/// Sorts rays by direction class, then traces them in tiles.
pub(crate) fn trace(batch: &BatchRun, answers: &mut Answers, counters: &mut Counters) {
    let (rays, kernels) = (batch.rays, &batch.engine.tiles);
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    // Not on the stack, which may be small.
    let (mut codes, mut order) = (vec![0u8; WINDOW], vec![0u32; WINDOW]);
    for window in (0..rays.len()).step_by(WINDOW) {
        let count = WINDOW.min(rays.len() - window);
        let mut ends = [0u32; BUCKETS];
        for first in (0..count).step_by(TILE) {
            let there = tile.load(rays, window + first, &mut nearest);
            let sound = kernels.sound(&tile, &nearest) & all(there);
            let of_tile = kernels.codes(&kernels.direction_classes(&tile), sound);
            for (code, &of_ray) in codes[first..count].iter_mut().zip(&of_tile) {
                *code = of_ray as u8;
                ends[of_ray as usize % BUCKETS] += 1;
            }
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum - *end;
        }
        for (i, &code) in codes[..count].iter().enumerate() {
            let bucket_end = &mut ends[code as usize % BUCKETS];
            order[*bucket_end as usize % WINDOW] = (window + i) as u32;
            *bucket_end += 1;
        }
        // The unsound ones come last and are left out.
        let sound = ends[DirectionClasses::CODES - 1] as usize;
        let mut from = 0;
        for (code, &end) in ends[..DirectionClasses::CODES].iter().enumerate() {
            let end = end as usize;
            while from < end {
                let some = &order[from..end.min(from + TILE)];
                tile.pick(rays, some, DirectionClass::of_code(code), &mut nearest);
                let active = all(some.len());
                batch.tile(&mut tile, active, false, |i| some[i] as usize, &mut nearest, counters);
                each(active & kernels.hit(&nearest), |i| answers.one(some[i] as usize, &nearest.get(i)));
                from += some.len();
            }
        }
        debug_assert_eq!(from, sound, "every sound ray was traced");
    }
}
