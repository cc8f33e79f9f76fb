// SPDX-License-Identifier: GPL-3.0-or-later
//! parry3d: a triangle mesh of a physics library. Source: its documentation.

use gnurt::accel::Ray;
use gnurt_bench::{Contestant, Subject};
use parry3d::math::Vector;
use parry3d::query::RayCast;
use parry3d::shape::TriMesh;

use crate::one_by_one::{ISA, OneByOne, Tracer};

struct Mesh(TriMesh);

fn vector([x, y, z]: [f32; 3]) -> Vector {
    Vector::new(x, y, z)
}

impl Mesh {
    fn cast(&self, ray: &Ray) -> Option<f32> {
        let translated = parry3d::query::Ray::new(vector(ray.org), vector(ray.dir));
        self.0.cast_local_ray(&translated, ray.t_far.min(f32::MAX), false)
    }
}

impl Tracer for Mesh {
    fn closest(&self, ray: &Ray) -> f32 {
        self.cast(ray).unwrap_or(f32::INFINITY)
    }

    /// It has no query for any hit.
    fn any(&self, ray: &Ray) -> bool {
        self.cast(ray).is_some()
    }
}

/// Its only way to build.
pub(crate) fn contestant(subject: &Subject) -> Contestant<'static> {
    let triangles = subject.triangles();
    let positions = triangles.positions.iter().copied().map(vector).collect();
    // The maker of rays rejects a scene without triangles, for every engine.
    let mesh = TriMesh::new(positions, triangles.indices.to_vec()).expect("a mesh has triangles");
    Contestant { engine: "parry3d", mode: "trimesh".into(), isa: ISA, tracer: Box::new(OneByOne(Mesh(mesh))) }
}
