// SPDX-License-Identifier: GPL-3.0-or-later
//! The classes of a renderer's rays, from the most coherent to the least. The classes are those of
//! docs/how-to/measure.md; cosine-weighted directions are textbook [PJH23].
//! Space: world; directions of unit length, but those of shadow rays reach from the surface (t = 0) to the light (t = 1).
//! Invariants: the same scene, size and seed give the same rays; secondary rays start off the surface, on the
//! side of the primary ray. Tests: `tests`.

use std::fmt;

use gnurt::accel::{HitBatch, ObjectTree, Query, Ray, RayBatch, Record};
use gnurt::simd::Level;

use crate::random::Random;
use crate::vector::{V3, along, basis, cross, dot, minus, unit};
use crate::{Error, Subject};

/// The kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Through pixel centres, in tiles of 8 x 8, in Morton order within a tile. Closest hit.
    Primary,
    /// From every primary hit to one point light. Any hit.
    Shadow,
    /// Eight cosine-distributed rays from every primary hit, a tenth of the scene's diagonal long. Any hit.
    Ao,
    /// One cosine-distributed ray from every primary hit, in the order of the hits. Closest hit.
    Diffuse,
    /// The same rays in random order.
    Shuffled,
}

impl Class {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Primary, Self::Shadow, Self::Ao, Self::Diffuse, Self::Shuffled];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Ao => "ao",
            Self::Diffuse => "diffuse",
            Self::Shuffled => "shuffled",
        }
    }

    /// Whether any hit will do.
    #[must_use]
    pub fn is_any_hit(self) -> bool {
        matches!(self, Self::Shadow | Self::Ao)
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Side of a tile in pixels.
const TILE: u32 = 8;
/// Rays of ambient occlusion per hit.
const AO_RAYS: usize = 8;
/// Their length in diagonals of the scene.
const AO_LENGTH: f32 = 0.1;
/// How far off the surface secondary rays start, in diagonals of the scene.
const OFFSET: f32 = 1e-5;

/// A point on a surface that a primary ray sees.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Off the surface.
    at: V3,
    /// Of the side that is seen; unit length.
    normal: V3,
}

/// Makes rays of all classes for one subject.
pub(crate) struct RayMaker<'a> {
    subject: &'a Subject,
    primary: Vec<Ray>,
    points: Vec<Point>,
}

impl<'a> RayMaker<'a> {
    /// `size` x `size` primary rays, and the points that they see according to `tree`.
    pub(crate) fn new(
        subject: &'a Subject,
        size: u32,
        tree: &ObjectTree,
        level: Level,
    ) -> Result<Self, Error> {
        let primary = primary_rays(subject, size).ok_or_else(|| Error::Scene {
            scene: subject.name.clone(),
            why: "its camera has no view".into(),
        })?;
        let query = Query { level, ..Query::default() };
        let mut hits = HitBatch::default();
        tree.intersect_batch(&query, &primary.iter().copied().collect(), &mut hits, &mut Record::default());
        let visible = (0..hits.len()).filter_map(|i| hits.get(i).map(|hit| (primary[i], hit)));
        let points = visible.map(|(ray, hit)| point(subject, &ray, hit.t, hit.prim_id)).collect();
        Ok(Self { subject, primary, points })
    }

    /// The rays of a class, in batches of `batch`.
    pub(crate) fn rays(&self, class: Class, batch: usize) -> Vec<RayBatch> {
        let rays = match class {
            Class::Primary => self.primary.clone(),
            Class::Shadow => self.shadow(),
            Class::Ao => self.hemisphere(AO_RAYS, AO_LENGTH * self.subject.diagonal),
            Class::Diffuse => self.hemisphere(1, f32::INFINITY),
            Class::Shuffled => {
                let mut rays = self.hemisphere(1, f32::INFINITY);
                Random::new(2).shuffle(&mut rays);
                rays
            }
        };
        rays.chunks(batch).map(|chunk| chunk.iter().copied().collect()).collect()
    }

    fn shadow(&self) -> Vec<Ray> {
        let light = self.subject.light;
        let to_light = |point: &Point| Ray::new(point.at, minus(light, point.at)).within(0.0, 1.0);
        self.points.iter().map(to_light).collect()
    }

    /// `count` cosine-distributed rays from each point.
    fn hemisphere(&self, count: usize, t_far: f32) -> Vec<Ray> {
        let mut random = Random::new(1);
        let each = self.points.iter().flat_map(|point| std::iter::repeat_n(point, count));
        each.map(|point| {
            let dir = cosine_direction(point.normal, random.unit(), random.unit());
            Ray::new(point.at, dir).within(0.0, t_far)
        })
        .collect()
    }
}

