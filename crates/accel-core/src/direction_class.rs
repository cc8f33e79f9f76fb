// SPDX-License-Identifier: GPL-3.0-or-later
//! Classes of ray directions: the signs of the components and the longest axis. Rays of one class go through
//! a tree together.
//! Source: [RSH05] (rays of one octant); the sheared space of [WBW13] depends on the longest axis.
//! Tests: `tile_kernels::tests::direction_classes_split_a_tile`.

use crate::bits::TILE;

/// Where all rays of a tile go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DirectionClass {
    /// Towards smaller coordinates.
    pub backwards: [bool; 3],
    pub longest_axis: usize,
}

impl DirectionClass {
    /// The class with this number of [`TileKernels::codes`](crate::tile_kernels::TileKernels::codes); `None`
    /// for irregular rays.
    #[must_use]
    pub fn of_code(code: usize) -> Option<Self> {
        let has = |bit: usize| code >> bit & 1 == 1;
        (code < DirectionClasses::CODES - 1)
            .then(|| Self { backwards: [has(2), has(1), has(0)], longest_axis: code / 8 })
    }

    /// That of a direction in double precision; -0 goes backwards.
    #[must_use]
    #[inline(always)]
    pub fn of_doubles(dir: &[f64; 3]) -> Self {
        let [x, y, z] = dir.map(f64::abs);
        let longest_axis = if x >= y && x >= z { 0 } else { 2 - usize::from(y >= z) };
        Self { backwards: dir.map(f64::is_sign_negative), longest_axis }
    }

    /// Rows of a node of the wide BVH with its nearer planes; the farther ones are next to them.
    #[inline(always)]
    pub fn rows(&self) -> [usize; 3] {
        let [x, y, z] = self.backwards.map(usize::from);
        [x, 2 + y, 4 + z]
    }
}

/// The direction class of each ray of a tile, as bits.
#[derive(Clone, Copy, Debug, Default)]
pub struct DirectionClasses {
    pub(crate) backwards: [u64; 3],
    pub(crate) along_x: u64,
    pub(crate) along_y: u64,
    /// Of a length that floats can divide by.
    pub regular: u64,
}

impl DirectionClasses {
    /// The number of different classes, and one for rays of irregular length.
    pub const CODES: usize = 25;

    /// The direction class of ray `i`.
    #[inline(always)]
    pub fn of(&self, i: usize) -> DirectionClass {
        let has = |bits: u64| bits >> (i % TILE) & 1 == 1;
        let [x, y, z] = self.backwards;
        let longest_axis = if has(self.along_x) { 0 } else { 2 - usize::from(has(self.along_y)) };
        DirectionClass { backwards: [has(x), has(y), has(z)], longest_axis }
    }

    /// The direction class of ray `i`, and the rays of `among` that share it.
    #[inline(always)]
    pub fn like(&self, i: usize, among: u64) -> (DirectionClass, u64) {
        let has = |bits: u64| bits >> (i % TILE) & 1 == 1;
        let same = |bits: u64| if has(bits) { bits } else { !bits };
        let [x, y, z] = self.backwards;
        let mut bits = among & same(x) & same(y) & same(z) & same(self.along_x);
        if !has(self.along_x) {
            bits &= same(self.along_y);
        }
        (self.of(i), bits)
    }
}
