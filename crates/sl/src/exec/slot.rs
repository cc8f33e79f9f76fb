// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a symbol's value is.
//! Source: original.

use crate::types::Type;

/// A stretch of the memory: the value, then its two derivatives if it has them, each as long as the value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    /// The first cell.
    pub(super) at: u32,
    /// Cells of the value.
    pub(super) size: u32,
    /// Cells of one element.
    pub(super) one: u32,
    /// Its type, arrays with their length.
    pub(super) ty: Type,
    /// Whether derivatives follow.
    pub(super) derivs: bool,
}

impl Slot {
    pub(super) fn new(at: usize, ty: Type, derivs: bool) -> Self {
        Self { at: at as u32, size: ty.size() as u32, one: ty.base.components() as u32, ty, derivs }
    }

    /// Cells with derivatives.
    pub(super) const fn cells(&self) -> usize {
        self.size as usize * if self.derivs { 3 } else { 1 }
    }
}
