// SPDX-License-Identifier: GPL-3.0-or-later
//! The run of a batch: its rays in tiles of neighbours, or one by one.
//! Space: that of the target. Tests: `tests/brute_force.rs` (`query`), `tests/masks.rs`.

use gnurt_accel_core::bits::{TILE, all, each};
use gnurt_accel_core::nearest::{Kind, Nearest};
use gnurt_accel_core::tile::{NearestTile, RayTile};
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};

use crate::answers::Answers;
use crate::engine::Engine;
use crate::target::Target;
use crate::{Counters, Ray, RayBatch};

/// The run of a batch.
pub(crate) struct BatchRun<'a> {
    pub(crate) target: Target<'a>,
    pub(crate) engine: &'a Engine,
    pub(crate) rays: &'a RayBatch,
    pub(crate) kind: Kind,
    /// The union of the masks of all its rays.
    pub(crate) mask: u32,
}

impl BatchRun<'_> {
    /// The visibility mask of ray `i`.
    #[inline]
    fn mask_of(&self, i: usize) -> u32 {
        let own = &self.rays.mask;
        if own.is_empty() { self.mask } else { own[i] & self.mask }
    }

    /// Traces a tile's active rays, of which `i` is `index_of(i)` of the batch; rays that see the same go together.
    pub(crate) fn tile(
        &self,
        tile: &mut RayTile,
        active: u64,
        incoherent: bool,
        index_of: impl Fn(usize) -> usize,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        let is_shared = self.rays.mask.is_empty();
        by_mask(
            tile,
            active,
            is_shared,
            |i| self.mask_of(index_of(i)),
            |rays, active| {
                let traversal =
                    &mut TileTraversal { rays, active, kind: self.kind, slot: 0, nearest, counters };
                self.target.tile(self.engine, traversal, incoherent);
            },
        );
    }

    /// Traces rays in tiles of 64 neighbours, which may be `incoherent`.
    pub(crate) fn tiles(&self, incoherent: bool, answers: &mut Answers, counters: &mut Counters) {
        let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
        for first in (0..self.rays.len()).step_by(TILE) {
            let active = if self.rays.len() - first >= TILE {
                self.engine.tiles.load(self.rays, first, &mut tile, &mut nearest)
            } else {
                let count = tile.load(self.rays, first, &mut nearest);
                self.engine.tiles.sound(&tile, &nearest) & all(count)
            };
            self.tile(&mut tile, active, incoherent, |i| first + i, &mut nearest, counters);
            answers.tile(self.engine, first, active, &nearest);
        }
    }

    /// Traces rays one by one and records the cost of each.
    pub(crate) fn singles(&self, answers: &mut Answers, counters: &mut Counters, costs: &mut Vec<u32>) {
        costs.clear();
        costs.reserve(self.rays.len());
        for i in 0..self.rays.len() {
            let before = counters.nodes + counters.triangles;
            let ray = Ray { mask: self.mask_of(i), ..self.rays.get(i) };
            if ray.is_sound() {
                let mut nearest = Nearest::none(ray.t_far);
                let (kind, slot) = (self.kind.into(), 0);
                let nearest_of = &mut nearest;
                let traversal =
                    &mut RayTraversal { ray: &ray, origin: None, kind, slot, nearest: nearest_of, counters };
                self.target.ray(self.engine, traversal);
                if nearest.is_hit() {
                    answers.one(i, &nearest);
                }
            }
            let spent = counters.nodes + counters.triangles - before;
            costs.push(spent.min(u64::from(u32::MAX)) as u32);
        }
    }
}

/// Calls `go` with the active rays of a tile that have one mask, once for each mask. `mask_of` returns the
/// mask of a ray; if it `is_shared`, that of ray 0 holds for all.
pub(crate) fn by_mask(
    tile: &mut RayTile,
    active: u64,
    is_shared: bool,
    mask_of: impl Fn(usize) -> u32,
    mut go: impl FnMut(&RayTile, u64),
) {
    let mut left = active;
    loop {
        let mut same = left;
        let first = left.trailing_zeros() as usize;
        tile.mask = if left == 0 { 0 } else { mask_of(if is_shared { 0 } else { first }) };
        if !is_shared {
            each(left, |i| {
                if mask_of(i) != tile.mask {
                    same &= !(1 << i);
                }
            });
        }
        if same != left {
            // The others, of other masks, have an extent, too.
            tile.direction_class = None;
        }
        go(tile, same);
        left &= !same;
        if left == 0 {
            return;
        }
    }
}
