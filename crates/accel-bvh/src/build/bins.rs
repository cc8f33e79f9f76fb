// SPDX-License-Identifier: GPL-3.0-or-later
//! Where to divide references: the surface area heuristic at the borders of bins of their middles.
//! Source: [Wald07]; the heuristic of [MB90]. Differs: counts blocks of eight, which cost the same whether
//! full or not.
//! Space: that of the primitives; areas are scaled so that the root's sides are at most 1: a float would overflow.
//! Invariant: both sides of a split get something; their boxes are exact. Tests: `super::tests`.

use gnurt_simd::{Simd, f32x4, prelude::*};

use super::reference::{Lanes, Reference};
use crate::node::WIDTH;

/// Bins of each axis, a power of two.
pub(super) const BINS: usize = 16;

/// References before bin `border` along `axis` go left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub(super) axis: usize,
    pub(super) border: usize,
    pub(super) cost: f32,
}

impl Split {
    /// Anything is cheaper.
    pub(super) const NONE: Self = Self { axis: 0, border: 0, cost: f32::INFINITY };
}

/// Maps middles to bins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mapping {
    pub(super) origin: [f32; 4],
    /// Zero where an axis has no extent: then all is in its first bin.
    pub(super) scale: [f32; 4],
}

impl Mapping {
    #[inline(always)]
    pub(super) fn new(middles: &Lanes) -> Self {
        let mut mapping = Self { origin: [0.0; 4], scale: [0.0; 4] };
        for axis in 0..3 {
            // A bit less than all bins, so that rounding leads past none.
            let scale = BINS as f32 * 0.9999 / middles.side(axis);
            mapping.scale[axis] = if scale.is_finite() { scale } else { 0.0 };
            mapping.origin[axis] = -middles.0[axis];
        }
        mapping
    }
}

/// The contents of the bins of all axes.
#[derive(Clone)]
pub(super) struct Bins {
    bounds: [[Lanes; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    pub(super) const EMPTY: Self = Self { bounds: [[Lanes::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    /// Sorts `references` in.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, references: &[Reference], mapping: &Mapping) {
        let origin = f32x4::load_array(simd, mapping.origin);
        let scale = f32x4::load_array(simd, mapping.scale);
        // Neighbours often share a bin, and one would have to wait for the other: the two halves alternate.
        let (front, back) = references.split_at(references.len() / 2);
        for (a, b) in front.iter().zip(back) {
            self.put(simd, a, origin, scale);
            self.put(simd, b, origin, scale);
        }
        if let Some(last) = back.get(front.len()) {
            self.put(simd, last, origin, scale);
        }
    }

    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, reference: &Reference, origin: f32x4<S>, scale: f32x4<S>) {
        let reference = reference.load(simd);
        let (low, high) = simd.split_f32x8(reference);
        let position = simd.cvt_i32_f32x4((high - low - origin) * scale);
        let position = position.as_array();
        for ((bounds, counts), &position) in self.bounds.iter_mut().zip(&mut self.counts).zip(position) {
            let bin = position as usize % BINS;
            bounds[bin] = Lanes::store(bounds[bin].load(simd).max(reference));
            counts[bin] += 1;
        }
    }

    /// Adds the contents of `other`.
    pub(super) fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(&other.bounds[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    /// The cheapest split; `None` where all middles share one bin.
    #[inline(always)]
    pub(super) fn best_split<S: Simd>(&self, simd: S, scale: f32) -> Option<Split> {
        let mut best = Split::NONE;
        for axis in 0..3 {
            let counts = &self.counts[axis];
            scan(simd, &self.bounds[axis], [counts, counts], axis, u32::MAX, scale, &mut best);
        }
        (best.border > 0).then_some(best)
    }

    /// The boxes on both sides of `split`.
    #[inline(always)]
    pub(super) fn sides<S: Simd>(&self, simd: S, split: &Split) -> [Lanes; 2] {
        let (left, right) = self.bounds[split.axis].split_at(split.border);
        let mut bounds = [Lanes::EMPTY.load(simd); 2];
        for bin in left {
            bounds[0] = bounds[0].max(bin.load(simd));
        }
        for bin in right {
            bounds[1] = bounds[1].max(bin.load(simd));
        }
        [Lanes::store(bounds[0]), Lanes::store(bounds[1])]
    }
}

/// Searches for a border along `axis` that is cheaper than `best`. References that begin before the border
/// are on its left, those that end behind it on its right; both together may be `most`.
#[inline(always)]
pub(super) fn scan<S: Simd>(
    simd: S,
    bounds: &[Lanes; BINS],
    [begins, ends]: [&[u32; BINS]; 2],
    axis: usize,
    most: u32,
    scale: f32,
    best: &mut Split,
) {
    let mut right_costs = [0.0; BINS];
    let (mut around, mut count) = (Lanes::EMPTY.load(simd), 0);
    for border in (1..BINS).rev() {
        around = around.max(bounds[border].load(simd));
        count += ends[border];
        right_costs[border] = cost(simd, around, count, scale);
    }
    let mut on_right = count + ends[0];
    let (mut around, mut count) = (Lanes::EMPTY.load(simd), 0);
    for border in 1..BINS {
        around = around.max(bounds[border - 1].load(simd));
        count += begins[border - 1];
        on_right -= ends[border - 1];
        // NaN, and so never below, where a side is empty.
        let cost = cost(simd, around, count, scale) + right_costs[border];
        if cost < best.cost && count + on_right <= most {
            *best = Split { axis, border, cost };
        }
    }
}

/// Cost of one side: its area times its blocks; NaN without any reference.
#[inline(always)]
fn cost<S: Simd>(simd: S, bounds: gnurt_simd::f32x8<S>, count: u32, scale: f32) -> f32 {
    let (low, high) = simd.split_f32x8(bounds);
    let sides = (high + low) * f32x4::splat(simd, scale);
    let [x, y, z, _] = *sides.as_array();
    (x * y + y * z + z * x) * count.div_ceil(WIDTH as u32) as f32
}
