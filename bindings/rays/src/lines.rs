// SPDX-License-Identifier: GPL-3.0-or-later
//! Straight ribbons that face each ray: Embree's flat linear curves, two vertices with a radius each.
//! From the definition: a ray meets the ribbon where, seen along the ray, it is nearest to the segment, if that is no farther than the radius there, which grows linearly. Space: object. Tests: `tests`.

use gnurt_accel::{Aabb, Ray, UserGeometry, UserHit};

/// Segments; `None` where an index is none.
#[derive(Debug)]
pub(crate) struct Lines {
    segments: Vec<Option<[[f32; 4]; 2]>>,
}

impl Lines {
    /// Of each index the vertex and the next one.
    pub(crate) fn new(vertices: &[[f32; 4]], indices: &[[u32; 1]]) -> Self {
        let segment = |&[i]: &[u32; 1]| Some([*vertices.get(i as usize)?, *vertices.get(i as usize + 1)?]);
        Self { segments: indices.iter().map(segment).collect() }
    }
}

impl UserGeometry for Lines {
    fn count(&self) -> u32 {
        self.segments.len() as u32
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        let Some([a, b]) = self.segments[prim_id as usize] else { return Aabb::EMPTY };
        let ends = |sign: f32, pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|k| pick(a[k] + sign * a[3].abs(), b[k] + sign * b[3].abs()))
        };
        Aabb { min: ends(-1.0, f32::min), max: ends(1.0, f32::max) }
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let Some(ends) = self.segments[prim_id as usize] else { return };
        let dir = ray.dir.map(f64::from);
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let clipped = ends.map(|end| {
            let from = [0, 1, 2].map(|k| f64::from(end[k]) - f64::from(ray.org[k]));
            let t = dot(from, dir) / dot(dir, dir);
            (t, [0, 1, 2].map(|k| from[k] - t * dir[k]))
        });
        let [(t0, a), (t1, b)] = clipped;
        let along = [0, 1, 2].map(|k| b[k] - a[k]);
        let length = dot(along, along);
        let u = if length > 0.0 { (-dot(a, along) / length).clamp(0.0, 1.0) } else { 0.0 };
        let at = [0, 1, 2].map(|k| a[k] + u * along[k]);
        let [r0, r1] = ends.map(|end| f64::from(end[3]));
        let radius = r0 + u * (r1 - r0);
        // Not so of NaN.
        if dot(at, at) <= radius * radius {
            hit(UserHit { t: (t0 + u * (t1 - t0)) as f32, u: u as f32, v: 0.0 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ribbons_face_the_ray() {
        let vertices = [[0.0, 0.0, 0.0, 1.0], [4.0, 0.0, 0.0, 2.0], [9.0, 9.0, 9.0, 9.0]];
        let lines = Lines::new(&vertices, &[[0], [2]]);
        let t = |org: [f32; 3], dir: [f32; 3]| {
            let mut found = None;
            lines.intersect(0, &Ray::new(org, dir), &mut |hit| found = Some((hit.t, hit.u)));
            found
        };
        assert_eq!(t([2.0, 1.4, -3.0], [0.0, 0.0, 0.5]), Some((6.0, 0.5)), "in the middle the radius is 1.5");
        assert_eq!(t([2.0, 1.6, -3.0], [0.0, 0.0, 1.0]), None, "beside it");
        assert_eq!(t([-0.9, 0.0, -3.0], [0.0, 0.0, 1.0]), Some((3.0, 0.0)), "its end is round");
        assert_eq!(t([2.0, 7.0, 1.0], [0.0, -1.0, 0.0]), Some((7.0, 0.5)), "from above it is as broad");
        assert_eq!(
            lines.bounds(0),
            Aabb { min: [-1.0, -2.0, -2.0], max: [6.0, 2.0, 2.0] },
            "around both ends"
        );
        assert!(lines.bounds(1).is_empty(), "there is no vertex 3");
    }
}
