// SPDX-License-Identifier: GPL-3.0-or-later
//! bvh: gives the triangles whose boxes a ray meets; the test of triangles is ours, for its own culls back faces.
//! Source: its documentation; the test is that of [MT97]. Its iterators know no end of a ray, so they give all.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use gnurt::accel::Ray;
use gnurt_bench::{Contestant, Subject};
use nalgebra::{Point3, Vector3};

use crate::one_by_one::{ISA, OneByOne, Tracer, corners};

struct Shape {
    a: Point3<f32>,
    b: Point3<f32>,
    c: Point3<f32>,
    node: usize,
}

impl Shape {
    /// `t` of the hit within the ray, infinite for a miss.
    fn meet(&self, ray: &Ray) -> f32 {
        let (org, dir) = (Point3::from(ray.org), Vector3::from(ray.dir));
        let (ab, ac) = (self.b - self.a, self.c - self.a);
        let across = dir.cross(&ac);
        let inverse = 1.0 / ab.dot(&across);
        let offset = org - self.a;
        let u = offset.dot(&across) * inverse;
        let around = offset.cross(&ab);
        let v = dir.dot(&around) * inverse;
        let t = ac.dot(&around) * inverse;
        // Every comparison is false for a NaN: a ray in the plane misses.
        let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray.t_near && t <= ray.t_far;
        if is_hit { t } else { f32::INFINITY }
    }
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        Aabb::with_bounds(self.a.inf(&self.b).inf(&self.c), self.a.sup(&self.b).sup(&self.c))
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

struct Tree {
    bvh: Bvh<f32, 3>,
    shapes: Vec<Shape>,
}

fn translated(ray: &Ray) -> bvh::ray::Ray<f32, 3> {
    bvh::ray::Ray::new(Point3::from(ray.org), Vector3::from(ray.dir))
}

impl Tracer for Tree {
    fn closest(&self, ray: &Ray) -> f32 {
        let query = translated(ray);
        let candidates = self.bvh.traverse_iterator(&query, &self.shapes);
        candidates.map(|shape| shape.meet(ray)).fold(f32::INFINITY, f32::min)
    }

    fn any(&self, ray: &Ray) -> bool {
        let query = translated(ray);
        self.bvh.traverse_iterator(&query, &self.shapes).any(|shape| shape.meet(ray).is_finite())
    }
}

/// Its only way to build.
pub(crate) fn contestant(subject: &Subject) -> Contestant<'static> {
    let shape = |[a, b, c]: [[f32; 3]; 3]| Shape { a: a.into(), b: b.into(), c: c.into(), node: 0 };
    let mut shapes: Vec<Shape> = corners(subject).map(shape).collect();
    let bvh = Bvh::build(&mut shapes);
    let tracer = Box::new(OneByOne(Tree { bvh, shapes }));
    Contestant { engine: "bvh", mode: "binary".into(), isa: ISA, tracer }
}
