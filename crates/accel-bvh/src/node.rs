// SPDX-License-Identifier: GPL-3.0-or-later
//! The node of the wide BVH: the boxes of eight children side by side, so that one ray meets all eight at once.
//! Source: [WBB08]; layout original. Space: that of the primitives.
//!
//! ```text
//!  byte 0     32     64     96     128    160    192        224      256
//!       | x lo | x hi | y lo | y hi | z lo | z hi | children | unused |     one value for each child in every row
//! ```
//!
//! Four cache lines. The two rows of an axis lie next to each other: a ray's nearer row is `2 * axis +
//! backwards`. Children are the bits of floats and there are eight rows, so that `row & 7` needs no further
//! check.
//! Invariant: absent children have the box from +inf to -inf, which no ray hits.
//! Tests: `tests::children_say_what_they_are`.

use gnurt_simd::{Simd, f32x8, prelude::*};

use gnurt_accel_core::Aabb;

pub(crate) use gnurt_accel_core::blocks::WIDTH;

/// A child in one of the eight slots of a node: a node, or a row of leaf blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Child(pub(crate) u32);

/// Eight boxes and their contents.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Node8 {
    /// x lo, x hi, y lo, y hi, z lo, z hi, bits of the children, nothing.
    pub(crate) rows: [[f32; WIDTH]; 8],
}

/// Eight boxes side by side, in any storage.
pub(crate) trait Boxes {
    /// One face of all boxes along axis `k`: `row` is `2 * k` for the lower ones and `2 * k + 1` for the upper ones.
    fn row<S: Simd>(&self, simd: S, k: usize, row: usize) -> f32x8<S>;
    /// The faces of the row that begins with float `at` of a [`Node8`], times `inv`, less `shift`; the compact ones with three
    /// roundings more than these.
    fn meet<S: Simd>(&self, simd: S, k: usize, at: usize, inv: f32x8<S>, shift: f32x8<S>) -> f32x8<S>;
}

impl Boxes for Node8 {
    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, _: usize, row: usize) -> f32x8<S> {
        f32x8::from_slice(simd, &self.rows[row & (WIDTH - 1)])
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, _: usize, at: usize, inv: f32x8<S>, shift: f32x8<S>) -> f32x8<S> {
        // The mask is known to be superfluous where the ray was prepared.
        let at = at & (WIDTH * (WIDTH - 1));
        f32x8::from_slice(simd, &self.rows.as_flattened()[at..at + WIDTH]).mul_sub(inv, shift)
    }
}

impl Child {
    const LEAF: u32 = 1 << 31;
    const COUNT_SHIFT: u32 = 27;
    /// Most blocks of one leaf.
    pub(crate) const MOST_BLOCKS: usize = 15;
    /// The largest number of blocks of a tree, by the remaining bits. Tests have small scenes.
    pub(crate) const MOST_NUMBERS: usize = if cfg!(test) { 1 << 14 } else { 1 << Self::COUNT_SHIFT };
    /// No child.
    pub(crate) const NONE: Self = Self(Self::LEAF);

    /// Node `index`.
    pub(crate) const fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// Leaf blocks `first..first + count`; `count` is 1 to [`MOST_BLOCKS`](Self::MOST_BLOCKS).
    pub(crate) fn leaf(first: usize, count: usize) -> Self {
        assert!((1..=Self::MOST_BLOCKS).contains(&count), "{count} blocks make no leaf");
        assert!(first + count <= Self::MOST_NUMBERS, "block {first} is beyond what a leaf can number");
        Self(Self::LEAF | (count as u32) << Self::COUNT_SHIFT | first as u32)
    }

    #[inline(always)]
    pub(crate) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// The child at `lane`, which is below 8, given the bits of a node's children.
    #[inline(always)]
    pub(crate) fn at(children: &[f32; WIDTH], lane: usize) -> Self {
        Self(children[lane & (WIDTH - 1)].to_bits())
    }

