// SPDX-License-Identifier: GPL-3.0-or-later
//! The shapes that emit, one at a time: triangles to the side of their normal, spheres outwards.
//! Source: see `light_estimates` and `sphere`. Space: world.
//! Invariant: a place on a shape is a pair: the weights of a triangle's second and third corner, or the normal on a
//! sphere as `octahedron` has it.
//! Tests: `area`, `sphere`, `light_set_tests`.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::beam::{Beam, cell};
use super::light_estimates::{Aim, TriangleAt};
use super::light_tree::LightBounds;
use super::sphere::SphereAt;
use crate::real::{Real, Vector};
use crate::sampling::octahedron::{direction_of, square_of};
use crate::sampling::{self, uniform_sphere};

/// What an emissive shape is, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// Corners, counter-clockwise seen from the emitting side.
    Triangle([Vec3; 3]),
    /// It emits outwards.
    Sphere {
        /// Its middle.
        center: Vec3,
        /// Above 0.
        radius: f32,
    },
}

/// A shape as choices see it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// The corners; the centre of a sphere, three times.
    pub(super) p: [Vec3; 3],
    /// Unit, on the emitting side; zero of a sphere.
    pub(super) normal: Vec3,
    /// The area of a triangle, or minus the radius of a sphere.
    pub(super) extent: f32,
    /// The brightest intensity: brightness times the area seen from its normal.
    pub(super) power: f32,
}

/// The same of one shape, or of sixteen.
#[derive(Clone, Copy)]
pub(super) struct ShapeAt<R: Real> {
    pub(super) corners: [Vector<R>; 3],
    pub(super) normal: Vector<R>,
    pub(super) extent: R,
    pub(super) power: R,
}

impl Outline {
    /// World units squared.
    #[must_use]
    pub fn area(&self) -> f64 {
        match self {
            Self::Triangle(p) => 0.5 * across(p).length(),
            Self::Sphere { radius, .. } => 4.0 * std::f64::consts::PI * f64::from(*radius).powi(2),
        }
    }

    /// A place by two numbers in [0, 1), uniform by area.
    #[must_use]
    pub fn place(&self, u: [f32; 2]) -> [f32; 2] {
        match self {
            Self::Triangle(_) => sampling::triangle(u),
            Self::Sphere { .. } => square_of(Vector::from(uniform_sphere(u))),
        }
    }

    /// The unit normal of a place; zero of triangles without area.
    #[must_use]
    pub fn normal_at(&self, place: [f32; 2]) -> Vec3 {
        match self {
            Self::Triangle([a, b, c]) => (b - a).cross(c - a).normalize_or_zero(),
            Self::Sphere { .. } => direction_of(place),
        }
    }

    /// The point of a place.
    #[must_use]
    pub fn point(&self, place: [f32; 2]) -> Vec3 {
        match *self {
            Self::Triangle([a, b, c]) => a + (b - a) * place[0] + (c - a) * place[1],
            Self::Sphere { center, radius } => center + direction_of(place) * radius,
        }
    }
}

/// A normal of a triangle as long as twice its area.
fn across(p: &[Vec3; 3]) -> DVec3 {
    let p = p.map(Vec3::as_dvec3);
    (p[1] - p[0]).cross(p[2] - p[0])
}

impl Shape {
    /// `brightness`: that of its mean radiance.
    pub(super) fn new(outline: &Outline, brightness: f32) -> Self {
        match *outline {
            Outline::Triangle(corners) => {
                let area = outline.area() as f32;
                let normal = across(&corners).normalize_or_zero().as_vec3();
                Self { p: corners, normal, extent: area, power: area * brightness }
            }
            Outline::Sphere { center, radius } => {
                let power = PI * radius * radius * brightness;
                Self { p: [center; 3], normal: Vec3::ZERO, extent: -radius, power }
            }
        }
    }

    fn radius(&self) -> Option<f32> {
        (self.extent < 0.0).then_some(-self.extent)
    }

    fn outline(&self) -> Outline {
        self.radius()
            .map_or(Outline::Triangle(self.p), |radius| Outline::Sphere { center: self.p[0], radius })
    }

    /// The same as choices see it.
    pub(super) fn seen(&self) -> ShapeAt<f32> {
        let Self { p: [a, b, c], normal, extent, power } = *self;
        ShapeAt { corners: [a.into(), b.into(), c.into()], normal: normal.into(), extent, power }
    }

    /// Its numbers in a row: corners, normal, extent.
    pub(super) fn row(&self) -> [f32; 13] {
        let mut row = [self.extent; 13];
        let vectors = self.p.into_iter().chain([self.normal]);
        row.chunks_exact_mut(3).zip(vectors).for_each(|(out, v)| out.copy_from_slice(&v.to_array()));
        row
    }

    /// As [`ShapeAt::contribution`]; a zero `normal` has no horizon.
    pub(super) fn contribution(&self, p: Vec3, normal: Vec3) -> f32 {
        self.seen().contribution(p.into(), (normal != Vec3::ZERO).then(|| normal.into()))
    }

    pub(super) fn area(&self) -> f32 {
        self.radius().map_or(self.extent, |radius| 4.0 * PI * radius * radius)
    }

    /// By brightness: its light in all directions, W.
    pub(super) fn watts(&self) -> f64 {
        let of_intensity = f64::from(PI) * f64::from(self.power);
        if self.extent < 0.0 { 4.0 * of_intensity } else { of_intensity }
    }

