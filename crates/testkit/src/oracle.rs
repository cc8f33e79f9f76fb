// SPDX-License-Identifier: GPL-3.0-or-later
//! Hits of rays, found by testing every triangle in double precision.
//! Source: \[MT97\], written out; so simple that it is unlikely to be wrong.
//! Space: world; instances carry triangles there. Tests: `tests::finds_the_closest`.

use crate::Soup;

/// A soup and the columns of the affine map to the world.
#[derive(Clone, Copy, Debug)]
pub struct OracleInstance<'a> {
    /// Its meshes, in order.
    pub meshes: &'a [Soup],
    /// Images of the axes, then of the origin.
    pub world_from_object: [[f64; 3]; 4],
}

impl<'a> OracleInstance<'a> {
    /// Meshes in world space.
    #[must_use]
    pub fn identity(meshes: &'a [Soup]) -> Self {
        Self { meshes, world_from_object: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]] }
    }
}

/// A hit, and how doubtful it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleHit {
    /// Ray parameter.
    pub t: f64,
    /// Weight of the second corner.
    pub u: f64,
    /// Weight of the third corner.
    pub v: f64,
    /// Triangle in its mesh.
    pub prim_id: u32,
    /// Mesh in its object.
    pub geom_id: u32,
    /// Instance.
    pub inst_id: u32,
}

/// All hits with `t` in `[t_near, t_far]`, closest first. Triangles are enlarged by `margin`, in barycentric
/// weights: with a positive margin the list holds all possible hits under rounding, with a negative one only
/// certain ones.
#[must_use]
pub fn all_hits(
    instances: &[OracleInstance],
    (org, dir): ([f32; 3], [f32; 3]),
    [t_near, t_far]: [f64; 2],
    margin: f64,
) -> Vec<OracleHit> {
    let (org, dir) = (org.map(f64::from), dir.map(f64::from));
    let mut hits = Vec::new();
    for (inst_id, instance) in instances.iter().enumerate() {
        for (geom_id, mesh) in instance.meshes.iter().enumerate() {
            for prim_id in 0..mesh.indices.len() {
                let Some(corners) = mesh.corners(prim_id).filter(is_traceable) else { continue };
                let corners = corners.map(|p| carry(&instance.world_from_object, p));
                let Some([t, u, v]) = meet(&corners, org, dir) else { continue };
                let inside = u >= -margin && v >= -margin && u + v <= 1.0 + margin;
                if inside && t >= t_near && t <= t_far {
                    let [prim_id, geom_id, inst_id] = [prim_id, geom_id, inst_id].map(|id| id as u32);
                    hits.push(OracleHit { t, u, v, prim_id, geom_id, inst_id });
                }
            }
        }
    }
    hits.sort_by(|a, b| a.t.total_cmp(&b.t));
    hits
}

/// The closest hit.
#[must_use]
pub fn closest(instances: &[OracleInstance], ray: ([f32; 3], [f32; 3])) -> Option<OracleHit> {
    all_hits(instances, ray, [0.0, f64::INFINITY], 0.0).into_iter().next()
}

/// Whether a builder should keep a triangle: finite, not too large.
fn is_traceable(corners: &[[f32; 3]; 3]) -> bool {
    corners.iter().flatten().all(|x| x.abs() <= 1.8e18)
}

fn carry(columns: &[[f64; 3]; 4], p: [f32; 3]) -> [f64; 3] {
    let p = p.map(f64::from);
    [0, 1, 2].map(|k| columns[0][k] * p[0] + columns[1][k] * p[1] + columns[2][k] * p[2] + columns[3][k])
}

/// `t`, `u` and `v` of the ray's point in the triangle's plane.
fn meet([a, b, c]: &[[f64; 3]; 3], org: [f64; 3], dir: [f64; 3]) -> Option<[f64; 3]> {
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let (e1, e2, from) = (minus(*b, *a), minus(*c, *a), minus(org, *a));
    let (p, q) = (cross(dir, e2), cross(from, e1));
    let det = dot(e1, p);
    (det != 0.0).then(|| [dot(e2, q) / det, dot(from, p) / det, dot(dir, q) / det])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_closest() {
        let mut soup = Soup::default();
        for z in [3.0, 1.0, 2.0] {
            soup.push([[0.0, 0.0, z], [2.0, 0.0, z], [0.0, 2.0, z]]);
        }
        let mut instance = OracleInstance::identity(std::slice::from_ref(&soup));
        let ray = ([0.5, 0.25, 0.0], [0.0, 0.0, 0.5]);
        let hit = closest(&[instance], ray).expect("three in a row");
        assert_eq!((hit.t, hit.u, hit.v, hit.prim_id), (2.0, 0.25, 0.125, 1), "the one at z = 1");
        instance.world_from_object[3] = [0.0, 0.0, -2.5];
        let hit = closest(&[instance], ray).expect("one is left in front");
        assert_eq!((hit.t, hit.prim_id), (1.0, 0), "moved backwards");
        assert!(closest(&[instance], ([5.0; 3], [0.0, 0.0, 1.0])).is_none(), "beside them");
    }
}
