// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of the points of a batch in memory: one for all of them, or one for each.
//! Tests: `tests/meaning/more.rs`.

use gnurt_sl_lib::Dual;

/// Points of a batch.
pub const LANES: usize = 16;

/// One number of each point.
pub type Row = [f32; LANES];

/// A number and its changes from pixel to pixel, of each point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct DualRow {
    /// The number.
    pub value: Row,
    /// Its change to the right.
    pub dx: Row,
    /// Its change downwards.
    pub dy: Row,
}

impl DualRow {
    /// That of one point.
    #[must_use]
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Dual<f32> {
        Dual::new(self.value[lane], self.dx[lane], self.dy[lane])
    }

    /// Writes that of one point.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, x: Dual<f32>) {
        (self.value[lane], self.dx[lane], self.dy[lane]) = (x.value, x.dx, x.dy);
    }
}

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
            Self::One(cell_bits) => cell_bits,
            Self::Each(row) => row[lane % LANES],
        }
    }
}

/// A number of each point of another. A loop, because compilers make vectors of those, but not always of `map`.
#[inline(always)]
pub(super) fn mapped<T: Copy, U: Copy + Default>(row: &[T; LANES], f: impl Fn(T) -> U) -> [U; LANES] {
    let mut out = [U::default(); LANES];
    out.iter_mut().zip(row).for_each(|(out, &x)| *out = f(x));
    out
}

/// Where the values of a batch are.
pub trait Batch {
    /// The contents of a cell.
    fn get(&self, cell: u32) -> Cells<'_>;
    /// Writes it for the points that `lanes` names.
    fn put(&mut self, cell: u32, lanes: u32, cells_bits: &[u32; LANES]);
}

/// The points of a set of bits, lowest first.
pub fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}
