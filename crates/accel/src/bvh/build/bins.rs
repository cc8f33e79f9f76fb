// SPDX-License-Identifier: GPL-3.0-or-later
//! Where to divide references: the surface area heuristic at the borders of bins of their middles.
//! Source: [Wald07]; the heuristic of [MB90]. Differs: counts blocks of eight, which cost the same however full.
//! Space: that of the primitives; areas are scaled so that the root's sides are at most 1: a float would overflow.
//! Proof: `super::tests`.

use super::reference::{Part, Reference};
use crate::Aabb;
use crate::bvh::WIDTH;

/// Bins of each axis.
const BINS: usize = 16;

/// References left of `border` bins along `axis` go left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub(super) axis: usize,
    pub(super) border: usize,
    pub(super) cost: f32,
}

/// Maps middles to bins.
#[derive(Clone, Copy)]
pub(super) struct Mapping {
    origin: [f32; 3],
    scale: [f32; 3],
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

impl Mapping {
    pub(super) fn new(middles: &Aabb) -> Self {
        let scale = [0, 1, 2].map(|k| {
            let scale = BINS as f32 * 0.9999 / (middles.max[k] - middles.min[k]);
            // Where all lie in one place there is one bin.
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { origin: middles.min, scale }
    }

    #[inline(always)]
    pub(super) fn bin(&self, reference: &Reference, axis: usize) -> usize {
        let place = (reference.middle(axis) - self.origin[axis]) * self.scale[axis];
        (place as usize).min(BINS - 1)
    }
}

/// Half the surface of a box, its sides multiplied with `scale`; zero for an empty one.
pub(super) fn half_area(bounds: &Aabb, scale: f32) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|k| ((bounds.max[k] - bounds.min[k]) * scale).max(0.0));
    x * y + y * z + z * x
}

/// The cheapest split; `None` where all middles share one bin.
pub(super) fn best_split(references: &[Reference], part: &Part, scale: f32) -> Option<Split> {
    let mapping = Mapping::new(&part.middles);
    let mut bins = [[Bin { bounds: Aabb::EMPTY, count: 0 }; BINS]; 3];
    for reference in references {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[mapping.bin(reference, axis)];
            bin.bounds = bin.bounds.union(&reference.bounds());
            bin.count += 1;
        }
    }
    let mut best: Option<Split> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut right_costs = [0.0; BINS];
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        for border in (1..BINS).rev() {
            bounds = bounds.union(&bins[border].bounds);
            count += bins[border].count;
            right_costs[border] = half_area(&bounds, scale) * count.div_ceil(WIDTH) as f32;
        }
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        for border in 1..BINS {
            bounds = bounds.union(&bins[border - 1].bounds);
            count += bins[border - 1].count;
            let cost = half_area(&bounds, scale) * count.div_ceil(WIDTH) as f32 + right_costs[border];
            let divides = count > 0 && count < references.len();
            if divides && best.is_none_or(|best| cost < best.cost) {
                best = Some(Split { axis, border, cost });
            }
        }
    }
    best
}
