// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and spheres of meshes: as the tree takes them, and hits on them.
//! A hit becomes a triangle in the tangent plane whose barycentric coordinates `u` and `v` are those of the hit, so that points,
//! normals and derivatives come out of the code for triangles. Space: object.
//! Source: ribbons that face rays are shaded as the tubes that they stand for, so that hair has the same lobes in both forms
//! [CBTB16]. Tests: crates/render/tests/curves.rs.

use glam::{DVec3, Vec3};
use gnurt_accel as accel;
use gnurt_scene::{CurveBasis, CurveForm, Curves, Mesh, Primitives};

/// Texture coordinates of a hit whose vertices have some change so little over the tangent plane: only its axes count.
const STILL: f32 = 1e-6;

/// The arrays of a mesh that is not made of triangles, as the tree takes them.
pub(super) enum Arrays {
    Triangles,
    Curves(Vec<[f32; 4]>),
    Spheres(Vec<[f32; 3]>),
}

impl Arrays {
    pub(super) fn of(mesh: &Mesh) -> Self {
        match &mesh.primitives {
            Primitives::Triangles => Self::Triangles,
            Primitives::Curves(curves) => Self::Curves(with_radii(mesh, curves)),
            // A sphere for each radius, and no more.
            Primitives::Spheres(radii) => Self::Spheres(mesh.positions[..radii.len()].to_vec()),
        }
    }

    /// The geometry of the mesh that they are of.
    pub(super) fn geometry<'a>(&'a self, mesh: &'a Mesh) -> accel::Geometry<'a> {
        match (self, &mesh.primitives) {
            (Self::Curves(vertices), Primitives::Curves(curves)) => {
                curves_of(curves, vertices, &curves.segments, &mesh.normals).into()
            }
            (Self::Spheres(centers), Primitives::Spheres(radii)) => accel::Spheres { centers, radii }.into(),
            _ => accel::Triangles { positions: &mesh.positions, indices: &mesh.indices }.into(),
        }
    }
}

fn with_radii(mesh: &Mesh, curves: &Curves) -> Vec<[f32; 4]> {
    mesh.positions.iter().zip(&curves.radii).map(|(&[x, y, z], &radius)| [x, y, z, radius]).collect()
}

fn curves_of<'a>(
    curves: &Curves,
    vertices: &'a [[f32; 4]],
    segments: &'a [u32],
    normals: &'a [[f32; 3]],
) -> accel::Curves<'a> {
    let basis = match curves.basis {
        CurveBasis::Linear => accel::CurveBasis::Linear,
        CurveBasis::Bezier => accel::CurveBasis::Bezier,
        CurveBasis::BSpline => accel::CurveBasis::BSpline,
        CurveBasis::CatmullRom => accel::CurveBasis::CatmullRom,
    };
    let form = match curves.form {
        CurveForm::Flat => accel::CurveForm::Flat,
        CurveForm::Round => accel::CurveForm::Round,
        CurveForm::Oriented => accel::CurveForm::Oriented,
    };
    let normals = if form == accel::CurveForm::Oriented { normals } else { &[] };
    // Light that enters a fibre leaves it by its lobes.
    accel::Curves {
        is_seen_from_outside: !curves.has_inside,
        ..accel::Curves::new(basis, form, vertices, segments).with_normals(normals)
    }
}

/// A hit as a triangle in its tangent plane.
pub(super) struct Tangent {
    pub(super) corners: [[f32; 3]; 3],
    /// Texture coordinates of the corners.
    pub(super) uv: [[f32; 2]; 3],
    /// How far a ray that leaves must start from the hit, so that it does not meet a ribbon that turns to it.
    pub(super) width: f32,
}

impl Tangent {
    /// A plane across a direction, through a point.
    pub(super) fn across(point: DVec3, along: DVec3, dir: DVec3) -> Self {
        let corners = [point, point + along, point + along.cross(dir)].map(|p| p.as_vec3().to_array());
        Self { corners, uv: [[0.0; 2]; 3], width: 0.0 }
    }
}

/// A ray in the mesh's space, and its hit.
pub(super) struct Hit {
    pub(super) prim_id: usize,
    pub(super) uv: [f32; 2],
    /// Where the ray is at the hit, and its direction.
    pub(super) point: DVec3,
    pub(super) dir: DVec3,
}

