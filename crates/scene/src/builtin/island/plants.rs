// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees and rocks, a few kinds each, one unit high, to be instanced.
//! Space: object, the foot at the origin, +Y up.

use super::super::noise::{hash, value};
use super::super::shapes::{append, lathe, moved, sphere, transformed};
use crate::affine::Affine;
use crate::id::{MaterialId, ObjectId};
use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Kinds of each.
const KINDS: i32 = 4;

/// Meshes and their materials.
type Parts = Vec<(Mesh, MaterialId)>;

/// Objects to instance.
pub(super) struct Objects {
    pub(super) conifers: Vec<ObjectId>,
    pub(super) broadleaf: Vec<ObjectId>,
    pub(super) rocks: Vec<ObjectId>,
}

pub(super) fn add_objects(scene: &mut Scene) -> Objects {
    let bark = scene.add_material(Material::matte("bark", [0.10, 0.065, 0.04]));
    let stone = scene.add_material(Material::matte("stone", [0.27, 0.245, 0.22]));
    let needles =
        [[0.028, 0.062, 0.026], [0.040, 0.080, 0.030], [0.034, 0.070, 0.036], [0.052, 0.088, 0.028]];
    let leaves = [[0.085, 0.125, 0.026], [0.125, 0.135, 0.030], [0.17, 0.115, 0.026], [0.060, 0.105, 0.030]];
    let mut kinds = |name: &str, make: &dyn Fn(&mut Scene, i32) -> Parts| {
        (0..KINDS)
            .map(|kind| {
                let name = format!("{name} {kind}");
                let parts = make(scene, kind).into_iter();
                let parts: Vec<_> =
                    parts.map(|(mesh, material)| Mesh { name: name.clone(), material, ..mesh }).collect();
                let meshes = parts.into_iter().map(|mesh| scene.add_mesh(mesh)).collect();
                scene.add_object_of(name, meshes)
            })
            .collect::<Vec<_>>()
    };
    Objects {
        conifers: kinds("conifer", &|scene, kind| {
            let green = scene.add_material(Material::matte("needles", needles[kind as usize]));
            vec![(trunk(0.03, 0.25), bark), (skirts(kind), green)]
        }),
        broadleaf: kinds("broadleaf", &|scene, kind| {
            let green = scene.add_material(Material::matte("leaves", leaves[kind as usize]));
            vec![(trunk(0.04, 0.45), bark), (crown(kind), green)]
        }),
        rocks: kinds("rock", &|_, kind| vec![(rock(kind), stone)]),
    }
}

fn trunk(radius: f32, height: f32) -> Mesh {
    lathe(&[[radius, 0.0], [0.6 * radius, height]], 6)
}

/// Tiers of drooping branches, each a cone with a ragged hem.
fn skirts(kind: i32) -> Mesh {
    let mut mesh = Mesh::default();
    let tiers = 5 + kind % 2;
    for tier in 0..tiers {
        let t = tier as f32 / tiers as f32;
        let (low, width) = (0.12 + 0.80 * t, 0.26 * (1.0 - t).powf(0.85) + 0.02);
        let high = (low + 0.30 * (1.0 - 0.5 * t)).min(1.0);
        let mut cone = lathe(&[[width, low], [0.0, high]], 11);
        for (k, p) in cone.positions.iter_mut().enumerate().filter(|(_, p)| p[1] < high) {
            let reach = 0.72 + 0.5 * hash(k as i32 % 11, tier, 200 + kind as u32);
            *p = [p[0] * reach, p[1] - 0.05 * reach, p[2] * reach];
        }
        append(&mut mesh, &cone);
    }
    mesh
}

/// A crown of clumps of leaves.
fn crown(kind: i32) -> Mesh {
    let mut mesh = Mesh::default();
    for clump in 0..6 {
        let random = |seed: u32| hash(clump, kind, seed);
        let (s, c) = (random(1) * std::f32::consts::TAU).sin_cos();
        let out = 0.22 * random(2).sqrt();
        let size = 0.17 + 0.11 * random(3);
        let at = [out * s, 0.48 + 0.34 * random(4), out * c];
        append(&mut mesh, &moved(rough_ball(size, 7, 300 + clump as u32 + 10 * kind as u32, 0.34), at));
    }
    mesh
}

fn rock(kind: i32) -> Mesh {
    let ball = rough_ball(1.0, 7, 400 + kind as u32, 0.45);
    transformed(ball, Affine::scale([1.0, 0.62, 0.8]))
}

/// A bumpy ball, flat-shaded, so that every face has its own brightness.
fn rough_ball(radius: f32, rings: u32, seed: u32, roughness: f32) -> Mesh {
    let mut ball = sphere(radius, rings);
    for p in &mut ball.positions {
        let [x, y, z] = p.map(|c| 2.2 * c / radius);
        let bump = 1.0 + roughness * value(x + 1.7 * y, z - 1.3 * y + 0.3 * x, seed);
        *p = p.map(|c| c * bump);
    }
    ball.normals.fill([0.0; 3]);
    ball
}
