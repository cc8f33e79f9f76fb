// SPDX-License-Identifier: GPL-3.0-or-later
//! Sends a hundred million rays at the vertices and edges of closed meshes from inside, near the origin and a
//! million units away, in every kind of query, and counts those that leave. Run: `cargo run --release -p
//! gnurt-accel --example leaks [RAYS]`
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, Coherence, HitBatch, Instance, Memory, ObjectTree, Quality, Query, Ray, RayBatch, Record,
    SceneTree, Structure, Threads, Triangles,
};
use gnurt_testkit::{Random, Soup, closed, rays};

/// The tree to build.
type Kind = (Structure, Quality, Memory);

/// Closed meshes with the radius of a ball that is inside.
fn meshes() -> [(&'static str, Soup, f32); 3] {
    [
        ("sphere", closed::sphere(24), 0.7),
        ("cube", closed::cube(6), 0.9),
        ("plain cube", closed::cube(1), 0.9),
    ]
}

/// Every kind of query, as a scene `distance` units away along each axis; instances are moved by their
/// transform, so that the test covers the transform of rays.
fn scene(mesh: &Soup, (structure, quality, memory): Kind, distance: f64) -> SceneTree {
    let triangles = [Triangles { positions: &mesh.positions, indices: &mesh.indices }];
    let options = BuildOptions { structure, quality, memory, ..BuildOptions::default() };
    let mut instance = Instance::identity(Arc::new(ObjectTree::build(&triangles, &options, Threads::Single)));
    instance.world_from_object[3] = [distance, -distance, distance];
    SceneTree::build(&[instance], &BuildOptions::default(), Threads::Single)
}

fn main() -> Result<(), String> {
    let requested: u64 = match std::env::args().nth(1) {
        Some(text) => text.parse().map_err(|_| format!("'{text}' is not a number of rays"))?,
        None => 100_000_000,
    };
    let kinds = [
        (Structure::Bvh, Quality::Medium, Memory::Fast),
        (Structure::Bvh, Quality::High, Memory::Fast),
        (Structure::Bvh, Quality::Medium, Memory::Compact),
        (Structure::Kd, Quality::Medium, Memory::Fast),
    ];
    let paths = [Coherence::Coherent, Coherence::Fanned, Coherence::Incoherent];
    let mut random = Random::new(1);
    let (mut sent, mut leaks) = (0u64, 0u64);
    let mut hits = HitBatch::default();
    'all: loop {
        for (name, mesh, radius) in meshes() {
            for distance in [0.0f64, 1e6] {
                for kind in kinds {
                    let scene = scene(&mesh, kind, distance);
                    for coherence in paths {
                        let from = random.point().map(|x| 0.5 * radius * x);
                        let shift = [distance, -distance, distance];
                        // Far away floats are coarse: the origin and the visible points are rounded.
                        let org = [0, 1, 2].map(|k| (f64::from(from[k]) + shift[k]) as f32);
                        let visible_from = [0, 1, 2].map(|k| (f64::from(org[k]) - shift[k]) as f32);
                        let batch: RayBatch = rays::aimed(&mesh, visible_from, 4)
                            .into_iter()
                            .map(|(_, dir)| Ray::new(org, dir))
                            .collect();
                        let query = Query { coherence, ..Query::default() };
                        scene.intersect_batch(&query, &batch, &mut hits, &mut Record::default());
                        let missed = (0..hits.len()).filter(|&i| hits.get(i).is_none()).count() as u64;
                        if missed > 0 {
                            println!("{missed} leaks: {name}, {kind:?}, {coherence:?}, {distance}");
                        }
                        leaks += missed;
                        sent += batch.len() as u64;
                        if sent >= requested {
                            break 'all;
                        }
                    }
                }
            }
        }
    }
    println!("{sent} rays, {leaks} leaks");
    if leaks == 0 { Ok(()) } else { Err("rays got out".into()) }
}
