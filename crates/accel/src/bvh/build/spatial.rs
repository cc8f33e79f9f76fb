// SPDX-License-Identifier: GPL-3.0-or-later
//! Where space is better divided than a set of references: those on a plane are cut in two.
//! Source: [SFD09] sections 4.1 and 4.2. Differs: counts blocks of eight; no references are put together again.
//! Space: that of the primitives; areas are scaled as in `bins`.
//! Invariant: the parts of a reference cover what it covered. Proof: `super::tests::parts_cover_the_whole`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use super::Primitives;
use super::bins::{BINS, Split, sweep};
use super::reference::{Lanes, Reference};
use crate::Aabb;

/// A plane `p[axis] == at`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) axis: usize,
    pub(super) at: f32,
    pub(super) cost: f32,
}

/// A box in slabs, and what is in them, for all axes.
pub(super) struct Slabs {
    /// The slabs themselves: boxes without end along the other axes.
    cells: [[Lanes; BINS]; 3],
    /// Around what is seen of references in each slab, taking boxes for what they hold.
    bounds: [[Lanes; BINS]; 3],
    /// References whose first, or last, slab it is.
    begins: [[u32; BINS]; 3],
    ends: [[u32; BINS]; 3],
}

impl Slabs {
    pub(super) const EMPTY: Self = Self {
        cells: [[Lanes([f32::INFINITY; 8]); BINS]; 3],
        bounds: [[Lanes::EMPTY; BINS]; 3],
        begins: [[0; BINS]; 3],
        ends: [[0; BINS]; 3],
    };

    /// The cheapest plane through the box `whole` around `references`; what was here before is forgotten.
    #[inline(always)]
    pub(super) fn best_plane<S: Simd>(
        &mut self,
        simd: S,
        references: &[Reference],
        whole: &Lanes,
        scale: f32,
    ) -> Option<Plane> {
        *self = Self::EMPTY;
        let (mut origin, mut slabs_per_unit, mut signs) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        let mut width = [0.0; 3];
        for (axis, width) in width.iter_mut().enumerate() {
            let per_unit = BINS as f32 * 0.9999 / whole.side(axis);
            for lane in [axis, axis + 4] {
                slabs_per_unit.0[lane] = if per_unit.is_finite() { per_unit } else { 0.0 };
                origin.0[lane] = -whole.0[axis];
                signs.0[lane] = if lane < 4 { -1.0 } else { 1.0 };
            }
            *width = if per_unit.is_finite() { 1.0 / per_unit } else { 0.0 };
            for (slab, cell) in self.cells[axis].iter_mut().enumerate() {
                cell.0[axis] = -(slab as f32 * *width - whole.0[axis]);
                cell.0[axis + 4] = (slab + 1) as f32 * *width - whole.0[axis];
            }
        }
        let (at, per_unit, signs) = (origin.load(simd), slabs_per_unit.load(simd), signs.load(simd));
        for reference in references {
            self.add(simd, reference.load(simd), (at, per_unit, signs));
        }
        let mut best = Split::NONE;
        for axis in 0..3 {
            sweep(simd, &self.bounds[axis], &self.begins[axis], &self.ends[axis], axis, scale, &mut best);
        }
        let Split { axis, border, cost } = best;
        let at = border as f32 * width[axis] - whole.0[axis];
        (border > 0).then_some(Plane { axis, at, cost })
    }

    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        reference: f32x8<S>,
        (origin, per_unit, signs): (f32x8<S>, f32x8<S>, f32x8<S>),
    ) {
        let slabs = simd.cvt_i32_f32x8((reference * signs - origin) * per_unit);
        let slabs = slabs.as_array();
        for axis in 0..3 {
            let (first, last) = (slabs[axis] as usize % BINS, slabs[axis + 4] as usize % BINS);
            self.begins[axis][first] += 1;
            self.ends[axis][last] += 1;
            let bounds = &mut self.bounds[axis];
            if first == last {
                bounds[first] = Lanes::store(bounds[first].load(simd).max(reference));
                continue;
            }
            for (bounds, cell) in bounds.iter_mut().zip(&self.cells[axis]).take(last + 1).skip(first) {
                let part = reference.min(cell.load(simd));
                *bounds = Lanes::store(bounds.load(simd).max(part));
            }
        }
    }
}

/// Sorts the first `count` of `references` by `plane`: what is left of it stays in front, `right` takes the others.
/// References are cut while there is `spare` room for their second parts. Returns how many are left.
pub(super) fn cut(
    primitives: &impl Primitives,
    references: &mut [Reference],
    plane: &Plane,
    mut spare: usize,
    right: &mut Vec<Reference>,
) -> usize {
    let Plane { axis, at, .. } = *plane;
    right.clear();
    let mut left = 0;
    for i in 0..references.len() {
        let reference = references[i];
        let (low, high) = (-reference.0[axis], reference.0[4 + axis]);
        let middle_is_left = 0.5 * low + 0.5 * high < at;
        let mut parts: [Option<Aabb>; 2] = [None; 2];
        if low < at && high > at && spare > 0 {
            parts = primitives
                .split(reference.number() as usize, &reference.bounds(), axis, at)
                .unwrap_or_default();
        }
        let number = reference.number();
        let (on_left, on_right) = match parts {
            [None, None] if middle_is_left => (Some(reference), None),
            [None, None] => (None, Some(reference)),
            [a, b] => (a.map(|a| Lanes::new(number, &a)), b.map(|b| Lanes::new(number, &b))),
        };
        spare -= usize::from(on_left.is_some() && on_right.is_some());
        if let Some(on_left) = on_left {
            references[left] = on_left;
            left += 1;
        }
        right.extend(on_right);
    }
    left
}
