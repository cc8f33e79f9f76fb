// SPDX-License-Identifier: GPL-3.0-or-later
//! Moves the references of one side of a split to the front, in place and without a branch that depends on them.
//! Every reference is written to both ends of the free range, and one end advances. A buffer holds some
//! references of both ends, so that there is always space, and the next to be moved come from the side with
//! less space.
//! Invariant: the order depends only on the references. Tests: `tests::each_side_gets_its_own`,
//! `super::tests`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use super::bins::{Mapping, Split};
use super::reference::{Lanes, Reference, middle};

/// References taken at a time.
const STEP: usize = 32;

/// Memory of a partition, to be used again.
pub(super) struct Buffer {
    ends: [Reference; 2 * STEP],
    rest: [Reference; STEP],
}

impl Buffer {
    pub(super) const EMPTY: Self = Self { ends: [Lanes::ZERO; 2 * STEP], rest: [Lanes::ZERO; STEP] };
}

/// How many went left, and the ranges of the middles on both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parted {
    pub(super) left: usize,
    pub(super) middles: [Lanes; 2],
}

struct Mover<S: Simd> {
    /// The free range is from `left` to before `right`.
    left: usize,
    right: usize,
    axis: usize,
    origin: f32x8<S>,
    scale: f32x8<S>,
    border: f32x8<S>,
    middles: [f32x8<S>; 2],
}

impl<S: Simd> Mover<S> {
    #[inline(always)]
    fn put(&mut self, simd: S, references: &mut [Reference], reference: Reference) {
        let lanes = reference.load(simd);
        let along = |lane: usize| f32x8::splat(simd, reference.0[lane & 7]);
        let position = (along(self.axis + 4) - along(self.axis) - self.origin) * self.scale;
        let is_left = position.simd_lt(self.border);
        let nothing = Lanes::EMPTY.load(simd);
        let middle = middle(simd, lanes);
        self.middles[0] = self.middles[0].max(is_left.select(middle, nothing));
        self.middles[1] = self.middles[1].max(is_left.select(nothing, middle));
        references[self.left] = reference;
        references[self.right - 1] = reference;
        let goes_left = (is_left.to_bitmask() & 1) as usize;
        self.left += goes_left;
        self.right -= 1 - goes_left;
    }
}

/// Parts `references` by `split`.
#[inline(always)]
pub(super) fn partition<S: Simd>(
    simd: S,
    references: &mut [Reference],
    mapping: &Mapping,
    split: &Split,
    buffer: &mut Buffer,
) -> Parted {
    let n = references.len();
    let at = |value: f32| f32x8::splat(simd, value);
    let nothing = Lanes::EMPTY.load(simd);
    let mut mover = Mover {
        left: 0,
        right: n,
        axis: split.axis,
        origin: at(mapping.origin[split.axis]),
        scale: at(mapping.scale[split.axis]),
        border: at(split.border as f32),
        middles: [nothing; 2],
    };
    let held = n.min(2 * STEP);
    let front = held / 2;
    let (mut from, mut to) = (front, n - (held - front));
    buffer.ends[..front].copy_from_slice(&references[..front]);
    buffer.ends[front..held].copy_from_slice(&references[to..]);
    while to - from >= STEP {
        if from - mover.left <= mover.right - to {
            for i in from..from + STEP {
                let reference = references[i];
                mover.put(simd, references, reference);
            }
            from += STEP;
        } else {
            for i in (to - STEP..to).rev() {
                let reference = references[i];
                mover.put(simd, references, reference);
            }
            to -= STEP;
        }
    }
    let rest = to - from;
    buffer.rest[..rest].copy_from_slice(&references[from..to]);
    for &reference in buffer.rest[..rest].iter().chain(&buffer.ends[..held]) {
        mover.put(simd, references, reference);
    }
    Parted { left: mover.left, middles: [Lanes::store(mover.middles[0]), Lanes::store(mover.middles[1])] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel_core::Aabb;
    use gnurt_simd::Level;

    #[test]
    fn each_side_gets_its_own() {
        let mut random = gnurt_testkit::Random::new(1);
        let mapping = Mapping { origin: [0.0; 4], scale: [8.0; 4] };
        for count in [1, 2, 31, 32, 33, 63, 64, 65, 95, 96, 97, 128, 1000] {
            for border in [1, 4, 8, 12, 15] {
                let split = Split { axis: 1, border, cost: 0.0 };
                let corner = |random: &mut gnurt_testkit::Random| [0, 1, 2].map(|_: i32| random.unit());
                let boxes: Vec<Aabb> =
                    (0..count).map(|_| Aabb::around(&[corner(&mut random), corner(&mut random)])).collect();
                let is_left = |number: usize| {
                    let middle = boxes[number].min[1] + boxes[number].max[1];
                    middle * 8.0 < border as f32
                };
                for level in Level::available() {
                    let all = boxes.iter().enumerate();
                    let mut references: Vec<Reference> =
                        all.map(|(number, bounds)| Reference::new(number as u32, bounds)).collect();
                    let mut buffer = Buffer::EMPTY;
                    let Parted { left, middles } = gnurt_simd::dispatch!(level, simd =>
                        partition(simd, &mut references, &mapping, &split, &mut buffer));
                    let mut visited = vec![false; count];
                    let mut ranges = [Aabb::EMPTY; 2];
                    for (position, reference) in references.iter().enumerate() {
                        let number = reference.number() as usize;
                        assert_eq!(reference.bounds(), boxes[number], "{number} keeps its box");
                        assert_eq!(
                            position < left,
                            is_left(number),
                            "{number} is on its side, {count} at {level}"
                        );
                        assert!(!std::mem::replace(&mut visited[number], true), "{number} is there once");
                        let middle = [0, 1, 2].map(|k| reference.0[k + 4] - reference.0[k]);
                        let range = &mut ranges[usize::from(position >= left)];
                        *range = range.union(&Aabb { min: middle, max: middle });
                    }
                    assert_eq!(
                        middles.map(|middles| middles.bounds()),
                        ranges,
                        "ranges of the middles at {level}"
                    );
                }
            }
        }
    }
}
