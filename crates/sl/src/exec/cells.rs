// SPDX-License-Identifier: GPL-3.0-or-later
//! A number of each point of a batch, as it lies in memory: one for all of them, or one for each.
//! Source: original. Proof: `tests/meaning/more.rs`.

/// Points of a batch.
pub const LANES: usize = 16;

/// A number of each point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells<'a> {
    /// The same for all.
    One(u32),
    /// One for each.
    Each(&'a [u32; LANES]),
}

impl Cells<'_> {
    /// That of a point.
    #[inline]
    #[must_use]
    pub fn at(self, lane: usize) -> u32 {
        match self {
            Self::One(word) => word,
            Self::Each(row) => row[lane % LANES],
        }
    }
}

/// The points of a set of bits, lowest first.
pub fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}
