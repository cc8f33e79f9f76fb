// SPDX-License-Identifier: GPL-3.0-or-later
//! How shading normals change over a surface, and how the starts of mirrored rays do.
//! Source: [Ige99] section 3.2 (derivatives of interpolated normals); [Hanika2021] (`lift`). Space: world.
//! Differs: spheres by their form; moving meshes at the time of the ray's key.
//! Invariant: the derivatives are those of the points of `surface`. Tests: `tests` in `transport::manifold`.

use glam::{Mat3, Vec3};
use gnurt_accel::KeyInterval;
use gnurt_scene::{Mesh, Primitives};
use gnurt_shading::{SurfaceBatch, SurfacePoint};

use super::World;
use super::instance::PlacedInstance;

/// Changes per movement of a point along its surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    /// Of the unit shading normal that faces the ray.
    pub(crate) normal: Mat3,
    /// Of [`SurfacePoint::lift`].
    pub(crate) lift: Mat3,
}

/// The largest square of a difference of normals that are one.
const SAME_NORMAL: f32 = 1e-6;

impl World {
    /// The changes at point `k`, whose facing normals are those of `point`; `None` on curves, and where the shading normal
    /// is not the one that follows from the mesh.
    pub(crate) fn bend(&self, points: &SurfaceBatch, k: usize, point: &SurfacePoint) -> Option<Bend> {
        let (instance, leaf) = self.surface_points().instance(points.leaf_id[k]);
        let time = if self.is_open() { self.time(points.key[k]) } else { 0.0 };
        let mesh = &*instance.leaf(leaf).0.meshes[points.geom_id[k] as usize];
        let prim = points.prim_id[k] as usize;
        let at = instance.leaf_at(leaf, time);
        let found = match &mesh.primitives {
            Primitives::Curves(_) => return None,
            Primitives::Spheres(radii) => {
                let object_from_world = at.linear.inverse();
                let center = Vec3::from(*mesh.positions.get(prim)?);
                let out = (object_from_world * (point.p - at.origin) - center).try_normalize()?;
                let across = (Mat3::IDENTITY - outer(out, out)) * radii[prim].recip();
                Normals {
                    mixed: at.normals * out,
                    change: at.normals * across * object_from_world,
                    lifts: None,
                }
            }
            Primitives::Triangles => {
                let corners =
                    Corners::of(instance, (leaf, points.geom_id[k], prim), time, self.face_normals)?;
                let p = corners.p.map(|p| at.point(p));
                corners.normals(p, at.normals, [points.u[k], points.v[k]])
            }
        };
        let Some(found) = found.into_some() else {
            let flat = Bend { normal: Mat3::ZERO, lift: Mat3::ZERO };
            return (point.ns.distance_squared(point.ng) < SAME_NORMAL).then_some(flat);
        };
        let length = found.mixed.length();
        let unit = found.mixed / length;
        let side = if unit.dot(point.ns) < 0.0 { -1.0 } else { 1.0 };
        if (unit * side).distance_squared(point.ns) > SAME_NORMAL {
            return None;
        }
        let normal = (Mat3::IDENTITY - outer(unit, unit)) * found.change * (side / length);
        let lift = found.lifts.map_or(Mat3::ZERO, |lifts| lifts.change(point, side));
        (normal.is_finite() && lift.is_finite()).then_some(Bend { normal, lift })
    }
}

/// `a` times `b`, transposed.
fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// An interpolated normal, of any length.
struct Normals {
    mixed: Vec3,
    /// Its change per movement of the point.
    change: Mat3,
    lifts: Option<Lifts>,
}

impl Normals {
    fn into_some(self) -> Option<Self> {
        (self.mixed != Vec3::ZERO && self.mixed.is_finite()).then_some(self)
    }
}

/// A triangle and its normals, object space; without normals if it is flat.
struct Corners {
    p: [Vec3; 3],
    normals: Option<[Vec3; 3]>,
}

impl Corners {
    fn of(
        instance: &PlacedInstance,
        (leaf, geom, prim): (u32, u32, usize),
        time: f32,
        face_normals: bool,
    ) -> Option<Self> {
        let object = instance.leaf(leaf).0;
        let mesh = &*object.meshes[geom as usize];
        let vertices = mesh.corners(prim)?;
        let keys = object.keys.get(geom as usize).map_or(&[][..], |keys| &keys[..]);
        let interval = KeyInterval::of(time, keys.len());
        let read = |array: fn(&Mesh) -> &[[f32; 3]], vertex: usize| -> Option<Vec3> {
            let at = |mesh: &Mesh| array(mesh).get(vertex).copied();
            Some(match keys {
                [] => at(mesh)?.into(),
                _ => interval.mix3(at(&keys[interval.key])?, at(&keys[interval.next])?).into(),
            })
        };
        let three = |array: fn(&Mesh) -> &[[f32; 3]]| {
            let [a, b, c] = vertices.map(|vertex| read(array, vertex));
            Some([a?, b?, c?])
        };
        let normals = three(|mesh| &mesh.normals).filter(|_| !face_normals);
        let units = normals.map(|normals| normals.map(Vec3::normalize_or_zero));
        let normals = units.filter(|units| !units.contains(&Vec3::ZERO));
        Some(Self { p: three(|mesh| &mesh.positions)?, normals })
    }

    /// The normals at barycentric weights; `p` are the corners in the world.
    fn normals(&self, p: [Vec3; 3], turn: Mat3, [u, v]: [f32; 2]) -> Normals {
        let flat = Normals { mixed: Vec3::ZERO, change: Mat3::ZERO, lifts: None };
        let Some(units) = self.normals else { return flat };
        let turned = units.map(|unit| turn * unit);
        let (a, b) = (p[1] - p[0], p[2] - p[0]);
        let normal = a.cross(b);
        // How the weights of the second and the third corner change.
        let (along_a, along_b) = (b.cross(normal), normal.cross(a));
        let (along_a, along_b) = (along_a / along_a.dot(a), along_b / along_b.dot(b));
        let weights = [1.0 - u - v, u, v];
        let changes = [-along_a - along_b, along_a, along_b];
        let mixed = turned[0] * weights[0] + turned[1] * weights[1] + turned[2] * weights[2];
        let change = (0..3).fold(Mat3::ZERO, |sum, c| sum + outer(turned[c], changes[c]));
        let units = turned.map(Vec3::normalize_or_zero);
        Normals { mixed, change, lifts: Some(Lifts { p, units, weights, changes }) }
    }
}

/// The input of the lift of a point.
struct Lifts {
    p: [Vec3; 3],
    units: [Vec3; 3],
    weights: [f32; 3],
    changes: [Vec3; 3],
}

impl Lifts {
    /// The change of the lift; `side`: 1 if the interpolated normal faces the ray, else -1.
    fn change(&self, point: &SurfacePoint, side: f32) -> Mat3 {
        (0..3).fold(Mat3::ZERO, |sum, c| {
            let visible = self.units[c] * side;
            let below = (self.p[c] - point.p).dot(visible);
            if below <= 0.0 {
                return sum;
            }
            sum + outer(visible, self.changes[c] * below - visible * self.weights[c])
        })
    }
}
