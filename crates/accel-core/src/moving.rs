// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres, discs and curves that move while the shutter is open: user geometry whose primitives are interpolated between
//! keys. Vertices, radii and normals go straight, as Embree's do. Space: object.
//! Invariant: the box at a time between two keys, interpolated, holds the interpolated primitive, because all that it is
//! made of goes straight. Tests: `tests/keyed.rs` of `gnurt-accel`.

use std::sync::Arc;

use crate::aabb::Aabb;
use crate::bad_primitives::BadPrimitives;
use crate::curve::{Curves, OwnedCurves, RayFrame, Segment};
use crate::geometry::{Discs, Geometry, Spheres};
use crate::motion::KeyInterval;
use crate::point::{through_disc, through_sphere};
use crate::ray::Ray;
use crate::user::{UserGeometry, UserHit};

/// One kind of primitives at each key.
trait Keyed: Send + Sync + std::fmt::Debug + Sized + 'static {
    /// A primitive between keys.
    type Between;
    fn count(&self) -> usize;
    /// The box at this key; `None` of one that cannot be traced.
    fn bounds(&self, i: usize) -> Option<Aabb>;
    fn between(&self, to: &Self, i: usize, interval: &KeyInterval) -> Option<Self::Between>;
    fn meet(between: &Self::Between, ray: &Ray, hit: &mut dyn FnMut(UserHit));
    fn normal(between: &Self::Between, uv: [f64; 2], point: Option<[f64; 3]>) -> Option<[f64; 3]>;
}

/// Primitives at all keys.
#[derive(Debug)]
struct Keys<K>(Vec<K>);

impl<K: Keyed> Keys<K> {
    fn at(&self, prim_id: u32, time: f32) -> Option<K::Between> {
        let interval = KeyInterval::of(time, self.0.len());
        self.0[interval.key].between(&self.0[interval.next], prim_id as usize, &interval)
    }
}

impl<K: Keyed> UserGeometry for Keys<K> {
    fn count(&self) -> u32 {
        self.0.iter().map(K::count).min().unwrap_or(0) as u32
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        self.bounds_at(prim_id, 0)
    }

    fn keys(&self) -> u32 {
        self.0.len() as u32
    }

    fn bounds_at(&self, prim_id: u32, key: u32) -> Aabb {
        self.0[key as usize].bounds(prim_id as usize).unwrap_or(Aabb::EMPTY)
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        if let Some(between) = self.at(prim_id, ray.time) {
            K::meet(&between, ray, hit);
        }
    }

    fn normal(&self, prim_id: u32, uv: [f32; 2], point: Option<[f64; 3]>, time: f32) -> Option<[f64; 3]> {
        K::normal(&self.at(prim_id, time)?, uv.map(f64::from), point)
    }
}

fn is_sound(floats: impl Iterator<Item = f32> + Clone) -> bool {
    BadPrimitives::default().fault(floats).is_none()
}

/// Centres and radii; those of spheres that are hit from outside only are negative.
#[derive(Debug)]
struct Balls(Vec<([f32; 3], f32)>);

impl Balls {
    fn new(centers: &[[f32; 3]], radii: &[f32]) -> Self {
        // None is negative by accident.
        let radius = |radius: &f32| if *radius > 0.0 { *radius } else { 0.0 };
        Self(centers.iter().copied().zip(radii.iter().map(radius)).collect())
    }

    fn bounds(&self, i: usize) -> Option<Aabb> {
        let (center, radius) = (self.0[i].0, self.0[i].1.abs());
        let side = |sign: f32| center.map(|x| x + sign * radius);
        (radius > 0.0 && is_sound(center.into_iter().chain([radius])))
            .then(|| Aabb { min: side(-1.0).map(f32::next_down), max: side(1.0).map(f32::next_up) })
    }

    fn between(&self, to: &Self, i: usize, interval: &KeyInterval) -> ([f32; 3], f32) {
        let ((from, radius), (to, radius_to)) = (self.0[i], to.0[i]);
        (interval.mix3(from, to), interval.mix(radius, radius_to))
    }
}

impl Keyed for Balls {
    type Between = ([f32; 3], f32);

    fn count(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, i: usize) -> Option<Aabb> {
        Balls::bounds(self, i)
    }

    fn between(&self, to: &Self, i: usize, interval: &KeyInterval) -> Option<Self::Between> {
        Some(Balls::between(self, to, i, interval))
    }

    fn meet(&(center, radius): &Self::Between, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let line = [ray.org.map(f64::from), ray.dir.map(f64::from)];
        // The roots are those of the nearest point of the line where it misses.
        if is_met(line, center.map(f64::from), f64::from(radius)) {
            let sides = if radius > 0.0 { 2 } else { 1 };
            let hits = through_sphere(ray, center, radius.abs()).into_iter().take(sides);
            hits.for_each(|t| hit(UserHit { t, u: 0.0, v: 0.0 }));
        }
    }

    fn normal((center, _): &Self::Between, _: [f64; 2], point: Option<[f64; 3]>) -> Option<[f64; 3]> {
        point.map(|point| [0, 1, 2].map(|k| point[k] - f64::from(center[k])))
    }
}

