// SPDX-License-Identifier: GPL-3.0-or-later
//! From hits to surface points: positions, normals, coordinates and attributes out of the meshes' arrays.
//! Source: [PJH23] section 6.8 (bounding the error of a hit point); [Hanika2021] (`lift`); original. Space: world.
//! Points are computed from barycentric weights, not from `org + t dir`: they lie in their triangle's plane up to
//! rounding, and `error` bounds that from the largest coordinate involved.
//! Proof: crates/render/tests/{offsets,terminator,appearance}.rs.

use glam::{DVec3, Vec3};
use gnurt_accel::{HitBatch, RayBatch};
use gnurt_scene::{Attribute, Mesh, Rate};
use gnurt_shading::{AttributeRequest, Detail, SampleKey, SurfaceBatch};

use super::{PlacedInstance, World};

/// Rounding errors of the point, of its transform, and of the test that the next ray makes against the same triangle,
/// as a multiple of the largest coordinate.
pub(super) const ERROR_SCALE: f32 = 8.0 * f32::EPSILON;

/// What a batch of points is made from.
#[derive(Clone, Copy)]
pub(crate) struct HitLanes<'a> {
    pub(crate) rays: &'a RayBatch,
    pub(crate) keys: &'a [SampleKey],
    pub(crate) hits: &'a HitBatch,
    /// Bounces that the rays had behind them.
    pub(crate) depth: u32,
    /// World units added to each point's error.
    pub(crate) epsilon: f32,
}

/// All that the points of one triangle have in common.
struct Triangle<'w> {
    /// Primitive, geometry and instance, as hits name them.
    ids: [u32; 3],
    instance: &'w PlacedInstance,
    mesh: &'w Mesh,
    corners: [usize; 3],
    /// Object space.
    positions: [Vec3; 3],
    /// Unit, object space; `None` where it is flat.
    normals: Option<[Vec3; 3]>,
    /// `None` where vertex normals are enough.
    ng: Option<Vec3>,
    uv: [[f32; 2]; 3],
    /// What divides the interpolated coordinates, if anything does.
    divisors: Option<[f32; 3]>,
    uv_per_length: f32,
}

/// What only points need that rays leave from; world space.
struct Surroundings {
    error: f32,
    dp_du: Vec3,
    dp_dv: Vec3,
    /// Of the corners, object space, scaled as the two above are; where the mesh has any.
    tangents: Option<Tangents>,
    corners: [Vec3; 3],
    /// Unit normals of the corners, where it has any.
    normals: [Vec3; 3],
}

/// Tangents of a triangle's corners, and how far points move along them and across them per texture u and v.
struct Tangents {
    corners: [Vec3; 3],
    /// 1 or -1: see `Mesh::tangents`.
    side: f32,
    lengths: [f32; 2],
}

impl World {
    /// Writes the points of some lanes, all of which hit something: others panic.
    pub(crate) fn surface_points(
        &self,
        from: HitLanes,
        lanes: &[u32],
        detail: Detail,
        attributes: &[AttributeRequest],
        points: &mut SurfaceBatch,
    ) {
        points.resize(lanes.len(), detail);
        points.depth = from.depth;
        let (hits, [x, y, z]) = (from.hits, &from.rays.dir);
        let (mut last, mut around): (Option<Triangle>, _) = (None, None);
        for (i, &lane) in lanes.iter().enumerate() {
            let lane = lane as usize;
            let (t, u, v) = (hits.t[lane], hits.u[lane], hits.v[lane]);
            let ids = [hits.prim_id[lane], hits.geom_id[lane], hits.inst_id[lane]];
            // Neighbours often hit the same triangle.
            let triangle = match &last {
                Some(triangle) if triangle.ids == ids => triangle,
                _ => {
                    let triangle = last.insert(self.triangle(ids, detail));
                    if detail == Detail::Full {
                        around = Some(triangle.surroundings(from.epsilon));
                    }
                    triangle
                }
            };
            let ray_dir = Vec3::new(x[lane], y[lane], z[lane]);
            points.ray_dir.set(i, ray_dir);
            points.key[i] = from.keys[lane];
            (points.t[i], points.u[i], points.v[i]) = (t, u, v);
            (points.prim_id[i], points.geom_id[i], points.inst_id[i]) = (ids[0], ids[1], ids[2]);
            triangle.write_point(i, [u, v], ray_dir, around.as_ref(), points);
        }
        points.attributes = attributes.iter().map(|request| self.attribute(request, points)).collect();
    }

