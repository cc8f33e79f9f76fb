// SPDX-License-Identifier: GPL-3.0-or-later
//! Spatial splits: space is divided instead of a set of references; those on a plane are cut in two.
//! Source: [SFD09] sections 4.1 and 4.2. Differs: counts blocks of eight; parts of a reference are never
//! merged again.
//! Space: that of the primitives; areas are scaled as in `bins`.
//! Invariant: the parts of a reference cover its box. Tests: `super::tests::parts_cover_the_whole`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use super::bins::{BINS, Split, scan};
use super::reference::{Lanes, Reference};
use crate::primitives::Primitives;

/// A plane `p[axis] == at`, the border of a slab.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) axis: usize,
    pub(super) at: f32,
    pub(super) cost: f32,
    /// The slab behind it, where slabs begin along its axis, and how many there are to a unit.
    border: i32,
    origin: f32,
    per_unit: f32,
}

/// How a box is cut into slabs along all axes.
#[derive(Clone)]
pub(super) struct Grid {
    /// The slabs themselves: boxes without end along the other axes.
    cells: [[Lanes; BINS]; 3],
    /// Where slabs begin, how many there are to a unit, and signs that make a box's coordinates positive.
    origin: Lanes,
    per_unit: Lanes,
    signs: Lanes,
    width: [f32; 3],
}

/// The contents of the slabs of all axes.
#[derive(Clone)]
pub(super) struct Slabs {
    /// Bounds of the parts of references in each slab, taking boxes for their contents.
    bounds: [[Lanes; BINS]; 3],
    /// References whose first, or last, slab it is.
    begins: [[u32; BINS]; 3],
    ends: [[u32; BINS]; 3],
}

impl Grid {
    /// The slabs of `whole`.
    pub(super) fn new(whole: &Lanes) -> Self {
        let mut grid = Self {
            cells: [[Lanes([f32::INFINITY; 8]); BINS]; 3],
            origin: Lanes::ZERO,
            per_unit: Lanes::ZERO,
            signs: Lanes::ZERO,
            width: [0.0; 3],
        };
        for axis in 0..3 {
            let per_unit = BINS as f32 * 0.9999 / whole.side(axis);
            for lane in [axis, axis + 4] {
                grid.per_unit.0[lane] = if per_unit.is_finite() { per_unit } else { 0.0 };
                grid.origin.0[lane] = -whole.0[axis];
                grid.signs.0[lane] = if lane < 4 { -1.0 } else { 1.0 };
            }
            let width = if per_unit.is_finite() { 1.0 / per_unit } else { 0.0 };
            grid.width[axis] = width;
            for (slab, cell) in grid.cells[axis].iter_mut().enumerate() {
                cell.0[axis] = -(slab as f32 * width - whole.0[axis]);
                cell.0[axis + 4] = (slab + 1) as f32 * width - whole.0[axis];
            }
        }
        grid
    }
}

impl Slabs {
    pub(super) const EMPTY: Self =
        Self { bounds: [[Lanes::EMPTY; BINS]; 3], begins: [[0; BINS]; 3], ends: [[0; BINS]; 3] };

    /// Sorts `references` in.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, references: &[Reference], grid: &Grid) {
        let (origin, per_unit, signs) =
            (grid.origin.load(simd), grid.per_unit.load(simd), grid.signs.load(simd));
        for reference in references {
            self.put(simd, reference.load(simd), &grid.cells, (origin, per_unit, signs));
        }
    }

    #[inline(always)]
    fn put<S: Simd>(
        &mut self,
        simd: S,
        reference: f32x8<S>,
        cells: &[[Lanes; BINS]; 3],
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
            for (bounds, cell) in bounds.iter_mut().zip(&cells[axis]).take(last + 1).skip(first) {
                let part = reference.min(cell.load(simd));
                *bounds = Lanes::store(bounds.load(simd).max(part));
            }
        }
    }

    /// Adds the contents of `other`.
    pub(super) fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            for slab in 0..BINS {
                self.bounds[axis][slab] = self.bounds[axis][slab].union(&other.bounds[axis][slab]);
                self.begins[axis][slab] += other.begins[axis][slab];
                self.ends[axis][slab] += other.ends[axis][slab];
            }
        }
    }

    /// The cheapest plane that leaves `most` references or fewer on both sides together.
    #[inline(always)]
    pub(super) fn best_plane<S: Simd>(&self, simd: S, grid: &Grid, most: usize, scale: f32) -> Option<Plane> {
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        let mut best = Split::NONE;
        for axis in 0..3 {
            let counts = [&self.begins[axis], &self.ends[axis]];
            scan(simd, &self.bounds[axis], counts, axis, most, scale, &mut best);
        }
        let Split { axis, border, cost } = best;
        let (origin, per_unit) = (grid.origin.0[axis], grid.per_unit.0[axis]);
        let at = border as f32 * grid.width[axis] + origin;
        (border > 0).then_some(Plane { axis, at, cost, border: border as i32, origin, per_unit })
    }
}

impl Plane {
    /// The sides of a reference, as counted, so that there is space for all parts.
    #[inline]
    fn sides(&self, reference: &Reference) -> [bool; 2] {
        let slab = |x: f32| ((x - self.origin) * self.per_unit) as i32;
        [slab(-reference.0[self.axis]) < self.border, slab(reference.0[self.axis + 4]) >= self.border]
    }
}

/// Sorts `references` by `plane`: the left ones stay in front, others go to the end of `right`; those on both
/// sides are cut. Returns the number of left ones.
pub(super) fn cut(
    primitives: &dyn Primitives,
    references: &mut [Reference],
    plane: &Plane,
    right: &mut Vec<Reference>,
) -> usize {
    let mut left = 0;
    for i in 0..references.len() {
        let reference = references[i];
        let (on_left, on_right) = match plane.sides(&reference) {
            [true, true] => parts(primitives, &reference, plane),
            [is_left, _] if is_left => (Some(reference), None),
            _ => (None, Some(reference)),
        };
        if let Some(on_left) = on_left {
            references[left] = on_left;
            left += 1;
        }
        right.extend(on_right);
    }
    left
}

/// The parts on either side of a plane; a reference that cannot be cut goes to the side of its centre.
fn parts(
    primitives: &dyn Primitives,
    reference: &Reference,
    plane: &Plane,
) -> (Option<Reference>, Option<Reference>) {
    let Plane { axis, at, .. } = *plane;
    let (low, high) = (-reference.0[axis], reference.0[4 + axis]);
    let number = reference.number();
    let parts = if low < at && high > at {
        primitives.split(number as usize, &reference.bounds(), axis, at).unwrap_or_default()
    } else {
        [None, None]
    };
    match parts {
        [None, None] if 0.5 * low + 0.5 * high < at => (Some(*reference), None),
        [None, None] => (None, Some(*reference)),
        [a, b] => (a.map(|a| Lanes::new(number, &a)), b.map(|b| Lanes::new(number, &b))),
    }
}
