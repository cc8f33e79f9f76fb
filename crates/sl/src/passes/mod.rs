// SPDX-License-Identifier: GPL-3.0-or-later
//! Analyses and changes of the intermediate form.

mod derivatives;
mod fold;
mod layers;

pub use derivatives::mark_derivatives;
pub use fold::fold;
pub use layers::{fixed, optimise};
