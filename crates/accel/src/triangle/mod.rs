// SPDX-License-Identifier: GPL-3.0-or-later
//! Ray-triangle tests over prepared triangles; traversals are generic over them.
//! Source: original. Space: object.
//! Invariant: a test gives the same bits for one ray and for a lane of a packet, at every level: both do the same
//! roundings in the same order. Proof: `tests/brute_force.rs` (`ask`).

mod lanes;
mod projected;
mod watertight;

pub(crate) use lanes::{LanesMeeting, Sheared, meet_alone, pass_edges, relative_to};
pub(crate) use projected::ProjectedTriangles;
pub(crate) use watertight::{ShearedRay, axes_from};

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// Ray parameter.
    pub(crate) t: f32,
    /// Weight of the second corner.
    pub(crate) u: f32,
    /// Weight of the third corner.
    pub(crate) v: f32,
}
