// SPDX-License-Identifier: GPL-3.0-or-later
//! The block of eight pieces of curves: capsules in ten bits for each coordinate.
//! Source: [YKL17] for counts from an origin, there of boxes. Space: object.
//! Invariant: a capsule holds that of its piece, and with it all hits. In lanes it is larger by twice the slack of boxes
//! (`slab.rs`): the rounding of both its ends, seen along the ray, is below half of that. Tests: `tests`.

use gnurt_accel_core::curve::{CurvePiece, Passing, RayFrame, RoughRay, Segment};
use gnurt_accel_core::float::{least, most};
use gnurt_simd::{Simd, f32x8, prefetch, prelude::*};

use crate::blocked::Shared;
use crate::node::WIDTH;

/// Eight pieces: capsules around them, and their places on the curves. Two cache lines: ends are counted in steps from an
/// origin of the block, and radii allow for what each end moves by that.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct CurveBlock {
    /// By end and lane: three counts of ten bits; the two above them in both ends are the place on the curve, [`place_of`].
    pub(super) ends: [[u32; WIDTH]; 2],
    /// Numbers in the object.
    pub(super) numbers: [u32; WIDTH],
    /// In steps of their own; 0 in empty lanes.
    pub(super) radius: [u8; WIDTH],
    pub(super) origin: [f32; 3],
    /// By axis, and that of radii: the upper halves of floats.
    pub(super) steps: [u16; 4],
}

/// Most steps along an axis.
pub(super) const MOST_STEPS: f64 = 1023.0;

/// The upper half of the least float with no lower half that is not below `x`.
fn half_above(x: f64) -> u16 {
    let bits = (x as f32).next_up().to_bits();
    ((bits + 0xffff) >> 16) as u16
}

/// The place of piece `index` of `count`, a power of two up to 8, in one byte: that of a node in a heap.
fn place_of(index: u8, count: u8) -> u8 {
    count + index
}

/// Index and count of a place.
pub(super) fn piece_at(place: u8) -> [u8; 2] {
    let count = 1 << place.max(1).ilog2();
    [place.max(1) - count, count]
}

/// The parameters between which a piece lies.
pub(super) fn part(place: u8) -> [f64; 2] {
    let [index, count] = piece_at(place);
    [f64::from(index) / f64::from(count), f64::from(index + 1) / f64::from(count)]
}

/// A ray, and it in lanes.
#[derive(Clone, Copy)]
pub struct ReadyRay<S: Simd> {
    pub(super) frame: RayFrame,
    pub(super) rough: RoughRay<S>,
    pub(super) slack: f32x8<S>,
}

#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, [x, y, z]: [f64; 3]) -> [f32x8<S>; 3] {
    [f32x8::splat(simd, x as f32), f32x8::splat(simd, y as f32), f32x8::splat(simd, z as f32)]
}

/// Counts along axis `k` as floats.
#[inline(always)]
fn counts<S: Simd>(simd: S, words: &[u32; WIDTH], k: u32) -> f32x8<S> {
    let mut floats = [0.0; WIDTH];
    for (float, &word) in floats.iter_mut().zip(words) {
        *float = (word >> (10 * k) & 1023) as i32 as f32;
    }
    f32x8::from_slice(simd, &floats)
}

/// Bytes as floats.
#[inline(always)]
fn bytes<S: Simd>(simd: S, bytes: &[u8; WIDTH]) -> f32x8<S> {
    let mut floats = [0.0; WIDTH];
    for (float, &byte) in floats.iter_mut().zip(bytes) {
        *float = f32::from(byte);
    }
    f32x8::from_slice(simd, &floats)
}

impl CurveBlock {
    /// A lane's curve, and its piece.
    pub(super) fn segment(&self, lane: usize, shared: &Shared<Self>) -> Option<(Segment, [f64; 2])> {
        let (curves, prim_id) = shared.get(self.numbers[lane])?;
        Some((curves.segment(prim_id)?, part(self.place(lane))))
    }

