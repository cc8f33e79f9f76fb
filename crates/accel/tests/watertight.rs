// SPDX-License-Identifier: GPL-3.0-or-later
//! No ray leaves a closed mesh: aimed at vertices and edges, near the origin and far from it, moved as an instance and
//! in the mesh itself.

use std::sync::Arc;

use crate::common::{WATERTIGHT, batch, build, run_queries, scene_of};
use gnurt_accel::Instance;
use gnurt_testkit::{Soup, closed, rays};

/// Closed meshes, each with points that are well inside.
fn meshes() -> [(&'static str, Soup, Vec<[f32; 3]>); 4] {
    [
        ("sphere", closed::sphere(12), vec![[0.0; 3], [0.3, 0.1, -0.5]]),
        ("torus", closed::torus(14), vec![[1.0, 0.0, 0.0], [0.0, -1.05, 0.1]]),
        ("cube", closed::cube(4), vec![[0.0; 3], [0.5, 0.5, 0.5], [0.25, -0.5, 0.125]]),
        ("plain cube", closed::cube(1), vec![[0.0; 3], [0.5, 0.0, 0.0]]),
    ]
}

#[test]
fn nothing_leaks_near_the_origin() {
    for kind in WATERTIGHT {
        for (name, mesh, inside) in meshes() {
            let object = build(std::slice::from_ref(&mesh), kind);
            for from in inside {
                let rays = batch(&rays::aimed(&mesh, from, 2));
                let leaks = run_queries(&object, &rays).iter().filter(|hit| hit.is_none()).count();
                assert_eq!(leaks, 0, "of {} rays from {from:?} in the {name}", rays.len());
            }
        }
    }
}

#[test]
fn nothing_leaks_far_away_in_the_mesh() {
    for kind in WATERTIGHT {
        for (distance, size) in [(1e3f32, 1.0f32), (1e6, 64.0)] {
            let offset = [distance, -distance, 0.5 * distance];
            for (name, mut mesh, inside) in meshes() {
                mesh.positions.iter_mut().flatten().for_each(|x| *x *= size);
                let mesh = mesh.moved(offset);
                let object = build(std::slice::from_ref(&mesh), kind);
                for from in inside {
                    let from = [0, 1, 2].map(|k| size * from[k] + offset[k]);
                    let rays = batch(&rays::aimed(&mesh, from, 1));
                    let leaks = run_queries(&object, &rays).iter().filter(|hit| hit.is_none()).count();
                    assert_eq!(leaks, 0, "of {} rays from {from:?} in the {name}", rays.len());
                }
            }
        }
    }
}

#[test]
fn nothing_leaks_far_away_as_an_instance() {
    for kind in WATERTIGHT {
        for distance in [1e3, 1e6] {
            let world_from_object =
                [[0.6, 0.8, 0.0], [-1.6, 1.2, 0.0], [0.0, 0.0, 1.5], [distance, -distance, 0.5 * distance]];
            for (name, mesh, inside) in meshes() {
                let object = Arc::new(build(std::slice::from_ref(&mesh), kind));
                let scene = scene_of(&[Instance::new(object, world_from_object)]);
                let carry = |p: [f32; 3], w: f64| {
                    let p = p.map(f64::from);
                    let m = &world_from_object;
                    [0, 1, 2].map(|k| (m[0][k] * p[0] + m[1][k] * p[1] + m[2][k] * p[2] + w * m[3][k]) as f32)
                };
                for from in inside {
                    let plain = rays::aimed(&mesh, from, 1);
                    let world: Vec<_> =
                        plain.into_iter().map(|(org, dir)| (carry(org, 1.0), carry(dir, 0.0))).collect();
                    let leaks =
                        run_queries(&scene, &batch(&world)).iter().filter(|hit| hit.is_none()).count();
                    assert_eq!(
                        leaks,
                        0,
                        "of {} rays from {from:?} in the {name}, {distance} away",
                        world.len()
                    );
                }
            }
        }
    }
}
