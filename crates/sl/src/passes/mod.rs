// SPDX-License-Identifier: GPL-3.0-or-later
//! What is found out about, and changed in, the intermediate form.

mod derivatives;
mod fold;

pub use derivatives::mark_derivatives;
pub use fold::fold;