    #[inline]
    fn triangle(&self, ids: [u32; 3], detail: Detail) -> Triangle<'_> {
        let [prim_id, geom_id, inst_id] = ids;
        let instance = self.instance(inst_id);
        let mesh = &*instance.object.meshes[geom_id as usize];
        let corners = mesh.indices[prim_id as usize].map(|i| i as usize);
        let positions = corners.map(|i| Vec3::from(mesh.positions[i]));
        let normals = self.vertex_normals(mesh, corners);
        let is_enough = detail == Detail::Color && normals.is_some() && mesh.texcoords.is_empty();
        let ng = (!is_enough).then(|| geometric_normal(instance, &positions));
        // Without coordinates nothing changes with them.
        let (mut uv, mut divisors, mut uv_per_length) = ([[0.0; 2]; 3], None, 0.0);
        if !mesh.texcoords.is_empty() {
            uv = corners.map(|i| mesh.texcoords.get(i).copied().unwrap_or_default());
            divisors = mesh.texcoord_divisors(corners);
            uv_per_length = scale_of(&positions.map(|q| instance.point(q)), &divided(uv, divisors));
        }
        Triangle { ids, instance, mesh, corners, positions, normals, ng, uv, divisors, uv_per_length }
    }

    /// Unit, in the object; `None` where the triangle is flat.
    pub(super) fn vertex_normals(&self, mesh: &Mesh, corners: [usize; 3]) -> Option<[Vec3; 3]> {
        if self.face_normals || mesh.normals.is_empty() {
            return None;
        }
        let mut normals = [Vec3::ZERO; 3];
        for (normal, corner) in normals.iter_mut().zip(corners) {
            // Normals of any length: each counts as a direction.
            *normal = Vec3::from(*mesh.normals.get(corner)?).try_normalize()?;
        }
        Some(normals)
    }

    /// Component k of lane i at `[k * lanes + i]`.
    fn attribute(&self, request: &AttributeRequest, points: &SurfaceBatch) -> Vec<f32> {
        let (lanes, components) = (points.len(), request.components as usize);
        let default = |k: usize| request.default.get(k).copied().unwrap_or(0.0);
        let mut values = vec![0.0; lanes * components];
        // Names are compared once for lanes of one mesh that follow each other.
        let mut last: Option<(&Mesh, Option<&Attribute>)> = None;
        for i in 0..lanes {
            let mesh = &*self.instance(points.inst_id[i]).object.meshes[points.geom_id[i] as usize];
            let found = match last {
                Some((same, found)) if std::ptr::eq(same, mesh) => found,
                _ => mesh.attributes.iter().find(|a| a.name == request.name),
            };
            last = Some((mesh, found));
            let prim_id = points.prim_id[i] as usize;
            let weights = [1.0 - points.u[i] - points.v[i], points.u[i], points.v[i]];
            for k in 0..components {
                let value = found.and_then(|a| attribute_at(a, mesh, prim_id, weights, k));
                values[k * lanes + i] = value.unwrap_or_else(|| default(k));
            }
        }
        values
    }
}