    /// Ends from the origin of a ray. A function: operations in a closure that is not inlined would all be calls.
    #[inline(always)]
    fn from<S: Simd>(&self, simd: S, ray: &ReadyRay<S>, end: usize) -> [f32x8<S>; 3] {
        let mut from = ray.rough.org;
        for (k, row) in from.iter_mut().enumerate() {
            let origin = f32x8::splat(simd, self.origin[k]) - *row;
            let step = f32x8::splat(simd, self.step(k));
            *row = counts(simd, &self.ends[end], k as u32).mul_add(step, origin);
        }
        from
    }

    /// Lanes whose capsules the ray may meet within `[near, far]`, as bits, and the least lengths along the ray.
    #[inline(always)]
    pub(super) fn capsules<S: Simd>(
        &self,
        simd: S,
        ray: &ReadyRay<S>,
        [near, far]: [f32; 2],
    ) -> (u32, f32x8<S>) {
        let [from_a, from_b] = [self.from(simd, ray, 0), self.from(simd, ray, 1)];
        let a = [ray.rough.by(from_a, 0), ray.rough.by(from_a, 1)];
        let b = [ray.rough.by(from_b, 0), ray.rough.by(from_b, 1)];
        let counts = bytes(simd, &self.radius);
        let radius = counts.mul_add(f32x8::splat(simd, self.step(3)), ray.slack);
        // Seen along the ray: it passes beside the chord, before its start or behind its end. Most rays pass all eight.
        let is_there = counts.simd_gt(f32x8::splat(simd, 0.0));
        let is_near = Passing::new(a, b).is_near(radius) & is_there;
        if is_near.to_bitmask() == 0 {
            return (0, radius);
        }
        let (a, b) = (ray.rough.by(from_a, 2), ray.rough.by(from_b, 2));
        let length = ray.rough.length;
        let start = a.min(b) - radius;
        let is_before = start.simd_le(f32x8::splat(simd, far * length));
        let is_behind = (a.max(b) + radius).simd_ge(f32x8::splat(simd, near * length));
        ((is_near & is_before & is_behind).to_bitmask() as u32, start)
    }

    /// Requests the vertices of a lane's curve, which are about to be read.
    #[inline(always)]
    pub(super) fn prefetch(&self, lane: usize, shared: &Shared<Self>) {
        if let Some((curves, prim_id)) = shared.get(self.numbers[lane]) {
            // Not from the index: that may have to come from memory, too.
            prefetch(&curves.indices, prim_id as usize);
            let known = curves.starts.get(prim_id);
            if let Some(first) = known.or_else(|| curves.indices.get(prim_id as usize).copied()) {
                prefetch(&curves.vertices, first as usize);
                prefetch(&curves.vertices, first as usize + 3);
            }
        }
    }
}

impl CurveBlock {
    /// A step along an axis, or that of radii.
    #[inline(always)]
    pub(super) fn step(&self, k: usize) -> f32 {
        f32::from_bits(u32::from(self.steps[k]) << 16)
    }

    /// A lane's place on its curve.
    #[inline(always)]
    pub(super) fn place(&self, lane: usize) -> u8 {
        (self.ends[0][lane] >> 30 << 2 | self.ends[1][lane] >> 30) as u8
    }

