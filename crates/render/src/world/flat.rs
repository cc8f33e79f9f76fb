// SPDX-License-Identifier: GPL-3.0-or-later
//! From hits to points for sixteen lanes at once, where they hit flat triangles of Lambert's reflector: the commonest case.
//! Source: as `surface`, of which this is the part that such points need. Space: world.
//! Invariant: places, normals and errors are those of `surface`, bit for bit.
//! Proof: crates/render/tests/lanes.rs.

use glam::Mat3;
use gnurt_scene::{Mesh, TEXCOORD_RQ};
use gnurt_shading::lanes::{Floats, LANES, LanesOf, Mask, Vec3x16, select3};
use gnurt_shading::materials::Lambertian;
use gnurt_simd::{Simd, SimdFloat, f32x16, prelude::*};

use super::surface::ERROR_SCALE;
use super::{PlacedInstance, World};

/// A mesh without vertex normals and colours, of Lambert's reflector.
#[derive(Clone, Copy)]
pub(crate) struct FlatMesh<'w> {
    instance: &'w PlacedInstance,
    mesh: &'w Mesh,
    pub(crate) look: &'w Lambertian,
}

/// What sixteen lanes hit, before anything is computed.
pub(crate) struct FlatLanes<'w> {
    /// By lane; only lanes that were put.
    pub(crate) meshes: [Option<FlatMesh<'w>>; LANES],
    pub(crate) prim_ids: [u32; LANES],
    /// Nine coordinates of the corners, object space.
    corners: [[f32; LANES]; 9],
}

/// Points of lanes.
#[derive(Clone, Copy)]
pub(crate) struct FlatX16<S: Simd> {
    pub(crate) p: Vec3x16<S>,
    /// Unit, on the side that the ray came from.
    pub(crate) normal: Vec3x16<S>,
    /// How far the points may be off their surfaces.
    pub(crate) error: Floats<S>,
    /// Lanes whose ray came to the side that the mesh's normal points to.
    pub(crate) front: Mask<S>,
}

impl World {
    /// The mesh of a hit, if it is flat and Lambert's.
    pub(crate) fn flat_mesh(&self, inst_id: u32, geom_id: u32) -> Option<FlatMesh<'_>> {
        let instance = self.instance(inst_id);
        let mesh = &*instance.object.meshes[geom_id as usize];
        let is_divided = mesh.attributes.iter().any(|attribute| attribute.name == TEXCOORD_RQ);
        let flat = (self.face_normals || mesh.normals.is_empty()) && mesh.colors.is_empty() && !is_divided;
        let look = self.material(mesh.material.index()).lambertian.as_ref().filter(|_| flat)?;
        Some(FlatMesh { instance, mesh, look })
    }
}

impl FlatMesh<'_> {
    /// Texture coordinates at weights of the second and third corner.
    pub(crate) fn texcoord(&self, prim_id: u32, [u, v]: [f32; 2]) -> [f32; 2] {
        if self.mesh.texcoords.is_empty() {
            return [0.0; 2];
        }
        let corners = self.mesh.indices[prim_id as usize];
        let uv = corners.map(|i| self.mesh.texcoords.get(i as usize).copied().unwrap_or_default());
        let weights = [1.0 - u - v, u, v];
        [0, 1].map(|k| (0..3).map(|c| weights[c] * uv[c][k]).sum::<f32>())
    }
}

impl<'w> FlatLanes<'w> {
    pub(crate) fn new() -> Self {
        Self { meshes: [None; LANES], prim_ids: [0; LANES], corners: [[0.0; LANES]; 9] }
    }

    /// Puts what lane `i` hit.
    #[inline(always)]
    pub(crate) fn put(&mut self, i: usize, flat: FlatMesh<'w>, prim_id: u32) {
        (self.meshes[i], self.prim_ids[i]) = (Some(flat), prim_id);
        let [a, b, c] = flat.mesh.indices[prim_id as usize].map(|i| flat.mesh.positions[i as usize]);
        for k in 0..3 {
            self.corners[k][i] = a[k];
            self.corners[k + 3][i] = b[k];
            self.corners[k + 6][i] = c[k];
        }
    }

