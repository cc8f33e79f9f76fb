// SPDX-License-Identifier: GPL-3.0-or-later
//! Mailboxes: the last triangles that rays were tested against. If triangles are in several cells, a second
//! test is redundant.
//! Source: [AW87]. Invariant: recorded triangles were tested; records may be lost. Tests:
//! `tests/brute_force.rs`, `tests/grids.rs` of `gnurt-accel`.

use gnurt_accel_core::INVALID_ID;

/// The last triangles, each in the slot of its number; `N` is a power of two.
pub(crate) struct Mailbox<const N: usize> {
    numbers: [u32; N],
}

impl<const N: usize> Mailbox<N> {
    pub(crate) const EMPTY: Self = Self { numbers: [INVALID_ID; N] };

    /// Whether a triangle is known; from now on it is.
    #[inline(always)]
    pub(crate) fn has(&mut self, number: u32) -> bool {
        let position = &mut self.numbers[number as usize & (N - 1)];
        std::mem::replace(position, number) == number
    }
}
