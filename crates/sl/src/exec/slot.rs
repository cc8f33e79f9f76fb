// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a symbol's value is.

use crate::types::Type;

/// A stretch of the memory: the value, then its two derivatives if it has them, each as long as the value.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// The first cell.
    pub at: u32,
    /// Cells of the value.
    pub size: u32,
    /// Cells of one element.
    pub one: u32,
    /// Its type, arrays with their length.
    pub ty: Type,
    /// Whether derivatives follow.
    pub derivs: bool,
}

impl Slot {
    pub(super) fn new(at: usize, ty: Type, derivs: bool) -> Self {
        Self { at: at as u32, size: ty.size() as u32, one: ty.base.components() as u32, ty, derivs }
    }

    /// Cells with derivatives.
    #[must_use]
    pub const fn cells(&self) -> usize {
        self.size as usize * if self.derivs { 3 } else { 1 }
    }
}

/// A value that is stored of each point.
#[derive(Clone, Debug, PartialEq)]
pub struct RetainedOutput {
    /// In the requested form: `name` or `layer.name`, or a global's name.
    pub name: String,
    /// Its type, made of floats or ints.
    pub ty: Type,
    /// Its first row in [`Results::rows`](super::Results::rows); it has a row for each number of the type.
    pub row: usize,
}
