// SPDX-License-Identifier: GPL-3.0-or-later
//! Events of a running benchmark.

use crate::Row;

/// Reports during a measurement.
#[derive(Debug)]
pub enum BenchEvent<'a> {
    /// A tree is there.
    Built(String),
    /// Answers differ, but by no more than rounding explains.
    Differs(String),
    /// A class is done: its rows, in the order of the jobs.
    Class(&'a [Row]),
}
