// SPDX-License-Identifier: GPL-3.0-or-later
//! The Cornell box.
//! Source: [GTGB84], with the measured geometry of the Cornell University Program of Computer Graphics.
//! Space: metres / 100 as measured, seen along +z; the red wall is to the left.

use super::shapes::{append, block, quad, show};
use crate::camera::Camera;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::Scene;

const WIDTH: f32 = 5.528;
const HEIGHT: f32 = 5.488;
const DEPTH: f32 = 5.592;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::matte("white", [0.73; 3]));
    let red = scene.add_material(Material::matte("red", [0.63, 0.065, 0.05]));
    let green = scene.add_material(Material::matte("green", [0.14, 0.45, 0.091]));
    let mut light = Material::matte("light", [0.78; 3]);
    light.emission = [18.4, 12.8, 4.6];
    let light = scene.add_material(light);

    let (x, y, z) = ([WIDTH, 0.0, 0.0], [0.0, HEIGHT, 0.0], [0.0, 0.0, DEPTH]);
    let mut shell = quad([0.0; 3], z, x);
    append(&mut shell, &quad(y, x, z));
    append(&mut shell, &quad(z, y, x));
    show(&mut scene, "floor, ceiling and back", shell, white);
    show(&mut scene, "left wall", quad(x, z, y), red);
    show(&mut scene, "right wall", quad([0.0; 3], y, z), green);
    // Just below the ceiling, facing down.
    let light_mesh = quad([2.13, HEIGHT - 0.001, 2.27], [1.30, 0.0, 0.0], [0.0, 0.0, 1.05]);
    show(&mut scene, "lamp", light_mesh, light);
    show(&mut scene, "short block", short_block(), white);
    show(&mut scene, "tall block", tall_block(), white);
    scene.add_camera(Camera {
        name: "front".into(),
        eye: [2.78, 2.73, -8.0],
        target: [2.78, 2.73, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 39.3,
        ..Camera::default()
    });
    scene
}

fn short_block() -> Mesh {
    block([[1.30, 0.65], [0.82, 2.25], [2.40, 2.72], [2.90, 1.14]], 1.65)
}

fn tall_block() -> Mesh {
    block([[4.23, 2.47], [2.65, 2.96], [3.145, 4.56], [4.72, 4.06]], 3.30)
}
