// SPDX-License-Identifier: GPL-3.0-or-later
//! Transforms of the scene's matrices applied to vectors of single precision. Tests: tests/instances.rs.

use glam::{Mat3, Vec3};
use gnurt::scene::Affine;

/// `m` applied to a point.
pub(crate) fn point(m: &Affine, p: Vec3) -> Vec3 {
    Vec3::from(m.point(p.to_array().map(f64::from)).map(|x| x as f32))
}

/// The linear part.
pub(crate) fn linear(m: &Affine) -> Mat3 {
    let [x, y, z, _] = m.columns.map(|column| Vec3::from(column.map(|x| x as f32)));
    Mat3::from_cols(x, y, z)
}
