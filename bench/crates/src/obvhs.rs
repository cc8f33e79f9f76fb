// SPDX-License-Identifier: GPL-3.0-or-later
//! obvhs: compressed wide BVHs (CWBVH), after its own example. Source: its documentation.

use std::time::Duration;

use glam::Vec3A;
use gnurt::accel::Ray;
use gnurt_bench::{Contestant, Subject};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;

use crate::one_by_one::{ISA, OneByOne, Tracer, corners};

struct Tree {
    bvh: CwBvh,
    /// In the order of the leaves, which saves an access to a table.
    triangles: Vec<Triangle>,
}

impl Tree {
    fn new(subject: &Subject, settings: BvhBuildParams) -> Self {
        let triangle = |[a, b, c]: [[f32; 3]; 3]| Triangle {
            v0: Vec3A::from_array(a),
            v1: Vec3A::from_array(b),
            v2: Vec3A::from_array(c),
        };
        let triangles: Vec<Triangle> = corners(subject).map(triangle).collect();
        let bvh = build_cwbvh_from_tris(&triangles, settings, &mut Duration::default());
        let triangles = bvh.primitive_indices.iter().map(|&i| triangles[i as usize]).collect();
        Self { bvh, triangles }
    }
}

fn translated(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(Vec3A::from_array(ray.org), Vec3A::from_array(ray.dir), ray.t_near, ray.t_far)
}

impl Tracer for Tree {
    fn closest(&self, ray: &Ray) -> f32 {
        let mut hit = RayHit::none();
        self.bvh.ray_traverse(translated(ray), &mut hit, |ray, id| self.triangles[id].intersect(ray));
        hit.t
    }

    fn any(&self, ray: &Ray) -> bool {
        !self.bvh.ray_traverse_miss(translated(ray), |ray, id| self.triangles[id].intersect(ray))
    }
}

/// Two of its presets.
pub(crate) fn contestants(subject: &Subject) -> [Contestant<'static>; 2] {
    let presets =
        [("cwbvh-medium", BvhBuildParams::medium_build()), ("cwbvh-slow", BvhBuildParams::very_slow_build())];
    presets.map(|(mode, settings)| Contestant {
        engine: "obvhs",
        mode: mode.into(),
        isa: ISA,
        tracer: Box::new(OneByOne(Tree::new(subject, settings))),
    })
}