    pub(super) fn bounds(&self, beam: Option<&Beam>) -> LightBounds {
        let Self { p: [a, b, c], normal, extent, power } = *self;
        // Spheres face all sides.
        let is_sphere = extent < 0.0;
        let (size, axis, cos_normals) = if is_sphere { (-extent, Vec3::Z, -1.0) } else { (0.0, normal, 1.0) };
        let bounds = LightBounds {
            min: a.min(b).min(c) - size,
            max: a.max(b).max(c) + size,
            axis,
            cos_normals,
            cos_emission: 0.0,
            // The mean cosine of all normals is a quarter.
            power: if is_sphere { 4.0 * power } else { power },
        };
        // As if all its light left along normals within the cone.
        beam.map_or(bounds, |beam| {
            let (axis, cos_normals) = beam.cone();
            LightBounds { axis, cos_normals, cos_emission: 1.0, power: power * beam.peak(), ..bounds }
        })
    }

    /// A place by two numbers in [0, 1), uniform by area.
    pub(super) fn place(&self, u: [f32; 2]) -> [f32; 2] {
        self.outline().place(u)
    }

    /// The point whose distance its light goes by: the middle of a sphere, else a place by two numbers in [0, 1).
    pub(super) fn origin(&self, u: [f32; 2]) -> Vec3 {
        self.radius().map_or_else(|| self.point(self.place(u)), |_| self.p[0])
    }

    /// The place on a sphere of a point near it.
    pub(super) fn place_of(&self, p: Vec3) -> Option<[f32; 2]> {
        let normal = (p - self.p[0]).normalize_or(Vec3::Z);
        self.radius().map(|_| square_of(Vector::from(normal)))
    }

    /// The unit normal of a place.
    pub(super) fn normal_at(&self, place: [f32; 2]) -> Vec3 {
        if self.extent < 0.0 { direction_of(place) } else { self.normal }
    }

    /// The point of a place.
    pub(super) fn point(&self, place: [f32; 2]) -> Vec3 {
        self.outline().point(place)
    }

    /// The same, but short of the shape by its rounding error, so that it does not shadow itself.
    pub(super) fn nearest_image(&self, p: Vec3, place: [f32; 2]) -> Vec3 {
        self.point(place) + self.normal_at(place) * self.rounding(p)
    }

    /// How far a point computed on the shape and seen from `p` may be off, and some more.
    pub(super) fn rounding(&self, p: Vec3) -> f32 {
        let largest = self.p.iter().fold(p.abs().max_element(), |m, q| m.max(q.abs().max_element()));
        16.0 * f32::EPSILON * (largest - self.extent.min(0.0))
    }
}

impl<R: Real> ShapeAt<R> {
    #[inline(always)]
    fn triangle(&self) -> TriangleAt<R> {
        let Self { corners, normal, extent, power } = *self;
        TriangleAt { corners, normal, area: extent, power }
    }

    #[inline(always)]
    fn sphere(&self) -> SphereAt<R> {
        SphereAt { center: self.corners[0], radius: -self.extent, power: self.power }
    }

    /// Which are spheres.
    #[inline(always)]
    fn spheres(&self) -> R::Mask {
        self.extent.all(0.0).above(self.extent)
    }

    /// Approximate unoccluded contribution to surfaces at `p`; exactly 0 where there is none: seen from
    /// behind, or wholly below the horizon of `normal`. Points without normals have no horizon.
    #[inline(always)]
    pub(super) fn contribution(&self, p: Vector<R>, normal: Option<Vector<R>>) -> R {
        let (spheres, of_triangle) = (self.spheres(), self.triangle().contribution(p, normal));
        if !R::any(spheres) {
            return of_triangle;
        }
        R::pick(spheres, self.sphere().contribution(p, normal), of_triangle)
    }

    /// The cells of a [`Beam`] in which its corners and its middle see `p`.
    #[inline(always)]
    pub(super) fn cells(&self, p: Vector<R>) -> [R; 4] {
        let [a, b, c] = self.corners;
        let middle = (a + b + c).over(p.x.all(3.0));
        [cell(p - a), cell(p - b), cell(p - c), cell(p - middle)]
    }

    /// A point of it for two numbers in [0, 1), seen from `p`, for the points in `there`: of spheres and of near, large triangles
    /// uniform by solid angle; else by area.
    #[inline(always)]
    pub(super) fn aim(&self, p: Vector<R>, u: [R; 2], there: R::Mask) -> Aim<R> {
        let (spheres, of_triangle) = (self.spheres(), self.triangle().aim(p, u, there));
        if !R::any(spheres) {
            return of_triangle;
        }
        self.sphere().aim(p, u).or(spheres, of_triangle)
    }

    /// Density per solid angle at `p` of the point that lies along the unit `dir`, `dist` away; 0 from the dark side.
    #[inline(always)]
    pub(super) fn density(&self, p: Vector<R>, dir: Vector<R>, dist: R) -> R {
        let spheres = self.spheres();
        let of_triangle = self.triangle().density(p, dir, dist);
        if !R::any(spheres) {
            return of_triangle;
        }
        R::pick(spheres, self.sphere().density(p, dir, dist), of_triangle)
    }
}
