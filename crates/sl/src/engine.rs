// SPDX-License-Identifier: GPL-3.0-or-later
//! Another engine for `testshade` than the interpreter: code that takes points in batches, made elsewhere.

use crate::exec::{Event, Host, Plan, Points};
use crate::hir::Data;
use crate::types::Type;
use std::sync::Arc;

/// A group in some other form, in the world that it was made for.
pub trait Batch {
    /// Points at once, at most.
    fn lanes(&self) -> usize;

    /// Runs the group for some points, in batches of sixteen or fewer.
    fn run(&mut self, points: &[Points]);

    /// Readies for some points; layers are then run one by one.
    fn begin(&mut self, points: &[Points]);

    /// Runs a layer for all points that have not run it.
    fn layer(&mut self, layer: usize);

    /// The value of a layer's output for one of the points.
    fn output(&self, lane: usize, layer: usize, name: &str) -> Option<(Type, Data)>;

    /// The output, each with the number of its point, in order.
    fn take_events(&mut self) -> Vec<(usize, Event)>;
}

/// Makes the code of a group by the engine of a name, and calls the function with it.
///
/// # Errors
/// Why there is none: the name is unknown, the CPU lacks a feature, or only the interpreter supports the
/// group.
pub type Engine = fn(&str, &Arc<Plan>, &dyn Host, &mut dyn FnMut(&mut dyn Batch)) -> Result<(), String>;
