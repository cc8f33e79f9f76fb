// SPDX-License-Identifier: GPL-3.0-or-later
//! Ray-triangle tests over prepared triangles; traversals are generic over them.
//! Source: original. Space: object.
//! Invariant: a test gives the same bits for one ray and for a lane of a packet, at every level: both do the same
//! roundings in the same order. Proof: `tests/brute_force.rs` (`ask`).

mod lanes;
mod projected;
mod watertight;

use gnurt_simd::{Simd, f32x8, mask32x8};
pub(crate) use lanes::{LanesMeeting, Sheared, meet_alone, pass_edges};
pub(crate) use projected::ProjectedTriangles;
pub(crate) use watertight::{WatertightTriangles, axes_from};

use crate::Ray;
use crate::packet::{Heading, MeetingPacket, RayPacket};

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

/// Triangles of an object by number, in the form that one test wants.
pub(crate) trait PreparedTriangles {
    /// A ray made ready for this test.
    type Ray: Copy;
    /// Rays in lanes, likewise.
    type Packet<S: Simd>: Copy;

    /// `ray` must be sound and of regular length.
    fn prepare(ray: &Ray) -> Self::Ray;
    /// All active lanes must have this heading.
    fn prepare_packet<S: Simd>(simd: S, rays: &RayPacket<S>, heading: Heading) -> Self::Packet<S>;

    /// Where `ray` meets triangle `number` in `[t_near, t_far]`.
    fn meet(&self, number: u32, ray: &Self::Ray, t_near: f32, t_far: f32) -> Option<Meeting>;
    /// The same in lanes, for those in `active`.
    fn meet_packet<S: Simd>(
        &self,
        simd: S,
        number: u32,
        rays: &Self::Packet<S>,
        active: mask32x8<S>,
        t_near: f32x8<S>,
        t_far: f32x8<S>,
    ) -> MeetingPacket<S>;
}
