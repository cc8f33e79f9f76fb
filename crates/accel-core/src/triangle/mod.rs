// SPDX-License-Identifier: GPL-3.0-or-later
//! The watertight ray-triangle test, for one ray and in lanes.
//! Space: object.
//! Invariant: a test gives the same bits for one ray and for a lane of a packet, at every level: both do the same
//! roundings in the same order. Tests: `tests/brute_force.rs` (`ask`).

mod lanes;
mod precise;
mod triangle_hit;
mod watertight;

pub use lanes::{TriangleHits, meet_inside, meet_inside_in_lanes, meet_single, pass_edges, relative_to};
pub use triangle_hit::TriangleHit;
pub use watertight::{Sheared, ShearedRay, SingleRay, axes_from, shear};
