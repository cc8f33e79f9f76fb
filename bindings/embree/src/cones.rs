// SPDX-License-Identifier: GPL-3.0-or-later
//! Straight curves as cones that are cut at right angles, with a cap where no other goes on. Source: Embree's manual; the
//! quadratic equation of a ray and a cone.
//! Space: that of the geometry. Arithmetic in double precision, one by one. Tests: `tests/c/cones.c`.

use gnurt_accel::{Aabb, KeyInterval, Ray, UserGeometry, UserHit};

use crate::ffi_memory::View;

/// Both ends and radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    from: [f64; 3],
    axis: [f64; 3],
    /// At the first end, and how much larger at the second.
    radius: f64,
    growth: f64,
}

/// A geometry of cones.
#[derive(Debug)]
pub(crate) struct Cones {
    /// Vertices and radii by time step.
    steps: Vec<View>,
    times: [f32; 2],
    /// The first vertices.
    indices: View,
    /// By cone, or empty.
    flags: View,
    /// Whether they are seen from outside only.
    is_culled: bool,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Cone {
    pub(crate) fn new([a, b]: [[f32; 4]; 2]) -> Self {
        let from = [0, 1, 2].map(|k| f64::from(a[k]));
        let axis = [0, 1, 2].map(|k| f64::from(b[k]) - from[k]);
        let (radius, end) = (f64::from(a[3]), f64::from(b[3]));
        Self { from, axis, radius, growth: end - radius }
    }

    /// The normal at a point: of a cap where `u` is that of an end.
    pub(crate) fn normal(&self, u: f32, point: [f64; 3]) -> [f64; 3] {
        if u == 0.0 || u == 1.0 {
            return self.axis.map(|x| if u == 0.0 { -x } else { x });
        }
        let offset = [0, 1, 2].map(|k| point[k] - self.from[k]);
        let square = dot(self.axis, self.axis);
        let along = dot(offset, self.axis) / square;
        let radius = self.radius + along * self.growth;
        [0, 1, 2].map(|k| offset[k] - (along + radius * self.growth / square) * self.axis[k])
    }

    /// Calls `hit` with `t` and `u` of all points where a line meets the side or the caps that are there.
    fn meet(&self, org: [f64; 3], dir: [f64; 3], caps: [bool; 2], hit: &mut dyn FnMut(f64, f64)) {
        let square = dot(self.axis, self.axis);
        if square == 0.0 {
            return;
        }
        let org = [0, 1, 2].map(|k| org[k] - self.from[k]);
        let (start, speed) = (dot(org, self.axis) / square, dot(dir, self.axis) / square);
        let (radius, growth) = (self.radius + start * self.growth, speed * self.growth);
        let a = dot(dir, dir) - square * speed * speed - growth * growth;
        let b = dot(org, dir) - square * start * speed - radius * growth;
        let c = dot(org, org) - square * start * start - radius * radius;
        let mut side = |t: f64| {
            let along = start + t * speed;
            // The mirrored cone behind the tip has negative radii. Ends have their `u` for themselves.
            if (0.0..=1.0).contains(&along) && self.radius + along * self.growth >= 0.0 {
                hit(t, along.clamp(f64::from(f32::MIN_POSITIVE), 1.0 - f64::from(f32::EPSILON) / 2.0));
            }
        };
        let root = b * b - a * c;
        if a == 0.0 {
            side(-c / (2.0 * b));
        } else if root >= 0.0 {
            // Without loss of digits where one root is small.
            let q = -b - root.sqrt().copysign(b);
            side(q / a);
            side(c / q);
        }
        for (end, _) in caps.into_iter().enumerate().filter(|&(_, is_there)| is_there) {
            let t = (end as f64 - start) / speed;
            let at = [0, 1, 2].map(|k| org[k] + t * dir[k] - end as f64 * self.axis[k]);
            let radius = self.radius + end as f64 * self.growth;
            if dot(at, at) <= radius * radius {
                hit(t, end as f64);
            }
        }
    }
}

impl Cones {
    /// From arrays that the program has given.
    pub(crate) fn new(
        steps: Vec<View>,
        times: [f32; 2],
        indices: View,
        flags: View,
        is_culled: bool,
    ) -> Self {
        Self { steps, times, indices, flags, is_culled }
    }

