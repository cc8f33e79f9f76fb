// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench dynamic`, case `fuzzy`: a mesh that moves in parts, or in none, under trees that know its poses and others.

#[cfg(not(feature = "research"))]
mod absent;
#[cfg(feature = "research")]
mod measure;

#[cfg(not(feature = "research"))]
pub use absent::run;
#[cfg(feature = "research")]
pub use measure::run;

/// Rows and columns of quads of a tube of 14,400 triangles.
pub const QUADS: [u32; 2] = [120, 60];
