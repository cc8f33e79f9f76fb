// SPDX-License-Identifier: GPL-3.0-or-later
#![doc = include_str!("../CLOSURES.md")]
//! Tests: `tests/closures.rs`.

pub use gnurt_sl::exec::{ClosureDecl, ClosureParam, standard_closures};
