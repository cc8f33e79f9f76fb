// SPDX-License-Identifier: GPL-3.0-or-later
//! Oracles, scene makers and assertions for tests; never published. Depends on nothing: plain arrays go in and out.
#![forbid(unsafe_code)]

pub mod closed;
pub mod lattice;
pub mod oracle;
pub mod random;
pub mod rays;
pub mod soup;
pub mod voxels;

pub use oracle::{OracleHit, OracleInstance};
pub use random::Random;
pub use soup::Soup;
pub use voxels::{Voxels, Where};