    /// Makes a frame around the pieces, and counts their ends and radii in it.
    pub(super) fn count_ends(&mut self, items: &[Option<&CurvePiece>; WIDTH]) {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for end in items.iter().flatten().flat_map(|piece| &piece.ends) {
            for k in 0..3 {
                (low[k], high[k]) = (least(low[k], end[k]), most(high[k], end[k]));
            }
        }
        self.origin = low;
        for k in 0..3 {
            self.steps[k] = half_above((f64::from(high[k]) - f64::from(low[k])) / MOST_STEPS);
        }
        let steps = [0, 1, 2].map(|k| f64::from(self.step(k)));
        let (origin, over) = (low.map(f64::from), steps.map(|step| 1.0 / step));
        let mut radii = [0.0; WIDTH];
        for (lane, piece) in items.iter().enumerate() {
            let Some(piece) = piece else { continue };
            // Distances that ends move count for the radius.
            let mut farthest = 0.0f64;
            for (words, end) in self.ends.iter_mut().zip(&piece.ends) {
                let (mut word, mut off) = (0, 0.0);
                for k in 0..3 {
                    let x = f64::from(end[k]) - origin[k];
                    let count = (x * over[k] + 0.5).min(MOST_STEPS) as u32;
                    let moved = steps[k] * f64::from(count) - x;
                    off += moved * moved;
                    word |= count << (10 * k);
                }
                words[lane] = word;
                farthest = farthest.max(off);
            }
            radii[lane] = (f64::from(piece.radius) + farthest.sqrt()) * (1.0 + 1e-6);
        }
        let widest = radii.iter().fold(0.0, |all, &radius| if radius > all { radius } else { all });
        self.steps[3] = half_above(widest / 255.0);
        let over = 1.0 / f64::from(self.step(3));
        // Up to the next whole number, and by more than the product rounds.
        self.radius = radii.map(|radius| (radius * over + 1.0 - 1e-9).min(255.0) as u8);
        for (radius, piece) in self.radius.iter_mut().zip(items) {
            *radius = if piece.is_some() { (*radius).max(1) } else { 0 };
        }
    }

    /// Adds the number and the place of a piece whose ends are counted.
    pub(super) fn put(&mut self, lane: usize, piece: &CurvePiece, number: u32) {
        let place = u32::from(place_of(piece.index, piece.count));
        self.ends[0][lane] |= place >> 2 << 30;
        self.ends[1][lane] |= place << 30;
        self.numbers[lane] = number;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocked::BlockKind;
    use gnurt_accel_core::Aabb;
    use gnurt_testkit::Random;

    #[test]
    fn capsules_hold_those_of_their_pieces() {
        assert_eq!(size_of::<CurveBlock>(), 128, "two cache lines");
        let mut random = Random::new(5);
        for round in 0..2000 {
            let scale = [1.0, 1e-6, 1e-30, 1e12, 1e17][round % 5];
            let shift = [0.0, 3.0, -40.0][round / 5 % 3];
            let mut end = || random.point().map(|x| scale * (x + shift));
            let pieces: Vec<CurvePiece> = (0..=round % WIDTH)
                .map(|i| {
                    let ends = [end(), end()];
                    let radius = scale * [0.0, 1e-4, 0.3][i % 3];
                    CurvePiece { bounds: Aabb::around(&ends), ends, radius, index: (i % 4) as u8, count: 4 }
                })
                .collect();
            let mut block = CurveBlock::empty();
            let mut items = [None; WIDTH];
            items.iter_mut().zip(&pieces).for_each(|(item, piece)| *item = Some(piece));
            block.frame(&items);
            for (lane, piece) in pieces.iter().enumerate() {
                block.set(lane, piece, lane as u32);
                assert_eq!(piece_at(block.place(lane)), [piece.index, piece.count], "its place");
                let radius = f64::from(block.radius[lane]) * f64::from(block.step(3));
                for (words, end) in block.ends.iter().zip(piece.ends) {
                    let off = [0, 1, 2].map(|k: usize| {
                        let count = f64::from(words[lane] >> (10 * k) & 1023);
                        let x = f64::from(block.origin[k]) + count * f64::from(block.step(k));
                        x - f64::from(end[k])
                    });
                    let off = off.iter().map(|x| x * x).sum::<f64>().sqrt();
                    let needed = f64::from(piece.radius) + off;
                    assert!(
                        radius >= needed && block.radius[lane] > 0,
                        "{radius} is below {needed} of {piece:?}"
                    );
                }
            }
            let empty = (pieces.len()..WIDTH).all(|lane| block.radius[lane] == 0);
            assert!(empty, "nothing meets the others: {block:?}");
        }
    }
}
