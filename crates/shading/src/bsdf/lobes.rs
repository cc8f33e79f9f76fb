// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of a layered surface. Source: original.

/// Parts of a layered surface, as a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lobes(pub(super) u8);

impl Lobes {
    pub(super) const COAT: Self = Self(1);
    pub(super) const GLOSS: Self = Self(2);
    pub(super) const BODY: Self = Self(4);
    pub(super) const GLASS: Self = Self(8);
    pub(super) const ALL: Self = Self(15);

    pub(super) fn has(self, part: Self) -> bool {
        self.0 & part.0 != 0
    }

    pub(super) fn without(self, parts: Self) -> Self {
        Self(self.0 & !parts.0)
    }
}
