// SPDX-License-Identifier: GPL-3.0-or-later
//! Corners of eight triangles at once: out of a mesh's arrays, into lanes. Space: object.
//! Tests: `tests/refit.rs` and `tests/brute_force.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::surfaces::{Mesh, Surfaces};
use gnurt_accel_core::{Aabb, LARGEST_COORDINATE, Triangles};
use gnurt_simd::{Simd, f32x4, f32x8, mask32x8, prefetch, prelude::*};

use crate::node::WIDTH;
use crate::pools::transposed;

/// Eight triangles: by corner, then one after the other. The fourth lanes hold anything.
#[derive(Clone, Copy)]
pub(crate) struct Eight<S: Simd>(pub(crate) [[f32x4<S>; WIDTH]; 3]);

/// By corner, then by axis.
pub(crate) type Rows<S> = [[f32x8<S>; 3]; 3];

impl<S: Simd> Eight<S> {
    /// Those of these numbers. `mesh` is the mesh of the last ones; indices of `ahead` are prefetched.
    /// Indices may be out of range: such a corner is NaN.
    #[inline(always)]
    pub(crate) fn gather<'a>(
        simd: S,
        surfaces: &Surfaces<'a>,
        mesh: &mut Mesh<'a>,
        numbers: &[u32; WIDTH],
        ahead: Option<&[u32; WIDTH]>,
    ) -> Self {
        let mut corners = [[f32x4::splat(simd, 0.0); WIDTH]; 3];
        if !mesh.holds(numbers) {
            *mesh = surfaces.mesh(numbers[0]);
        }
        match mesh.as_triangles().filter(|_| mesh.holds(numbers)) {
            Some((start, Triangles { positions, indices })) => {
                for number in ahead.into_iter().flatten() {
                    prefetch(indices, number.wrapping_sub(start) as usize);
                }
                let positions = positions.as_flattened();
                for (lane, &number) in numbers.iter().enumerate() {
                    let [a, b, c] = indices[(number - start) as usize];
                    corners[0][lane] = vertex(simd, positions, a);
                    corners[1][lane] = vertex(simd, positions, b);
                    corners[2][lane] = vertex(simd, positions, c);
                }
            }
            None => {
                for (lane, &number) in numbers.iter().enumerate() {
                    let (positions, vertices) = surfaces.indices(number);
                    for (corner, at) in corners.iter_mut().zip(vertices) {
                        corner[lane] = vertex(simd, positions.as_flattened(), at);
                    }
                }
            }
        }
        Self(corners)
    }

    /// The box around all, where all are numbers.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> Aabb {
        let mut low = self.0[0][0];
        let mut high = low;
        for &corner in self.0.as_flattened() {
            low = low.min(corner);
            high = high.max(corner);
        }
        let (low, high) = (low.to_array(), high.to_array());
        Aabb { min: [low[0], low[1], low[2]], max: [high[0], high[1], high[2]] }
    }

    /// As blocks hold them.
    #[inline(always)]
    pub(crate) fn rows(&self) -> Rows<S> {
        [by_axis(&self.0[0]), by_axis(&self.0[1]), by_axis(&self.0[2])]
    }
}

/// One corner of all triangles.
#[inline(always)]
fn by_axis<S: Simd>(&[a, b, c, d, e, f, g, h]: &[f32x4<S>; WIDTH]) -> [f32x8<S>; 3] {
    let ([x, y, z], [xx, yy, zz]) = (transposed([a, b, c, d]), transposed([e, f, g, h]));
    [x.combine(xx), y.combine(yy), z.combine(zz)]
}

/// Puts corners into a block.
#[inline(always)]
pub(crate) fn store<S: Simd>(rows: &Rows<S>, block: &mut TriangleBlock) {
    for (to, row) in block.corners.as_flattened_mut().iter_mut().zip(rows.as_flattened()) {
        row.store_slice(to);
    }
}

/// A vertex and anything behind it; no numbers where there is none.
#[inline(always)]
fn vertex<S: Simd>(simd: S, positions: &[f32], vertex: u32) -> f32x4<S> {
    // Where an address has 32 bits, three times an index may have more.
    let at = usize::try_from(3 * u64::from(vertex)).unwrap_or(usize::MAX - 4);
    match positions.get(at..at + 4) {
        Some(vertex) => f32x4::from_slice(simd, vertex),
        None => f32x4::load_array(simd, last_vertex(positions, at)),
    }
}

#[cold]
#[inline(never)]
fn last_vertex(positions: &[f32], at: usize) -> [f32; 4] {
    match positions.get(at..at + 3) {
        Some(&[x, y, z]) => [x, y, z, 0.0],
        _ => [f32::NAN; 4],
    }
}

/// Whether all triangles, in this box, can surely be traced: they span an area by far more than floats are rounded by.
/// Otherwise exact tests are needed.
#[inline(always)]
pub(crate) fn are_certain<S: Simd>(simd: S, [a, b, c]: &Rows<S>, bounds: &Aabb) -> bool {
    let (least, share) = (f32x8::splat(simd, 1e-30), f32x8::splat(simd, 1.0 / (1 << 20) as f32));
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    // A NaN in one coordinate spoils this.
    let all = u[0] + u[1] + u[2] + v[0] + v[1] + v[2];
    let products = [[u[0] * v[1], u[1] * v[0]], [u[1] * v[2], u[2] * v[1]], [u[2] * v[0], u[0] * v[2]]];
    let mut spans = mask32x8::splat(simd, false);
    for [p, q] in products {
        spans |= (p - q).abs().simd_gt((p.abs() + q.abs()).mul_add(share, least));
    }
    (spans & all.simd_eq(all)).all_true() && bounds.greatest() <= LARGEST_COORDINATE
}
