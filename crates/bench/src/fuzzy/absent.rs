// SPDX-License-Identifier: GPL-3.0-or-later
//! The case `fuzzy` of a program without the feature `research`: an error that names it.

use crate::Error;
use crate::dynamic::Options;
use crate::dynamic_row::DynamicRow;
use crate::event::BenchEvent;

/// Measures nothing.
///
/// # Errors
/// [`Error::NoResearch`].
pub fn run(_: [u32; 2], _: &Options, _: &mut dyn FnMut(BenchEvent)) -> Result<Vec<DynamicRow>, Error> {
    Err(Error::NoResearch { structure: "fuzzy kd-tree".into() })
}
