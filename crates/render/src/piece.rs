// SPDX-License-Identifier: GPL-3.0-or-later
//! The rendered part of a picture. Packing of its pixels: `packing`.

use std::fmt;

/// One of the parts of a divided picture: every n-th tile. See [`pack_piece`](crate::pack_piece).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Piece {
    /// From 0 on.
    pub index: u32,
    /// How many there are.
    pub count: u32,
}

/// `2/8` is the second of eight.
impl fmt::Display for Piece {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", u64::from(self.index) + 1, self.count)
    }
}

/// Bands of rows begin at multiples of this: the grid of tiles of all integrators.
pub const BAND_UNIT: u32 = 32;
