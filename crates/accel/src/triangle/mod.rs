// SPDX-License-Identifier: GPL-3.0-or-later
//! Ray-triangle tests over prepared triangles; traversals are generic over them.
//! Source: original. Space: object.
//! Invariant: a test gives the same bits for one ray and for a lane of a packet.

mod watertight;

pub(crate) use watertight::{WatertightRay, WatertightTriangles};

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
