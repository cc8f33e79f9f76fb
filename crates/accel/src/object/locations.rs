// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the primitives of an object are, by their numbers.

/// A leaf block's slot for each number, counted through all blocks of all parts.
#[derive(Clone, Debug)]
pub(super) struct Locations {
    /// [`INVALID_ID`](crate::INVALID_ID) where there is none.
    pub(super) of_number: Vec<u32>,
    /// The start of each part.
    pub(super) starts: Vec<u32>,
}