impl Hit {
    /// The tangent plane; `None` where the mesh has no such primitive, or it has no direction there.
    pub(super) fn tangent(&self, mesh: &Mesh) -> Option<Tangent> {
        match &mesh.primitives {
            Primitives::Triangles => None,
            Primitives::Curves(curves) => self.on_curve(mesh, curves),
            Primitives::Spheres(radii) => {
                let center = Vec3::from(*mesh.positions.get(self.prim_id)?).as_dvec3();
                let out = (self.point - center).try_normalize()?;
                let point = center + out * f64::from(radii[self.prim_id]);
                let along = out.any_orthonormal_vector();
                // Around a sphere the coordinates of the hit itself say where.
                Some(self.plane(mesh, point, [along, out.cross(along)], [0.0; 2], 0.0))
            }
        }
    }

    fn on_curve(&self, mesh: &Mesh, curves: &Curves) -> Option<Tangent> {
        let first = *curves.segments.get(self.prim_id)? as usize;
        let range = first..first + curves.basis.order();
        let vertices: Vec<[f32; 4]> = mesh
            .positions
            .get(range.clone())?
            .iter()
            .zip(curves.radii.get(range.clone())?)
            .map(|(&[x, y, z], &radius)| [x, y, z, radius])
            .collect();
        let normals = mesh.normals.get(range).unwrap_or(&[]);
        let one = curves_of(curves, &vertices, &[0], normals);
        let [u, v] = self.uv.map(f64::from);
        let [x, y, z, radius] = one.point(0, u)?;
        let (center, along) = (DVec3::new(x, y, z), DVec3::from(one.tangent(0, u)?));
        let unit = along.try_normalize()?;
        let span = curves.spans.get(self.prim_id).copied().unwrap_or([0.0, 1.0]);
        let across = if curves.form == CurveForm::Flat { 0.5 * (self.uv[1] + 1.0) } else { self.uv[1] };
        let at = [span[0] + (span[1] - span[0]) * self.uv[0], across];
        let (point, out, width) = match curves.form {
            CurveForm::Flat => {
                // Left, seen along ray and curve, is -1.
                let left =
                    self.dir.cross(unit).try_normalize().unwrap_or_else(|| unit.any_orthonormal_vector());
                let facing = unit.cross(left);
                let facing = if facing.dot(self.dir) > 0.0 { -facing } else { facing };
                let to_side = (self.point - center).dot(left) / radius.max(f64::MIN_POSITIVE);
                let side = v.abs().copysign(to_side).clamp(-1.0, 1.0);
                let out = left * side + facing * (1.0 - side * side).max(0.0).sqrt();
                (center + left * (side * radius), out, 2.0 * radius)
            }
            CurveForm::Round => {
                let out = DVec3::from(one.normal(0, [u, v], self.point.to_array())?).try_normalize()?;
                (self.point, out, 0.0)
            }
            CurveForm::Oriented => {
                let out = DVec3::from(one.normal(0, [u, v], self.point.to_array())?).try_normalize()?;
                (self.point, out, 0.0)
            }
        };
        let along = (along - out * along.dot(out)).try_normalize()? * along.length();
        Some(self.plane(mesh, point, [along, out.cross(unit)], at, width as f32))
    }

    /// A triangle through `point` with these axes, on which `at` are the texture coordinates of the hit.
    fn plane(&self, mesh: &Mesh, point: DVec3, axes: [DVec3; 2], at: [f32; 2], width: f32) -> Tangent {
        let [u, v] = self.uv.map(f64::from);
        let origin = point - axes[0] * u - axes[1] * v;
        let corners = [origin, origin + axes[0], origin + axes[1]].map(|corner| corner.as_vec3().to_array());
        let corners_of = mesh.corners(self.prim_id).filter(|_| !mesh.texcoords.is_empty());
        let (at, step) = match corners_of {
            Some([a, b, _]) => {
                let of = |vertex: usize, k: usize| mesh.texcoords.get(vertex).map_or(0.0, |uv| uv[k]);
                ([0, 1].map(|k| of(a, k) + (of(b, k) - of(a, k)) * self.uv[0]), STILL)
            }
            None => (at, 1.0),
        };
        let first = [0, 1].map(|k| at[k] - step * self.uv[k]);
        Tangent { corners, uv: [first, [first[0] + step, first[1]], [first[0], first[1] + step]], width }
    }
}
