// SPDX-License-Identifier: GPL-3.0-or-later
//! A primitive as trees show it to questions that are decided outside of them. Space: object.

use crate::curve::OwnedCurves;
use crate::user::UserGeometry;

/// One of the kinds that trees are built over.
#[derive(Clone, Copy, Debug)]
pub enum Primitive<'a> {
    /// A triangle, or half of a quad.
    Triangle([[f32; 3]; 3]),
    /// Centre and radius.
    Sphere([f32; 3], f32),
    /// Centre, radius and normal; a disc without one faces each ray.
    Disc([f32; 3], f32, Option<[f32; 3]>),
    /// One of these curves by its index, and the parameters of its piece.
    Curve(&'a OwnedCurves, u32, [f64; 2]),
    /// The caller's own, by its index in its geometry.
    User(&'a dyn UserGeometry, u32),
}
