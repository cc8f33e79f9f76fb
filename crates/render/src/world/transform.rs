// SPDX-License-Identifier: GPL-3.0-or-later
//! Where an object is: single-precision transforms for shading.
//! An object in objects is reached by several transforms one after the other, as rays are carried. Each of
//! them rounds, so a transform stores the size of intermediate coordinates: it bounds the errors of points
//! ([PJH23] section 6.8).
//! Invariant: the transform has an inverse. Tests: crates/render/tests/nested.rs.

use glam::{DMat3, Mat3, Vec3};
use gnurt_scene::Affine;

/// A transform to the world, or to the object that holds an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    /// Linear part of `world_from_object`.
    pub(crate) linear: Mat3,
    /// Where the object's origin is in the world.
    pub(crate) origin: Vec3,
    /// Transforms normals; unit length is lost, their side stays also if `linear` mirrors.
    pub(crate) normals: Mat3,
    /// Whether `linear` mirrors: triangles have the opposite order of vertices in the world.
    pub(crate) mirrors: bool,
    /// The greatest coordinate that a point of the object has in one of the spaces between its own and the world, in units of the
    /// world; 0 where there are none.
    pub(crate) interpolated: f32,
}

impl Transform {
    /// `None` if the transform flattens or is not finite, in double or single precision.
    pub(crate) fn new(world_from_object: &Affine) -> Option<Self> {
        world_from_object.inverse()?;
        let [x, y, z, origin] = world_from_object.columns;
        let linear = DMat3::from_cols(x.into(), y.into(), z.into());
        // Only directions matter: scaled to the size of 1 so that nothing overflows.
        let normals = {
            let inverse = linear.inverse().transpose();
            let largest = inverse.to_cols_array().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            inverse * (1.0 / largest)
        };
        let index = Self {
            linear: linear.as_mat3(),
            origin: Vec3::from(origin.map(|x| x as f32)),
            normals: normals.as_mat3(),
            mirrors: linear.determinant() < 0.0,
            interpolated: 0.0,
        };
        index.is_finite().then_some(index)
    }

    fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.origin.is_finite() && self.normals.is_finite()
    }

    /// The transform of `inner`, followed by this one; coordinates of its points in the middle space are at
    /// most `reach`.
    pub(crate) fn then(&self, inner: &Self, reach: Vec3) -> Self {
        let normals = self.normals * inner.normals;
        let largest = normals.to_cols_array().iter().fold(f32::MIN_POSITIVE, |m, x| m.max(x.abs()));
        Self {
            linear: self.linear * inner.linear,
            origin: self.point(inner.origin),
            normals: normals * (1.0 / largest),
            mirrors: self.mirrors != inner.mirrors,
            interpolated: self.interpolated.max(absolute(&self.linear).mul_vec3(reach).max_element()),
        }
    }

    /// The greatest coordinates, by axis, of points within a box of the object, intermediate results of the
    /// transform included.
    pub(crate) fn reach(&self, low: Vec3, high: Vec3) -> Vec3 {
        absolute(&self.linear).mul_vec3(low.abs().max(high.abs())) + self.origin.abs()
    }

    /// A point of the object in the world.
    pub(crate) fn point(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.origin
    }
}

fn absolute(m: &Mat3) -> Mat3 {
    Mat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}
