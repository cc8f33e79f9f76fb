// SPDX-License-Identifier: GPL-3.0-or-later
//! Normals of hits, and rays that see one side of surfaces only. See docs/reference/queries.md.
//! Tests: `tests/surfaces/normals.rs`.

use crate::lists::answer_each;
use crate::target::Target;
use crate::{AnyRay, Hit, HitBatch, Query, RayBatch, Threads};

/// A side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Face {
    /// From which vertices go around counter-clockwise; the outside of a sphere.
    Front,
    /// The other one.
    Back,
}

fn unit(v: [f64; 3]) -> Option<[f32; 3]> {
    // Squares of very small or large components would be lost.
    let largest = v.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let v = v.map(|x| x / largest);
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length >= 1.0 && length.is_finite()).then(|| v.map(|x| (x / length) as f32))
}

fn point_of(ray: &dyn AnyRay, t: f32) -> [f64; 3] {
    let rounded = ray.rounded();
    let org = ray.origin64().unwrap_or_else(|| rounded.org.map(f64::from));
    [0, 1, 2].map(|k| org[k] + f64::from(t) * f64::from(rounded.dir[k]))
}

/// Whether a ray sees this face of its hit. User geometry has no faces: it is always visible.
fn sees(target: Target, ray: &dyn AnyRay, hit: &Hit, face: Face) -> bool {
    let rounded = ray.rounded();
    let at = Some(point_of(ray, hit.t));
    let Some(normal) = target.raw_normal(hit, at, rounded.time) else { return true };
    let dir = rounded.dir.map(f64::from);
    let along = normal[0] * dir[0] + normal[1] * dir[1] + normal[2] * dir[2];
    match face {
        Face::Front => along <= 0.0,
        Face::Back => along >= 0.0,
    }
}

impl Target<'_> {
    /// The unit normal of a hit at a time; of spheres, if the hit point is given.
    pub(crate) fn normal(self, hit: &Hit, at: Option<[f64; 3]>, time: f32) -> Option<[f32; 3]> {
        unit(self.raw_normal(hit, at, time)?)
    }

    /// That of a ray's hit.
    pub(crate) fn normal_along(self, ray: &dyn AnyRay, hit: &Hit) -> Option<[f32; 3]> {
        self.normal(hit, Some(point_of(ray, hit.t)), ray.rounded().time)
    }

    /// Those of a batch's hits; zeros where there is none.
    pub(crate) fn normals(
        self,
        rays: &RayBatch,
        hits: &HitBatch,
        threads: Threads,
        normals: &mut Vec<[f32; 3]>,
    ) {
        let lanes: Vec<usize> = (0..hits.len()).collect();
        let normal = |i: usize| self.normal_along(&rays.get(i), &hits.get(i)?);
        answer_each(threads, &lanes, normals, || (), |_, &i| normal(i).unwrap_or_default());
    }

    /// Closest hit on a face.
    pub(crate) fn closest_face(self, query: &Query, ray: &impl AnyRay, face: Face) -> Option<Hit> {
        self.closest_filtered(query, ray, |_, hit| sees(self, ray, hit, face))
    }

    /// Whether a face is hit.
    pub(crate) fn any_face(self, query: &Query, ray: &impl AnyRay, face: Face) -> bool {
        self.any_filtered(query, ray, |_, hit| sees(self, ray, hit, face))
    }
}
