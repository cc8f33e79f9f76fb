// SPDX-License-Identifier: GPL-3.0-or-later
//! Geometric normals of triangles, one or sixteen at a time, in double precision: squares of tiny or huge edges leave the range of
//! floats.
//! Space: corners in the object, normals in the world. Invariant: both give the same bits.
//! Tests: crates/render/tests/lanes.rs.

use glam::{DMat3, DVec3, Vec3};
use gnurt_shading::real::{Real, Vector};
use gnurt_simd::{Simd, SimdFloat, f32x16, prelude::*};

/// A matrix for each point, by columns.
#[derive(Clone, Copy)]
pub(super) struct Columns<R>(pub(super) [Vector<R>; 3]);

impl<R: Real> Columns<R> {
    #[inline(always)]
    pub(super) fn times(&self, v: Vector<R>) -> Vector<R> {
        let [x, y, z] = self.0;
        x * v.x + y * v.y + z * v.z
    }
}

/// Numbers that have doubles.
pub(super) trait Precise: Real {
    /// Unit, in the world, on the side from which the mesh's triangles wind counter-clockwise.
    fn geometric_normals(corners: &[Vector<Self>; 3], normals: &Columns<Self>) -> Vector<Self>;
}

impl Precise for f32 {
    fn geometric_normals(corners: &[Vector<f32>; 3], normals: &Columns<f32>) -> Vector<f32> {
        let wide = |v: Vector<f32>| Vec3::from(v).as_dvec3();
        let [a, b, c] = corners.map(wide);
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
        let [x, y, z] = normals.0.map(wide);
        (DMat3::from_cols(x, y, z) * normal).normalize_or(DVec3::Z).as_vec3().into()
    }
}

impl<S: Simd> Precise for f32x16<S> {
    #[inline(always)]
    fn geometric_normals(corners: &[Vector<Self>; 3], normals: &Columns<Self>) -> Vector<Self> {
        let simd = corners[0].x.token();
        // Doubles are half as many: lower lanes, then upper ones.
        let [a, b, c] = [wide(&corners[0]), wide(&corners[1]), wide(&corners[2])];
        let [x, y, z] = [wide(&normals.0[0]), wide(&normals.0[1]), wide(&normals.0[2])];
        let [x0, y0, z0] = normal64(simd, [a.0, b.0, c.0], [x.0, y.0, z.0]);
        let [x1, y1, z1] = normal64(simd, [a.1, b.1, c.1], [x.1, y.1, z.1]);
        Vector::new(x0.narrow(x1), y0.narrow(y1), z0.narrow(z1))
    }
}

/// Eight doubles.
type Doubles<S> = <f32x16<S> as SimdWiden<S>>::Widened;

#[inline(always)]
fn wide<S: Simd>(v: &Vector<f32x16<S>>) -> ([Doubles<S>; 3], [Doubles<S>; 3]) {
    let ((x0, x1), (y0, y1), (z0, z1)) = (v.x.widen(), v.y.widen(), v.z.widen());
    ([x0, y0, z0], [x1, y1, z1])
}

#[inline(always)]
fn normal64<S: Simd, D: SimdFloat<S, Element = f64>>(
    simd: S,
    [a, b, c]: [[D; 3]; 3],
    [x, y, z]: [[D; 3]; 3],
) -> [D; 3] {
    let (p, q) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
    let cross = [p[1] * q[2] - q[1] * p[2], p[2] * q[0] - q[2] * p[0], p[0] * q[1] - q[0] * p[1]];
    let n = unit(simd, cross);
    let in_world = [
        x[0] * n[0] + y[0] * n[1] + z[0] * n[2],
        x[1] * n[0] + y[1] * n[1] + z[1] * n[2],
        x[2] * n[0] + y[2] * n[1] + z[2] * n[2],
    ];
    unit(simd, in_world)
}

/// `DVec3::normalize_or(Z)`.
#[inline(always)]
fn unit<S: Simd, D: SimdFloat<S, Element = f64>>(simd: S, v: [D; 3]) -> [D; 3] {
    let (zero, one) = (D::splat(simd, 0.0), D::splat(simd, 1.0));
    let scale = one / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let good = scale.is_finite() & scale.simd_gt(zero);
    [good.select(v[0] * scale, zero), good.select(v[1] * scale, zero), good.select(v[2] * scale, one)]
}
