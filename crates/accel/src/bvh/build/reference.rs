// SPDX-License-Identifier: GPL-3.0-or-later
//! What the builder moves about: a box and the number of the primitive that it is of.
//! Source: original. Space: that of the primitives.
//! Invariant: 32 bytes, so that two lie in a cache line. Proof: `tests::half_a_cache_line`.

use crate::Aabb;

/// A primitive's box, or that of a part of it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Reference {
    pub(super) min: [f32; 3],
    pub(super) number: u32,
    pub(super) max: [f32; 3],
    unused: u32,
}

impl Reference {
    pub(super) fn new(number: u32, bounds: &Aabb) -> Self {
        Self { min: bounds.min, number, max: bounds.max, unused: 0 }
    }

    pub(super) fn bounds(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }

    /// Twice the box's middle: what sorts references along an axis.
    #[inline(always)]
    pub(super) fn middle(&self, axis: usize) -> f32 {
        self.min[axis] + self.max[axis]
    }
}

/// Consecutive references, and the boxes around them and around their middles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) bounds: Aabb,
    pub(super) middles: Aabb,
}

impl Part {
    /// No reference, at `start`.
    pub(super) fn empty(start: usize) -> Self {
        Self { start, end: start, bounds: Aabb::EMPTY, middles: Aabb::EMPTY }
    }

    /// References `start..end` of `all`.
    pub(super) fn around(all: &[Reference], start: usize, end: usize) -> Self {
        let mut part = Self::empty(start);
        all[start..end].iter().for_each(|reference| part.add(reference));
        part
    }

    /// Takes the next reference in.
    pub(super) fn add(&mut self, reference: &Reference) {
        let middle = [0, 1, 2].map(|k| reference.middle(k));
        self.bounds = self.bounds.union(&reference.bounds());
        self.middles = self.middles.union(&Aabb { min: middle, max: middle });
        self.end += 1;
    }

    pub(super) fn count(&self) -> usize {
        self.end - self.start
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_cache_line() {
        assert_eq!(size_of::<Reference>(), 32, "two to a cache line");
        let bounds = Aabb { min: [0.0; 3], max: [1.0, 2.0, 3.0] };
        let reference = Reference::new(5, &bounds);
        assert_eq!((reference.bounds(), reference.middle(2)), (bounds, 3.0), "what goes in comes out");
    }
}
