// SPDX-License-Identifier: GPL-3.0-or-later
//! How often a ray crosses surfaces. Triangles are decided by `exact/line.rs`.
//! Space: world, or that of a directly queried object. Invariant: of a closed mesh it is an even number for
//! rays that begin and end outside, wherever they go through it. Tests: `tests/surfaces/crossings.rs`.

use crate::surfaces::SurfaceInRegion;
use crate::target::Target;
use crate::{AnyRay, Hit, Query, Ray, UserGeometry, UserHit};
use gnurt_accel_core::curve::{CurveHit, RayFrame, Segment};
use gnurt_accel_core::exact::{Line, Triangle};
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::point::through_disc;
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::{LineRegion, Region};

/// The crossings of a line, collected object by object; keeps its memory.
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
    pub(crate) fn take(&mut self, line: &Line, surface: &SurfaceInRegion) {
        match &surface.primitive {
            Primitive::Triangle(corners) => {
                if line.crosses(&Triangle::new(corners, surface.path)).is_some() {
                    self.triangles.push((surface.slot, surface.number));
                }
            }
            Primitive::Sphere(center, radius) => {
                let count = surface.line().map_or(0, |line| through_sphere(line, *center, *radius).count());
                self.others.push((surface.slot, count as u32));
            }
            Primitive::Disc(center, radius, normal) => {
                let count = surface.line().and_then(|line| through_disc_of(line, *center, *radius, *normal));
                self.others.push((surface.slot, u32::from(count.is_some())));
            }
            Primitive::Curve(curves, prim_id, part) => {
                let mut count = 0;
                through_curve(surface, curves.segment(*prim_id), *part, &mut |_| count += 1);
                self.others.push((surface.slot, count));
            }
            Primitive::User(user, prim_id) => {
                let mut count = 0;
                through_user(surface, *user, *prim_id, &mut |_| count += 1);
                self.others.push((surface.slot, count));
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

/// Number of crossings of a ray with visible surfaces.
pub(crate) fn count(target: Target, query: &Query, ray: &dyn AnyRay, crossed: &mut Crossed) -> u32 {
    crossed.clear();
    show(target, query, ray, &mut |line, surface| crossed.take(line, surface));
    crossed.finish();
    crossed.count()
}

/// The crossings of [`count`], in the order along the ray; at one position the lowest ids come first.
pub(crate) fn list(target: Target, query: &Query, ray: &dyn AnyRay, hits: &mut Vec<Hit>) {
    let (mut met, mut others): (Vec<Nearest>, Vec<Nearest>) = Default::default();
    show(target, query, ray, &mut |line, surface| {
        let (slot, number) = (surface.slot, surface.number);
        let at = |t: f64, u: f64, v: f64| {
            let [t, u, v] = [t, u, v].map(|x| x as f32);
            Nearest { u, v, number, slot, ..Nearest::none(t) }
        };
        match &surface.primitive {
            Primitive::Triangle(corners) => {
                let triangle = Triangle::new(corners, surface.path);
                if line.crosses(&triangle).is_some() {
                    let [t, u, v] = line.intersection(&triangle);
                    met.push(at(t, u, v));
                }
            }
            Primitive::Sphere(center, radius) => {
                let through =
                    surface.line().into_iter().flat_map(|line| through_sphere(line, *center, *radius));
                others.extend(through.map(|t| at(t, 0.0, 0.0)));
            }
            Primitive::Disc(center, radius, normal) => {
                let line = surface.line();
                let t = line.and_then(|line| through_disc_of(line, *center, *radius, *normal));
                others.extend(t.map(|t| at(t, 0.0, 0.0)));
            }
            Primitive::Curve(curves, prim_id, part) => {
                let segment = curves.segment(*prim_id);
                through_curve(surface, segment, *part, &mut |hit| others.push(at(hit.t, hit.u, hit.v)));
            }
            Primitive::User(user, prim_id) => through_user(surface, *user, *prim_id, &mut |hit| {
                others.push(at(f64::from(hit.t), f64::from(hit.u), f64::from(hit.v)));
            }),
        }
    });
    // Triangles may be visited twice; spheres and user geometry are not, and may be crossed twice at one
    // position.
    met.sort_unstable_by_key(|hit| (hit.slot, hit.number));
    met.dedup_by_key(|hit| (hit.slot, hit.number));
    met.append(&mut others);
    met.sort_by(|a, b| a.t.total_cmp(&b.t).then_with(|| (a.slot, a.number).cmp(&(b.slot, b.number))));
    hits.clear();
    hits.extend(met.iter().map(|nearest| target.hit(nearest)));
}

/// Visits the surfaces that a ray may cross; none for an invalid ray.
fn show(target: Target, query: &Query, ray: &dyn AnyRay, visit: &mut dyn FnMut(&Line, &SurfaceInRegion)) {
    let rounded = ray.rounded();
    if !rounded.is_sound() {
        return;
    }
    let org = ray.origin64().unwrap_or_else(|| rounded.org.map(f64::from));
    let ends = [rounded.t_near, rounded.t_far].map(f64::from);
    let line = Line::new(org, rounded.dir.map(f64::from), ends[0], ends[1]);
    target.show(&Region::line(&line), query.mask & rounded.mask, &mut |surface| visit(&line, surface));
}

/// In floats, for the caller's own geometry.
fn ray_of(line: &LineRegion) -> Ray {
    let LineRegion { org, dir, near, far, .. } = line;
    Ray::new(org.map(|x| x as f32), dir.map(|x| x as f32)).within(*near as f32, *far as f32)
}

/// Where a line goes through a disc between its ends.
fn through_disc_of(
    line: &LineRegion,
    center: [f32; 3],
    radius: f32,
    normal: Option<[f32; 3]>,
) -> Option<f64> {
    through_disc([line.org, line.dir], center, radius, normal).filter(|&t| t >= line.near && t <= line.far)
}

/// Visits the hits of a line with a piece of a curve between its ends.
fn through_curve(
    surface: &SurfaceInRegion,
    segment: Option<Segment>,
    part: [f64; 2],
    visit: &mut dyn FnMut(CurveHit),
) {
    let (Some(line), Some(segment)) = (surface.line(), segment) else { return };
    segment.meet(&RayFrame::new(line.org, line.dir), part, &mut |hit| {
        if hit.t >= line.near && hit.t <= line.far {
            visit(hit);
        }
        true
    });
}

/// Visits the hits of a line with user geometry between its ends.
fn through_user(
    surface: &SurfaceInRegion,
    user: &dyn UserGeometry,
    prim_id: u32,
    visit: &mut dyn FnMut(&UserHit),
) {
    if let Some(ray) = surface.line().map(ray_of).filter(Ray::is_sound) {
        let is_in = |t: f32| t >= ray.t_near && t <= ray.t_far;
        user.intersect(prim_id, &ray, &mut |hit| {
            if is_in(hit.t) {
                visit(&hit)
            }
        });
    }
}

/// Where a line crosses a sphere between its ends; touching is no crossing.
fn through_sphere(line: &LineRegion, center: [f32; 3], radius: f32) -> impl Iterator<Item = f64> + use<> {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let to = [0, 1, 2].map(|k| f64::from(center[k]) - line.org[k]);
    let square = dot(line.dir, line.dir);
    let middle = dot(to, line.dir) / square;
    let offset = [0, 1, 2].map(|k| to[k] - middle * line.dir[k]);
    let radius = f64::from(radius);
    let half = ((radius * radius - dot(offset, offset)) / square).sqrt();
    // The root that does not cancel, and the other one by their product.
    let away = dot(to, to).sqrt();
    let product = (away - radius) * (away + radius) / square;
    let large = middle + half.copysign(middle);
    let small = product / large;
    let (near, far) = (line.near, line.far);
    // NaN: it misses.
    let is_crossed = half > 0.0;
    [large, small].into_iter().filter(move |&t| is_crossed && t >= near && t <= far)
}
