// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the primitives of an object are, by their numbers.

/// A place in a leaf block for each number, counted through all blocks of all parts.
#[derive(Clone, Debug)]
pub(super) struct Locations {
    /// [`INVALID_ID`](crate::INVALID_ID) where there is none.
    pub(super) of_number: Vec<u32>,
    /// Where the places of each part start.
    pub(super) starts: Vec<u32>,
}
