// SPDX-License-Identifier: GPL-3.0-or-later
//! Light path expressions: which part of a picture's light goes to which layer.
//! Source: see each file.

mod automaton;
mod classes;
mod events;
mod layer;
mod ledger;
mod light_paths;
mod sums;
mod syntax;

pub(crate) use events::{Lobe, Scatter};
pub(crate) use layer::Part;
pub(crate) use layer::check;
pub use layer::{GROUP_PREFIX, LightLayer, OUTPUT_PREFIX, UNGROUPED};
pub(crate) use ledger::Ledger;
pub(crate) use light_paths::LightPaths;
pub use light_paths::unknown_labels;
pub(crate) use sums::LightSums;
pub use syntax::ExpressionError;
