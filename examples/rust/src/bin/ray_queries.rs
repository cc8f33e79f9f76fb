// SPDX-License-Identifier: GPL-3.0-or-later
//! Ray queries without pictures: closest hits, shadows, all hits, batches and instances.
//!
//! `cargo run --release -p gnurt-examples --bin ray_queries`

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, HitBatch, Instance, ObjectTree, Query, Ray, RayBatch, Record, SceneTree, Spheres, Threads,
    Triangles,
};

fn main() {
    // An object: a floor of two triangles and a sphere above it.
    let corners = [[-2.0, 0.0, -2.0], [2.5, 0.0, -2.0], [2.5, 0.0, 2.0], [-2.0, 0.0, 2.0]];
    let floor = Triangles { positions: &corners, indices: &[[0, 2, 1], [0, 3, 2]] };
    let sphere = Spheres { centers: &[[0.0, 1.0, 0.0]], radii: &[0.5] };
    let options = BuildOptions::default();
    let object = ObjectTree::build_from(&[floor.into(), sphere.into()], &options, Threads::Single);

    // The closest hit; `t` counts lengths of the ray's direction.
    let down = Ray::new([0.0, 3.0, 0.0], [0.0, -1.0, 0.0]);
    let hit = object.intersect(&down).expect("the sphere is below");
    println!("closest hit: t {}, geometry {}, primitive {}", hit.t, hit.geom_id, hit.prim_id);

    // A shadow ray between 0 and 1.4 ends above the sphere.
    println!("blocked within 1.4: {}", object.occluded(&down.within(0.0, 1.4)));

    // All hits along the ray, sorted.
    let mut hits = Vec::new();
    object.all_hits(&Query::default(), &down, &mut hits);
    println!("all hits: {:?}", hits.iter().map(|hit| hit.t).collect::<Vec<_>>());

    // Two instances of the object, four units apart.
    let at = |x: f64| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 0.0]];
    let object = Arc::new(object);
    let instances = [Instance::new(object.clone(), at(0.0)), Instance::new(object, at(4.0))];
    let scene = SceneTree::build(&instances, &options, Threads::Single);

    // Many rays in one call.
    let rays: RayBatch = (0..8).map(|i| Ray::new([i as f32, 3.0, 0.0], [0.0, -1.0, 0.0])).collect();
    let (mut batch, mut record) = (HitBatch::default(), Record::default());
    scene.intersect_batch(&Query::default(), &rays, &mut batch, &mut record);
    for i in 0..rays.len() {
        match batch.get(i) {
            Some(hit) => println!("ray {i}: t {}, instance {}", hit.t, hit.inst_id),
            None => println!("ray {i}: miss"),
        }
    }
}