/// Through pixel centres, tile by tile; `None` if the camera has no view.
fn primary_rays(subject: &Subject, size: u32) -> Option<Vec<Ray>> {
    let (camera, frame) = (&subject.camera, subject.camera.frame()?);
    let half = (camera.fov_y.to_radians() / 2.0).tan();
    let mut rays = Vec::with_capacity((size * size) as usize);
    let tiles = size.div_ceil(TILE);
    for tile in 0..tiles * tiles {
        let (left, top) = (tile % tiles * TILE, tile / tiles * TILE);
        for position in 0..TILE * TILE {
            let (x, y) = (left + even_bits(position), top + even_bits(position >> 1));
            if x < size && y < size {
                let sx = half * (2.0 * (x as f32 + 0.5) / size as f32 - 1.0);
                let sy = half * (1.0 - 2.0 * (y as f32 + 0.5) / size as f32);
                let dir = along(along(frame.forward, sx, frame.right), sy, frame.up);
                rays.push(Ray::new(camera.eye, unit(dir)));
            }
        }
    }
    Some(rays)
}

/// Bits 0, 2 and 4, side by side.
fn even_bits(position: u32) -> u32 {
    position & 1 | position >> 1 & 2 | position >> 2 & 4
}

/// Where a ray sees triangle `prim_id` at `t`.
fn point(subject: &Subject, ray: &Ray, t: f32, prim_id: u32) -> Point {
    let triangles = subject.triangles();
    let [a, b, c] = triangles.indices[prim_id as usize].map(|i| triangles.positions[i as usize]);
    let normal = unit(cross(minus(b, a), minus(c, a)));
    let normal = if dot(normal, ray.dir) > 0.0 { normal.map(|x| -x) } else { normal };
    Point { at: along(ray.at(t), OFFSET * subject.diagonal, normal), normal }
}

/// Cosine-distributed about a unit vector.
fn cosine_direction(normal: V3, u1: f32, u2: f32) -> V3 {
    let (radius, angle) = (u1.sqrt(), std::f32::consts::TAU * u2);
    let [a, b] = basis(normal);
    let up = (1.0 - u1).max(0.0).sqrt();
    unit(along(along(normal.map(|x| up * x), radius * angle.cos(), a), radius * angle.sin(), b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::accel::{BuildOptions, Threads};

    fn box_subject() -> Subject {
        let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        Subject::new("cornell", &scene)
    }

    #[test]
    fn tiles_hold_each_pixel_once() {
        let subject = box_subject();
        for size in [8, 13, 32] {
            let rays = primary_rays(&subject, size).expect("a view");
            assert_eq!(rays.len(), (size * size) as usize, "one ray per pixel of {size}");
            let mut visible: Vec<_> = rays.iter().map(|ray| ray.dir.map(f32::to_bits)).collect();
            visible.sort_unstable();
            visible.dedup();
            assert_eq!(visible.len(), rays.len(), "no direction twice");
        }
        // The first four of a tile are a square.
        let rays = primary_rays(&subject, 8).expect("a view");
        let between = |i: usize, j: usize| minus(rays[i].dir, rays[j].dir).map(f32::abs).iter().sum::<f32>();
        assert!(between(0, 3) < between(0, 9), "Morton order keeps neighbours together");
    }

    #[test]
    fn secondary_rays_start_where_primary_ones_end() {
        let subject = box_subject();
        let tree = ObjectTree::build(&[subject.triangles()], &BuildOptions::default(), Threads::Single);
        let maker = RayMaker::new(&subject, 32, &tree, Level::best()).expect("a view");
        let count = |class| maker.rays(class, 100).iter().map(RayBatch::len).sum::<usize>();
        let hits = maker.points.len();
        assert!(hits > 900, "the box fills the view: {hits} hits");
        let counts = Class::ALL.map(count);
        assert_eq!(counts, [1024, hits, 8 * hits, hits, hits], "rays of each class");
        let shadow = &maker.rays(Class::Shadow, 5000)[0];
        let lit = (0..hits).filter(|&i| !tree.occluded(&shadow.get(i))).count();
        assert!(lit > hits / 10, "some points see the light: {lit} of {hits}");
        let diffuse = &maker.rays(Class::Diffuse, 5000)[0];
        let mean = (0..hits).map(|i| f64::from(dot(diffuse.get(i).dir, maker.points[i].normal))).sum::<f64>()
            / hits as f64;
        assert!((mean - 2.0 / 3.0).abs() < 0.03, "the mean cosine is {mean}, not 2/3");
    }
}
