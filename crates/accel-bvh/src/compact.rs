// SPDX-License-Identifier: GPL-3.0-or-later
//! The node of the wide BVH in less memory: boxes in steps of a grid of the node's own.
//! Source: eight bits to a plane as in \[YKL17\]; layout and rounding original. Space: that of the
//! primitives.
//!
//! ```text
//!  byte 0              12               28               44               60                             64
//!       | origin x y z | x lo 8, x hi 8 | y lo 8, y hi 8 | z lo 8, z hi 8 | exponents of the steps, 0    |
//! ```
//!
//! One cache line. The boxes' contents are stored elsewhere, because trees in several poses share them. A
//! plane is `origin + count * step`: a count of 0 to 255 and a power of two, so that the product is exact. A
//! ray hits it at `count * (step * inv) + (origin * inv - shift)`. That is one more rounding of the plane,
//! which the builder allows for, and up to three of `origin * inv - shift`, which the slack of `slab.rs`
//! allows for.
//! Invariant: a box encloses its original, also after its planes are rounded to floats: the builder advances
//! to the next step until that holds. Steps are at most 2/255 of the node's extent, or the smallest possible:
//! see [`CompactNode::widened`]. Absent children have the upper planes below the lower ones; a ray that hits
//! them nevertheless, from very far away, finds a leaf without blocks.
//! Tests: `tests`, `tests/brute_force.rs`, `tests/watertight.rs`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::node::{Boxes, Child, Node8, WIDTH};
use gnurt_accel_core::Aabb;

/// Eight boxes and their contents.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct CompactNode {
    /// The lowest corner of all boxes.
    pub(crate) origin: [f32; 3],
    /// By axis: lower planes, then upper ones, in steps from the origin.
    pub(crate) counts: [[[u8; WIDTH]; 2]; 3],
    /// Steps are powers of two: the exponents as floats have them, 1 to 254.
    pub(crate) exponents: [u8; 4],
}

/// The children of a node: the bits of eight.
pub(crate) type Children = [f32; WIDTH];

/// Compact nodes, and the contents of their boxes.
#[derive(Clone, Copy)]
pub(crate) struct CompactNodes<'a> {
    pub(crate) boxes: &'a [CompactNode],
    pub(crate) children: &'a [Children],
}

impl CompactNode {
    pub(crate) const EMPTY: Self =
        Self { origin: [0.0; 3], counts: [[[u8::MAX; WIDTH], [0; WIDTH]]; 3], exponents: [1, 1, 1, 0] };

    /// No plane of a compact tree lies farther out, where `greatest` is the greatest coordinate of the
    /// primitives.
    pub(crate) fn widened(greatest: f32) -> f32 {
        (1.0 + 1.0 / 16.0) * greatest + f32::MIN_POSITIVE
    }

    /// Rounds the boxes of `node` outwards.
    pub(crate) fn new(node: &Node8) -> Self {
        let mut compact = Self::EMPTY;
        let all = node.whole();
        if all.is_empty() {
            return compact;
        }
        compact.origin = all.min;
        for k in 0..3 {
            let (origin, step) = (all.min[k], step(all.min[k], all.max[k]));
            compact.exponents[k] = (step.to_bits() >> 23) as u8;
            let count = |plane: f32| (f64::from(plane) - f64::from(origin)) / f64::from(step);
            for lane in (0..WIDTH).filter(|&lane| node.child(lane) != Child::NONE) {
                let (lower, upper) = (node.rows[2 * k][lane], node.rows[2 * k + 1][lane]);
                let mut counts = [count(lower).floor() as u8, count(upper).ceil() as u8];
                // The origin is below all, and the last step above all.
                while plane(origin, step, counts[0]) > lower {
                    counts[0] -= 1;
                }
                while plane(origin, step, counts[1]) < upper {
                    counts[1] += 1;
                }
                [compact.counts[k][0][lane], compact.counts[k][1][lane]] = counts;
            }
        }
        compact
    }

    /// The counts of a row in lanes.
    #[inline(always)]
    fn counts<S: Simd>(&self, simd: S, k: usize, row: usize) -> f32x8<S> {
        // The compiler makes two instructions of it.
        let mut floats = [0.0; WIDTH];
        for (float, &count) in floats.iter_mut().zip(&self.counts[k][row & 1]) {
            *float = f32::from(count);
        }
        f32x8::from_slice(simd, &floats)
    }

    /// A step along axis `k`.
    #[inline(always)]
    pub(crate) fn step(&self, k: usize) -> f32 {
        f32::from_bits(u32::from(self.exponents[k]) << 23)
    }

    /// The node with planes as floats, over these children.
    #[inline(always)]
    pub(crate) fn expand<S: Simd>(&self, simd: S, children: &Children) -> Node8 {
        let mut node = Node8::EMPTY;
        for k in 0..3 {
            self.row(simd, k, 2 * k).store_slice(&mut node.rows[2 * k]);
            self.row(simd, k, 2 * k + 1).store_slice(&mut node.rows[2 * k + 1]);
        }
        node.rows[6] = *children;
        node
    }

