// SPDX-License-Identifier: GPL-3.0-or-later
//! A primitive as trees show it to questions that are decided outside of them. Space: object.

use crate::user::UserGeometry;

/// One of the kinds that trees are built over.
#[derive(Clone, Copy, Debug)]
pub enum Primitive<'a> {
    /// A triangle, or half of a quad.
    Triangle([[f32; 3]; 3]),
    /// Centre and radius.
    Sphere([f32; 3], f32),
    /// The caller's own, by its index in its geometry.
    User(&'a dyn UserGeometry, u32),
}
