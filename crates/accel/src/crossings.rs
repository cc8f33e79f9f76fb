// SPDX-License-Identifier: GPL-3.0-or-later
//! How often a ray crosses surfaces. Source: original; triangles are decided by `exact/line.rs`.
//! Space: world, or that of an object that is asked directly. Invariant: of a closed mesh it is an even number for rays that
//! begin and end outside, wherever they go through it. Proof: `tests/surfaces/crossings.rs`.

use crate::surfaces::Seen;
use crate::target::Target;
use crate::{AnyRay, Query, Ray};
use gnurt_accel_core::exact::{Line, Triangle};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::{LineRegion, Region};

/// What a line crosses, gathered object by object; keeps its memory.
#[derive(Debug, Default)]
pub(crate) struct Crossed {
    /// Triangles by object and number, some of them twice while they are gathered.
    pub(crate) triangles: Vec<(u32, u32)>,
    /// Objects, and how often the line crosses a sphere or the user geometry there.
    pub(crate) others: Vec<(u32, u32)>,
}

impl Crossed {
    pub(crate) fn clear(&mut self) {
        self.triangles.clear();
        self.others.clear();
    }

    /// Takes a primitive that the line may cross.
    pub(crate) fn take(&mut self, line: &Line, seen: &Seen) {
        match &seen.primitive {
            Primitive::Triangle(corners) => {
                if line.crosses(&Triangle::new(corners, seen.place)).is_some() {
                    self.triangles.push((seen.slot, seen.number));
                }
            }
            Primitive::Sphere(center, radius) => {
                let count = seen.line().map_or(0, |line| through_sphere(line, *center, *radius));
                self.others.push((seen.slot, count));
            }
            Primitive::User(user, prim_id) => {
                let mut count = 0;
                if let Some(ray) = seen.line().map(ray_of).filter(Ray::is_sound) {
                    let is_in = |t: f32| t >= ray.t_near && t <= ray.t_far;
                    user.intersect(*prim_id, &ray, &mut |hit| count += u32::from(is_in(hit.t)));
                }
                self.others.push((seen.slot, count));
            }
        }
    }

    /// Once everything is in: triangles that came twice count once.
    pub(crate) fn finish(&mut self) {
        self.triangles.sort_unstable();
        self.triangles.dedup();
    }

    fn count(&self) -> u32 {
        self.triangles.len() as u32 + self.others.iter().map(|(_, count)| count).sum::<u32>()
    }
}

/// How often a ray crosses what it sees.
pub(crate) fn count(target: Target, query: &Query, ray: &dyn AnyRay, crossed: &mut Crossed) -> u32 {
    let rounded = ray.rounded();
    if !rounded.is_sound() {
        return 0;
    }
    let org = ray.origin64().unwrap_or_else(|| rounded.org.map(f64::from));
    let ends = [rounded.t_near, rounded.t_far].map(f64::from);
    let line = Line::new(org, rounded.dir.map(f64::from), ends[0], ends[1]);
    crossed.clear();
    target.show(&Region::line(&line), query.mask & rounded.mask, &mut |seen| crossed.take(&line, seen));
    crossed.finish();
    crossed.count()
}

/// In floats, for the caller's own geometry.
fn ray_of(line: &LineRegion) -> Ray {
    let LineRegion { org, dir, near, far, .. } = line;
    Ray::new(org.map(|x| x as f32), dir.map(|x| x as f32)).within(*near as f32, *far as f32)
}

/// How often a line crosses a sphere between its ends; touching is no crossing.
fn through_sphere(line: &LineRegion, center: [f32; 3], radius: f32) -> u32 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let to = [0, 1, 2].map(|k| f64::from(center[k]) - line.org[k]);
    let square = dot(line.dir, line.dir);
    let middle = dot(to, line.dir) / square;
    let beside = [0, 1, 2].map(|k| to[k] - middle * line.dir[k]);
    let radius = f64::from(radius);
    let half = ((radius * radius - dot(beside, beside)) / square).sqrt();
    // NaN: it passes beside.
    if half.is_nan() || half <= 0.0 {
        return 0;
    }
    // The root that does not cancel, and the other one by their product.
    let away = dot(to, to).sqrt();
    let product = (away - radius) * (away + radius) / square;
    let large = middle + half.copysign(middle);
    let small = product / large;
    [large, small].iter().map(|&t| u32::from(t >= line.near && t <= line.far)).sum()
}