    fn first(&self, prim_id: u32) -> Option<u32> {
        self.indices.number(prim_id as usize, 0)
    }

    fn ends(&self, prim_id: u32, step: usize) -> Option<[[f32; 4]; 2]> {
        let first = self.first(prim_id)? as usize;
        let vertices = self.steps.get(step)?;
        Some([vertices.get(first)?, vertices.get(first.checked_add(1)?)?])
    }

    /// At a time; `None` where vertices are missing.
    fn at(&self, prim_id: u32, time: f32) -> Option<Cone> {
        if self.steps.len() == 1 {
            return self.ends(prim_id, 0).map(Cone::new);
        }
        let [from, to] = self.times;
        let interval =
            KeyInterval::of(if to > from { (time - from) / (to - from) } else { 0.0 }, self.steps.len());
        let (a, b) = (self.ends(prim_id, interval.key)?, self.ends(prim_id, interval.next)?);
        Some(Cone::new(
            [0, 1].map(|end: usize| [0, 1, 2, 3].map(|k: usize| interval.mix(a[end][k], b[end][k]))),
        ))
    }

    /// Which ends have a cap: those without a neighbour, as flags say, or else the next indices.
    fn caps(&self, prim_id: u32) -> [bool; 2] {
        let i = prim_id as usize;
        if let Some(flags) = self.flags.number::<u8>(i, 0) {
            return [flags & 1 == 0, flags & 2 == 0];
        }
        let next = |a: Option<u32>, b: Option<u32>| matches!((a, b), (Some(a), Some(b)) if a.checked_add(1) == Some(b));
        let own = self.first(prim_id);
        let before = prim_id.checked_sub(1).and_then(|before| self.first(before));
        [!next(before, own), !next(own, prim_id.checked_add(1).and_then(|after| self.first(after)))]
    }
}

impl UserGeometry for Cones {
    fn count(&self) -> u32 {
        self.indices.len() as u32
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        self.bounds_at(prim_id, 0)
    }

    fn keys(&self) -> u32 {
        self.steps.len() as u32
    }

    fn bounds_at(&self, prim_id: u32, key: u32) -> Aabb {
        let Some(ends) = self.ends(prim_id, key as usize) else { return Aabb::EMPTY };
        let is_sound = |end: &[f32; 4]| end.iter().all(|x| x.is_finite()) && end[3] >= 0.0;
        if !ends.iter().all(is_sound) {
            return Aabb::EMPTY;
        }
        let axis = Cone::new(ends).axis;
        let square = dot(axis, axis);
        let mut bounds = Aabb::EMPTY;
        for [x, y, z, radius] in ends {
            for (k, middle) in [x, y, z].into_iter().enumerate() {
                // Discs at the ends, of cones that stand; spheres, whose boxes go straight, of those that turn.
                let share = if square > 0.0 && self.steps.len() == 1 {
                    1.0 - axis[k] * axis[k] / square
                } else {
                    1.0
                };
                let reach = (f64::from(radius) * share.max(0.0).sqrt() * (1.0 + 1e-9)) as f32;
                bounds.min[k] = bounds.min[k].min((middle - reach.next_up()).next_down());
                bounds.max[k] = bounds.max[k].max((middle + reach.next_up()).next_up());
            }
        }
        bounds
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let Some(cone) = self.at(prim_id, ray.time) else { return };
        let (org, dir) = (ray.org.map(f64::from), ray.dir.map(f64::from));
        cone.meet(org, dir, self.caps(prim_id), &mut |t, u| {
            let u = u as f32;
            let at = [0, 1, 2].map(|k| org[k] + t * dir[k]);
            if !self.is_culled || dot(cone.normal(u, at), dir) < 0.0 {
                hit(UserHit { t: t as f32, u, v: 0.0 });
            }
        });
    }
}