    /// The node's index, where it is no leaf.
    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }

    /// The leaf's blocks, where it is one.
    #[inline(always)]
    pub(crate) fn blocks(self) -> std::ops::Range<usize> {
        let first = (self.0 & ((1 << Self::COUNT_SHIFT) - 1)) as usize;
        first..first + (self.0 >> Self::COUNT_SHIFT & 15) as usize
    }
}

impl Node8 {
    /// A node without children.
    pub(crate) const EMPTY: Self = {
        let (lo, hi) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        let none = [f32::from_bits(Child::NONE.0); WIDTH];
        Self { rows: [lo, hi, lo, hi, lo, hi, none, [0.0; WIDTH]] }
    };

    /// Bits of the children.
    #[inline(always)]
    pub(crate) fn children(&self) -> &[f32; WIDTH] {
        &self.rows[6]
    }

    /// The child at `lane`, which is below 8.
    #[inline(always)]
    pub(crate) fn child(&self, lane: usize) -> Child {
        Child::at(&self.rows[6], lane)
    }

    /// Puts a child at `lane`.
    pub(crate) fn set(&mut self, lane: usize, bounds: &Aabb, child: Child) {
        for k in 0..3 {
            self.rows[2 * k][lane] = bounds.min[k];
            self.rows[2 * k + 1][lane] = bounds.max[k];
        }
        self.rows[6][lane] = f32::from_bits(child.0);
    }

    /// Renumbers children that were counted from the first of some nodes and blocks, which now begin at these
    /// indices.
    pub(crate) fn move_children(&mut self, first_node: usize, first_block: usize) {
        for child in &mut self.rows[6] {
            let old = Child(child.to_bits());
            if old != Child::NONE {
                let by = if old.is_leaf() { first_block } else { first_node };
                *child = f32::from_bits(old.0 + by as u32);
            }
        }
    }

    /// The box around those of all children.
    pub(crate) fn whole(&self) -> Aabb {
        let least = |row: &[f32; WIDTH]| row.iter().fold(f32::INFINITY, |least, &x| least.min(x));
        let most = |row: &[f32; WIDTH]| row.iter().fold(f32::NEG_INFINITY, |most, &x| most.max(x));
        let [x0, x1, y0, y1, z0, z1, ..] = &self.rows;
        Aabb { min: [least(x0), least(y0), least(z0)], max: [most(x1), most(y1), most(z1)] }
    }

    /// The box at `lane`.
    pub(crate) fn bounds(&self, lane: usize) -> Aabb {
        let row = |i: usize| self.rows[i][lane];
        Aabb { min: [row(0), row(2), row(4)], max: [row(1), row(3), row(5)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_say_what_they_are() {
        assert_eq!(size_of::<Node8>(), 256, "four cache lines");
        let leaf = Child::leaf(77, 3);
        assert!(leaf.is_leaf() && leaf.blocks() == (77..80), "{leaf:?} is three blocks");
        let node = Child::node(12);
        assert!(!node.is_leaf() && node.index() == 12, "{node:?} is a node");
        assert!(Child::NONE.is_leaf() && Child::NONE.blocks().is_empty(), "nothing is a leaf without blocks");
        let mut node = Node8::EMPTY;
        let bounds = Aabb { min: [1.0, 2.0, 3.0], max: [4.0, 5.0, 6.0] };
        node.set(5, &bounds, leaf);
        assert_eq!((node.bounds(5), node.child(5)), (bounds, leaf), "what goes in comes out");
        assert!(node.bounds(4).is_empty(), "its neighbour is still empty");
        node.set(2, &bounds, Child::node(9));
        node.move_children(100, 1000);
        let moved = [2, 4, 5].map(|lane| node.child(lane));
        assert_eq!(moved, [Child::node(109), Child::NONE, Child::leaf(1077, 3)], "each by its own");
    }
}