/// Whether a line comes as near to a point as this.
fn is_met([org, dir]: [[f64; 3]; 2], point: [f64; 3], radius: f64) -> bool {
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let from = [0, 1, 2].map(|k| org[k] - point[k]);
    let share = dot(from, dir) / dot(dir, dir);
    let across = [0, 1, 2].map(|k| from[k] - share * dir[k]);
    dot(across, across) <= radius * radius
}

/// Discs, with normals or facing each ray.
#[derive(Debug)]
struct Plates {
    balls: Balls,
    normals: Option<Vec<[f32; 3]>>,
}

impl Keyed for Plates {
    type Between = ([f32; 3], f32, Option<[f32; 3]>);

    fn count(&self) -> usize {
        self.normals.as_ref().map_or(self.balls.0.len(), |normals| normals.len().min(self.balls.0.len()))
    }

    /// That of the sphere around it: normals turn between keys.
    fn bounds(&self, i: usize) -> Option<Aabb> {
        let is_flat =
            self.normals.as_ref().is_some_and(|all| all[i] == [0.0; 3] || !is_sound(all[i].into_iter()));
        if is_flat { None } else { self.balls.bounds(i) }
    }

    fn between(&self, to: &Self, i: usize, interval: &KeyInterval) -> Option<Self::Between> {
        let (center, radius) = self.balls.between(&to.balls, i, interval);
        let normals = self.normals.as_ref().zip(to.normals.as_ref());
        Some((center, radius, normals.map(|(from, to)| interval.mix3(from[i], to[i]))))
    }

    fn meet(&(center, radius, normal): &Self::Between, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let line = [ray.org.map(f64::from), ray.dir.map(f64::from)];
        if let Some(t) = through_disc(line, center, radius, normal) {
            hit(UserHit { t: t as f32, u: 0.0, v: 0.0 });
        }
    }

    fn normal((_, _, normal): &Self::Between, _: [f64; 2], _: Option<[f64; 3]>) -> Option<[f64; 3]> {
        normal.map(|normal| normal.map(f64::from))
    }
}

impl Keyed for OwnedCurves {
    type Between = Segment;

    fn count(&self) -> usize {
        self.indices.len()
    }

    fn bounds(&self, i: usize) -> Option<Aabb> {
        let segment = self.view().check(i as u32, &mut BadPrimitives::default())?;
        Some(segment.bounds())
    }

    fn between(&self, to: &Self, i: usize, interval: &KeyInterval) -> Option<Segment> {
        let from = self.segment(i as u32)?;
        match interval.weights {
            [_, 0.0] => Some(from),
            weights => Some(from.mixed(&to.segment(i as u32)?, weights.map(f64::from))),
        }
    }

    fn meet(segment: &Segment, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let frame = RayFrame::new(ray.org.map(f64::from), ray.dir.map(f64::from));
        let count = segment.parts();
        for index in 0..count {
            let part = [index, index + 1].map(|i| f64::from(i) / f64::from(count));
            segment.meet(&frame, part, &mut |found| {
                let [t, u, v] = [found.t, found.u, found.v].map(|x| x as f32);
                hit(UserHit { t, u, v });
                true
            });
        }
    }

    fn normal(segment: &Segment, [u, v]: [f64; 2], point: Option<[f64; 3]>) -> Option<[f64; 3]> {
        segment.normal(u, v, point)
    }
}

impl Geometry<'static> {
    fn keyed(keys: Vec<impl Keyed>) -> Self {
        Self::user(Arc::new(Keys(keys)))
    }

    /// Spheres that move while the shutter is open: one list for each time, evenly spaced from 0 to 1. Arrays are copied.
    /// A sphere that is bad at some key is dropped.
    #[must_use]
    pub fn moving_spheres(keys: &[Spheres]) -> Self {
        Self::keyed(keys.iter().map(|key| Balls::new(key.centers, key.radii)).collect())
    }

    /// The same for spheres that rays hit from outside only.
    #[must_use]
    pub fn moving_sphere_outsides(keys: &[Spheres]) -> Self {
        let outside = |key: &Spheres| {
            let Balls(all) = Balls::new(key.centers, key.radii);
            // Bad ones stay bad.
            Balls(all.into_iter().map(|(c, r)| (c, if r > 0.0 { -r } else { 0.0 })).collect())
        };
        Self::keyed(keys.iter().map(outside).collect())
    }

    /// The same for discs.
    #[must_use]
    pub fn moving_discs(keys: &[Discs]) -> Self {
        let plates = |key: &Discs| Plates {
            balls: Balls::new(key.centers, key.radii),
            normals: key.normals.map(<[_]>::to_vec),
        };
        Self::keyed(keys.iter().map(plates).collect())
    }

    /// The same for curves; all lists are of the same basis, form and indices.
    #[must_use]
    pub fn moving_curves(keys: &[Curves]) -> Self {
        Self::keyed(keys.iter().map(OwnedCurves::new).collect())
    }
}