    /// The box at `lane`; empty where there is no child.
    pub(crate) fn bounds(&self, lane: usize) -> Aabb {
        if (0..3).any(|k| self.counts[k][0][lane] > self.counts[k][1][lane]) {
            return Aabb::EMPTY;
        }
        let face = |k: usize, i: usize| plane(self.origin[k], self.step(k), self.counts[k][i][lane]);
        Aabb { min: [0, 1, 2].map(|k| face(k, 0)), max: [0, 1, 2].map(|k| face(k, 1)) }
    }
}

impl Boxes for CompactNode {
    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, k: usize, row: usize) -> f32x8<S> {
        let (origin, step) = (f32x8::splat(simd, self.origin[k]), f32x8::splat(simd, self.step(k)));
        self.counts(simd, k, row).mul_add(step, origin)
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, k: usize, at: usize, inv: f32x8<S>, shift: f32x8<S>) -> f32x8<S> {
        let row = at / WIDTH;
        let (origin, step) = (f32x8::splat(simd, self.origin[k]), f32x8::splat(simd, self.step(k)));
        self.counts(simd, k, row).mul_add(step * inv, origin.mul_sub(inv, shift))
    }
}

/// A plane as a float.
fn plane(origin: f32, step: f32, count: u8) -> f32 {
    f32::from(count) * step + origin
}

/// The least power of two that takes at most 255 steps from `low` to `high` or beyond. No less than floats are exact for.
fn step(low: f32, high: f32) -> f32 {
    let least = ((f64::from(high) - f64::from(low)) / 255.0) as f32;
    let mut step = f32::from_bits(least.to_bits() & 0x7f80_0000).max(f32::MIN_POSITIVE);
    while plane(low, step, u8::MAX) < high {
        step *= 2.0;
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel_core::LARGEST_COORDINATE;
    use gnurt_simd::{Level, dispatch};
    use gnurt_testkit::Random;

    /// Boxes of very different sizes and positions, some of them points, in some of the slots.
    fn nodes() -> Vec<Node8> {
        let mut random = Random::new(3);
        let node = |i: usize| {
            let scale = [1.0, 1e-30, 1e-44, 1e10, LARGEST_COORDINATE][i % 5];
            let shift = [0.0, 1.0, -1e6, 1e12][i / 5 % 4];
            let mut node = Node8::EMPTY;
            for lane in 0..=i % WIDTH {
                let from = random.point().map(|x| (scale * x + shift).min(LARGEST_COORDINATE));
                let to = random.point();
                let size = [0.0, 1e-7, 1.0][random.below(3)];
                let to = [0, 1, 2].map(|k| (from[k] + size * scale * to[k].abs()).min(LARGEST_COORDINATE));
                node.set(lane, &Aabb { min: from, max: to }, Child::node(lane + 1));
            }
            node
        };
        (0..2000).map(node).collect()
    }

    #[test]
    fn boxes_hold_those_that_they_are_made_from() {
        assert_eq!(size_of::<CompactNode>(), 64, "a cache line");
        for node in nodes() {
            let compact = CompactNode::new(&node);
            let all = (0..WIDTH).fold(Aabb::EMPTY, |all, lane| all.union(&node.bounds(lane)));
            let size = all.extent();
            for lane in 0..WIDTH {
                let (exact, rounded) = (node.bounds(lane), compact.bounds(lane));
                if exact.is_empty() {
                    assert!(rounded.is_empty(), "nothing stays nothing");
                    continue;
                }
                assert_eq!(rounded.union(&exact), rounded, "{rounded:?} holds {exact:?}");
                assert!(
                    rounded.greatest() <= CompactNode::widened(all.greatest()),
                    "{rounded:?} lies beyond all of {all:?}"
                );
                for k in 0..3 {
                    // A step, plus the rounding error of coordinates; the smallest step of all for an extent
                    // of zero.
                    let reach = f64::from(all.greatest());
                    let most = size[k] / 127.0 + 1e-6 * reach + f64::from(f32::MIN_POSITIVE) * 2.0;
                    let off = [exact.min[k] - rounded.min[k], rounded.max[k] - exact.max[k]].map(f64::from);
                    assert!(off.iter().all(|&off| off <= most), "{off:?} of {size:?} along {k}");
                }
            }
        }
    }

    #[test]
    fn every_level_sees_the_same_planes() {
        for node in nodes() {
            let compact = CompactNode::new(&node);
            for level in Level::available() {
                let expanded = dispatch!(level, simd => compact.expand(simd, node.children()));
                for lane in (0..WIDTH).filter(|&lane| node.child(lane) != Child::NONE) {
                    assert_eq!(expanded.bounds(lane), compact.bounds(lane), "place {lane} at {level}");
                    assert_eq!(expanded.child(lane), node.child(lane), "place {lane} at {level}");
                }
            }
        }
    }
}