impl Triangle<'_> {
    fn surroundings(&self, epsilon: f32) -> Surroundings {
        let Self { instance, positions, .. } = self;
        let reach = positions[0].abs().max(positions[1].abs()).max(positions[2].abs());
        let normals = self.normals.unwrap_or_default();
        let [dp_du, dp_dv] = change_per_uv(positions, &divided(self.uv, self.divisors));
        Surroundings {
            error: ERROR_SCALE * instance.magnitude(reach) + epsilon,
            dp_du: instance.linear * dp_du,
            dp_dv: instance.linear * dp_dv,
            tangents: self.tangents([dp_du, dp_dv]),
            corners: positions.map(|q| instance.point(q)),
            normals: normals.map(|n| (instance.normals * n).normalize_or_zero()),
        }
    }

    /// The mesh's own tangents, where all corners have one and normals to go with them.
    fn tangents(&self, [dp_du, dp_dv]: [Vec3; 2]) -> Option<Tangents> {
        if self.mesh.tangents.is_empty() {
            return None;
        }
        self.normals?;
        let mut corners = [Vec3::ZERO; 3];
        let mut side = 0.0;
        for (tangent, corner) in corners.iter_mut().zip(self.corners) {
            let [x, y, z, w] = *self.mesh.tangents.get(corner)?;
            *tangent = Vec3::new(x, y, z).try_normalize()?;
            side += w;
        }
        let length = |v: Vec3| if v == Vec3::ZERO { 1.0 } else { v.length() };
        Some(Tangents { corners, side: 1.0_f32.copysign(side), lengths: [length(dp_du), length(dp_dv)] })
    }

    /// Writes what follows from the place on the triangle.
    #[inline]
    fn write_point(
        &self,
        i: usize,
        [u, v]: [f32; 2],
        ray_dir: Vec3,
        around: Option<&Surroundings>,
        out: &mut SurfaceBatch,
    ) {
        let (instance, weights) = (self.instance, [1.0 - u - v, u, v]);
        let p = instance.point(mix3(&self.positions, weights));
        let ns = self.normals.and_then(|n| (instance.normals * mix3(&n, weights)).try_normalize());
        let ng = self.ng.or(ns).unwrap_or_else(|| geometric_normal(instance, &self.positions));
        out.p.set(i, p);
        out.ng.set(i, ng);
        out.ns.set(i, ns.unwrap_or(ng));
        let texcoord = if self.mesh.texcoords.is_empty() {
            [0.0; 2]
        } else {
            let mixed = [0, 1].map(|k| (0..3).map(|c| weights[c] * self.uv[c][k]).sum::<f32>());
            match self.divisors {
                None => mixed,
                Some(q) => mixed.map(|x| x / (0..3).map(|c| weights[c] * q[c]).sum::<f32>()),
            }
        };
        (out.texcoord[0][i], out.texcoord[1][i]) = (texcoord[0], texcoord[1]);
        out.uv_per_length[i] = self.uv_per_length;
        let color = vertex_color(self.mesh, self.corners, weights);
        out.color.set(i, Vec3::new(color[0], color[1], color[2]));
        out.alpha[i] = color[3];
        if let Some(around) = around {
            out.error[i] = around.error;
            let own = around.tangents.as_ref().and_then(|tangents| {
                let tangent = mix3(&tangents.corners, weights).try_normalize()?;
                let across =
                    mix3(self.normals.as_ref()?, weights).cross(tangent).try_normalize()? * tangents.side;
                let [u, v] = tangents.lengths;
                Some([instance.linear * (tangent * u), instance.linear * (across * v)])
            });
            let [dp_du, dp_dv] = own.unwrap_or([around.dp_du, around.dp_dv]);
            out.dp_du.set(i, dp_du);
            out.dp_dv.set(i, dp_dv);
            let lift = ns.map_or(Vec3::ZERO, |ns| {
                // On the side that the ray comes from, as the facing shading normal is.
                let to_viewer = if ng.dot(ray_dir) <= 0.0 { ng } else { -ng };
                let seen = if ns.dot(to_viewer) < 0.0 { around.normals.map(|n| -n) } else { around.normals };
                lift(p, &around.corners, &seen, weights)
            });
            out.lift.set(i, lift);
        }
    }
}

