// SPDX-License-Identifier: GPL-3.0-or-later
//! The closures of OSL, MaterialX and Blender: parameters, meanings, units; closures of one's own.
//! Tests: `tests/closures.rs`.
//!
#![doc = include_str!("../CLOSURES.md")]
//!
//! [`Shaded::lobes`]: crate::Shaded::lobes
//! [`Shaded::events`]: crate::Shaded::events
//! [`Lobe`]: crate::Lobe
//! [`Lobe::lobes`]: crate::Lobe::lobes
//! [`Argument::Triple`]: crate::Argument::Triple
//! [`Host::closures`]: crate::Host::closures

pub use gnurt_sl::exec::{ClosureDecl, ClosureParam, standard_closures};