    /// The points of the lanes in `active`, all of which were put, at weights `u` and `v` of the second and third corner.
    #[inline(always)]
    pub(crate) fn points<S: Simd>(
        &self,
        simd: S,
        active: u64,
        [u, v]: [Floats<S>; 2],
        ray_dir: Vec3x16<S>,
        epsilon: f32,
    ) -> FlatX16<S> {
        let rows = &self.corners;
        let corners = [vector(simd, rows, 0), vector(simd, rows, 3), vector(simd, rows, 6)];
        let place = self.place(simd, active);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let in_object = corners[0] * (one - u - v) + corners[1] * u + corners[2] * v;
        let p = place.linear.times(in_object) + place.origin;
        let normal = normal(simd, &corners, &place.normals);
        let reach = corners[0].abs().max(corners[1].abs()).max(corners[2].abs());
        let Columns([x, y, z]) = place.linear;
        let most = x.abs() * reach.x + y.abs() * reach.y;
        let magnitude = (most + z.abs() * reach.z + place.origin.abs()).max_element();
        let error = magnitude * ERROR_SCALE + f32x16::splat(simd, epsilon);
        let front = normal.dot(ray_dir).simd_le(zero);
        FlatX16 { p, normal: select3(front, normal, -normal), error, front }
    }

    /// Where the objects of the lanes in `active` are.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, active: u64) -> Place<S> {
        let first = self.meshes[active.trailing_zeros() as usize % LANES];
        let mut same = true;
        for i in LanesOf(active) {
            same &= match (self.meshes[i], first) {
                (Some(a), Some(b)) => std::ptr::eq(a.instance, b.instance),
                _ => false,
            };
        }
        let mut rows = [[0.0; LANES]; 21];
        if let Some(FlatMesh { instance, .. }) = first.filter(|_| same) {
            return Place {
                linear: Columns::splat(simd, &instance.linear),
                normals: Columns::splat(simd, &instance.normals),
                origin: Vec3x16::splat(simd, instance.origin),
            };
        }
        for i in LanesOf(active) {
            let Some(FlatMesh { instance, .. }) = self.meshes[i] else { continue };
            let (linear, normals) = (instance.linear.to_cols_array(), instance.normals.to_cols_array());
            for k in 0..9 {
                (rows[k][i], rows[9 + k][i]) = (linear[k], normals[k]);
            }
            for k in 0..3 {
                rows[18 + k][i] = instance.origin[k];
            }
        }
        let linear = Columns([vector(simd, &rows, 0), vector(simd, &rows, 3), vector(simd, &rows, 6)]);
        let normals = Columns([vector(simd, &rows, 9), vector(simd, &rows, 12), vector(simd, &rows, 15)]);
        Place { linear, normals, origin: vector(simd, &rows, 18) }
    }
}

/// Rows `k` to `k + 2`.
#[inline(always)]
fn vector<S: Simd>(simd: S, rows: &[[f32; LANES]], k: usize) -> Vec3x16<S> {
    Vec3x16::load(simd, [&rows[k], &rows[k + 1], &rows[k + 2]], 0)
}

/// A matrix in each lane.
struct Columns<S: Simd>([Vec3x16<S>; 3]);

impl<S: Simd> Columns<S> {
    #[inline(always)]
    fn splat(simd: S, m: &Mat3) -> Self {
        Self([Vec3x16::splat(simd, m.x_axis), Vec3x16::splat(simd, m.y_axis), Vec3x16::splat(simd, m.z_axis)])
    }

    #[inline(always)]
    fn times(&self, v: Vec3x16<S>) -> Vec3x16<S> {
        let [x, y, z] = self.0;
        x * v.x + y * v.y + z * v.z
    }
}

/// See [`PlacedInstance`].
struct Place<S: Simd> {
    linear: Columns<S>,
    normals: Columns<S>,
    origin: Vec3x16<S>,
}

/// The unit normal of triangles in the world, as `surface::geometric_normal` computes it.
#[inline(always)]
fn normal<S: Simd>(simd: S, corners: &[Vec3x16<S>; 3], normals: &Columns<S>) -> Vec3x16<S> {
    // Double precision is half as wide: lower lanes, then upper ones.
    let [a, b, c] = [wide(&corners[0]), wide(&corners[1]), wide(&corners[2])];
    let [x, y, z] = [wide(&normals.0[0]), wide(&normals.0[1]), wide(&normals.0[2])];
    let [x0, y0, z0] = normal64(simd, [a.0, b.0, c.0], [x.0, y.0, z.0]);
    let [x1, y1, z1] = normal64(simd, [a.1, b.1, c.1], [x.1, y.1, z.1]);
    Vec3x16::new(x0.narrow(x1), y0.narrow(y1), z0.narrow(z1))
}

/// Eight doubles.
type Doubles<S> = <f32x16<S> as SimdWiden<S>>::Widened;

#[inline(always)]
fn wide<S: Simd>(v: &Vec3x16<S>) -> ([Doubles<S>; 3], [Doubles<S>; 3]) {
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
