// SPDX-License-Identifier: GPL-3.0-or-later
//! The builder's reference: a box and the number of its primitive.
//! Space: that of the primitives.
//!
//! ```text
//!  lane   0    1    2      3      4    5    6    7
//!       | -x | -y | -z | number | +x | +y | +z | 0 |     least coordinates negated, then the greatest
//! ```
//!
//! Boxes grow by one maximum of eight lanes. Centres (exactly, twice the centre) occur twice: negated in the
//! lower lanes, so that a maximum finds their range.
//! Invariant: numbers are stored as floats that are neither NaN nor denormal, because unused arithmetic on
//! them would take the slow path of the CPU. Tests: `tests::what_goes_in_comes_out`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use gnurt_accel_core::Aabb;

/// Added to numbers: the bits of a float of full precision, and of which a fraction still has it.
const NORMAL: u32 = 0x2000_0000;

/// Eight floats in half a cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Lanes(pub(super) [f32; 8]);

/// A primitive's box, or that of a part of it.
pub(crate) type Reference = Lanes;

impl Lanes {
    /// The box around nothing, or the range of no middles.
    pub(super) const EMPTY: Self = Self([f32::NEG_INFINITY; 8]);
    pub(crate) const ZERO: Self = Self([0.0; 8]);

    /// `number` is below 2^30.
    #[inline(always)]
    pub(crate) fn new(number: u32, bounds: &Aabb) -> Self {
        let Aabb { min, max } = bounds;
        let number = f32::from_bits(number + NORMAL);
        Self([-min[0], -min[1], -min[2], number, max[0], max[1], max[2], 0.0])
    }

    /// From least coordinates, negated, and greatest ones; the fourth of both are replaced.
    #[inline(always)]
    pub(crate) fn of_corners([x, y, z, _]: [f32; 4], [xx, yy, zz, _]: [f32; 4], number: u32) -> Self {
        Self([x, y, z, f32::from_bits(number + NORMAL), xx, yy, zz, 0.0])
    }

    /// The same box with a number increased by this.
    #[inline(always)]
    pub(crate) fn moved(&self, by: u32) -> Self {
        let mut moved = *self;
        moved.0[3] = f32::from_bits(self.0[3].to_bits() + by);
        moved
    }

    /// The same box under this number.
    #[inline(always)]
    pub(super) fn numbered(&self, number: u32) -> Self {
        let mut numbered = *self;
        numbered.0[3] = f32::from_bits(number + NORMAL);
        numbered
    }

    #[inline(always)]
    pub(crate) fn number(&self) -> u32 {
        self.0[3].to_bits() - NORMAL
    }

    #[inline(always)]
    pub(crate) fn bounds(&self) -> Aabb {
        let [x, y, z, _, xx, yy, zz, _] = self.0;
        Aabb { min: [-x, -y, -z], max: [xx, yy, zz] }
    }

    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.0)
    }

    #[inline(always)]
    pub(super) fn store<S: Simd>(lanes: f32x8<S>) -> Self {
        let mut stored = Self::ZERO;
        lanes.store_array(&mut stored.0);
        stored
    }

    /// Around both.
    pub(super) fn union(&self, other: &Self) -> Self {
        let mut all = *self;
        all.0.iter_mut().zip(other.0).for_each(|(a, b)| *a = a.max(b));
        all
    }

    /// The length of the range along `axis`: of a box, its side.
    #[inline(always)]
    pub(super) fn side(&self, axis: usize) -> f32 {
        self.0[4 + axis] + self.0[axis]
    }

    /// Half the surface of a box, its sides multiplied with `scale`.
    #[inline(always)]
    pub(super) fn half_area(&self, scale: f32) -> f32 {
        let (x, y, z) = (self.side(0) * scale, self.side(1) * scale, self.side(2) * scale);
        x * y + y * z + z * x
    }
}

/// Twice the middle of a reference's box, negated in the lower lanes.
#[inline(always)]
pub(super) fn middle<S: Simd>(simd: S, reference: f32x8<S>) -> f32x8<S> {
    let (low, high) = simd.split_f32x8(reference);
    simd.combine_f32x4(low - high, high - low)
}

/// Consecutive references, the box around them and the range of their middles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) bounds: Lanes,
    pub(super) middles: Lanes,
}

impl Part {
    /// References `start..end` of `all`.
    #[inline(always)]
    pub(super) fn around<S: Simd>(simd: S, all: &[Reference], start: usize, end: usize) -> Self {
        let nothing = Lanes::EMPTY.load(simd);
        let (mut bounds, mut middles) = (nothing, nothing);
        for reference in &all[start..end] {
            let reference = reference.load(simd);
            bounds = bounds.max(reference);
            middles = middles.max(middle(simd, reference));
        }
        Self { start, end, bounds: Lanes::store(bounds), middles: Lanes::store(middles) }
    }

    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.end - self.start
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_simd::Level;

    #[test]
    fn what_goes_in_comes_out() {
        assert_eq!(size_of::<Reference>(), 32, "two to a cache line");
        let bounds = Aabb { min: [-1.0, 0.5, 0.0], max: [1.0, 2.0, 3.0] };
        let last = (1 << 30) - 1;
        let reference = Reference::new(last, &bounds);
        assert_eq!((reference.bounds(), reference.number()), (bounds, last), "box and number");
        assert!(!reference.0[3].is_nan(), "the greatest number is not NaN");
        assert_eq!(
            reference.half_area(2.0),
            4.0 * bounds.half_area() as f32,
            "twice the sides, four times the area"
        );
        for level in Level::available() {
            let all = [reference, Reference::new(0, &Aabb { min: [2.0; 3], max: [4.0; 3] })];
            let part = gnurt_simd::dispatch!(level, simd => Part::around(simd, &all, 0, 2));
            let whole = Aabb { min: [-1.0, 0.5, 0.0], max: [4.0; 3] };
            assert_eq!(part.bounds.bounds(), whole, "around both at {level}");
            let middles = Aabb { min: [0.0, 2.5, 3.0], max: [6.0; 3] };
            assert_eq!(part.middles.bounds(), middles, "twice the middles' range at {level}");
        }
    }
}