/// Component `k` of an attribute; `None` where it has none.
fn attribute_at(a: &Attribute, mesh: &Mesh, prim_id: usize, weights: [f32; 3], k: usize) -> Option<f32> {
    let n = a.components as usize;
    let value = |i: usize| a.data.get(i * n + k).copied().filter(|_| k < n);
    match a.rate {
        Rate::Triangle => value(prim_id),
        Rate::Vertex => {
            let corners = mesh.indices[prim_id].map(|i| i as usize);
            (0..3).try_fold(0.0, |sum, c| Some(sum + weights[c] * value(corners[c])?))
        }
    }
}

/// From `p` to the curved surface: `p` is raised to the plane through each corner across its normal where it lies below
/// it, and the three are mixed.
fn lift(p: Vec3, corners: &[Vec3; 3], normals: &[Vec3; 3], weights: [f32; 3]) -> Vec3 {
    let raised: [Vec3; 3] = std::array::from_fn(|k| {
        let below = (corners[k] - p).dot(normals[k]).max(0.0);
        normals[k] * below
    });
    mix3(&raised, weights)
}

pub(super) fn mix3(values: &[Vec3; 3], weights: [f32; 3]) -> Vec3 {
    values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
}

/// Unit, in the world, on the side from which the mesh's triangle winds counter-clockwise.
pub(super) fn geometric_normal(instance: &PlacedInstance, p: &[Vec3; 3]) -> Vec3 {
    // Double precision: squares of tiny or huge edges leave the range of floats.
    let [a, b, c] = p.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
    let in_world = instance.normals.as_dmat3() * normal;
    in_world.normalize_or(DVec3::Z).as_vec3()
}

/// The coordinates at the corners.
fn divided(uv: [[f32; 2]; 3], divisors: Option<[f32; 3]>) -> [[f32; 2]; 3] {
    divisors.map_or(uv, |q| std::array::from_fn(|c| uv[c].map(|x| x / q[c])))
}

/// How far a point moves per texture u and v; zero where coordinates say nothing.
fn change_per_uv(p: &[Vec3; 3], uv: &[[f32; 2]; 3]) -> [Vec3; 2] {
    let [du1, dv1] = [0, 1].map(|k| uv[1][k] - uv[0][k]);
    let [du2, dv2] = [0, 1].map(|k| uv[2][k] - uv[0][k]);
    let area = du1 * dv2 - du2 * dv1;
    let (a, b) = (p[1] - p[0], p[2] - p[0]);
    let finite = |change: Vec3| if change.is_finite() { change } else { Vec3::ZERO };
    [finite((a * dv2 - b * dv1) / area), finite((b * du1 - a * du2) / area)]
}

/// Root of the triangle's area in texture coordinates over that in the world; zero where it has none.
fn scale_of(p: &[Vec3; 3], uv: &[[f32; 2]; 3]) -> f32 {
    let [du1, dv1] = [0, 1].map(|k| uv[1][k] - uv[0][k]);
    let [du2, dv2] = [0, 1].map(|k| uv[2][k] - uv[0][k]);
    let ratio = (du1 * dv2 - du2 * dv1).abs() / (p[1] - p[0]).cross(p[2] - p[0]).length();
    if ratio.is_finite() { ratio.sqrt() } else { 0.0 }
}

/// Red, green, blue and opacity; white where the mesh has none.
pub(super) fn vertex_color(mesh: &Mesh, corners: [usize; 3], weights: [f32; 3]) -> [f32; 4] {
    if mesh.colors.is_empty() {
        return [1.0; 4];
    }
    let colors = corners.map(|i| mesh.colors.get(i).copied().unwrap_or([1.0; 4]));
    std::array::from_fn(|k| (0..3).map(|c| weights[c] * colors[c][k]).sum())
}
