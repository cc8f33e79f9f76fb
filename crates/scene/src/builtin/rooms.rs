// SPDX-License-Identifier: GPL-3.0-or-later
//! Three rooms in a row, joined by narrow openings: a light in the last one, the camera in the first.
//! Source: after the rooms of [VG97] that only few paths cross. Space: metres, y upwards.
//! The light faces away from the openings: it is scattered in the last room, and nearly always in the middle
//! one, before it reaches the camera's room.

use super::shapes::{append, block, quad, show};
use crate::camera::Camera;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Length of each room, their height and their width.
const LENGTH: f32 = 4.0;
const HEIGHT: f32 = 3.0;
const WIDTH: f32 = 4.0;
/// Where the walls' openings are, how wide and how high, from the floor on.
const OPENINGS: [f32; 2] = [0.5, 3.1];
const OPENING: [f32; 2] = [0.35, 1.8];

pub(super) fn scene() -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::matte("white", [0.75; 3]));
    let blue = scene.add_material(Material::matte("blue", [0.25, 0.4, 0.65]));
    let red = scene.add_material(Material::matte("red", [0.7, 0.3, 0.25]));
    let mut light = Material::matte("light", [0.0; 3]);
    light.emission = [640.0, 600.0, 520.0];
    let light = scene.add_material(light);

    show(&mut scene, "rooms", shell(), white);
    for (number, z) in (1..).zip(OPENINGS) {
        show(&mut scene, &format!("wall {number}"), wall(number as f32 * LENGTH, z), white);
    }
    let wall = quad([0.001, 0.0, 0.0], [0.0, HEIGHT, 0.0], [0.0, 0.0, WIDTH]);
    show(&mut scene, "near wall", wall, blue);
    let crate_shape = block([[1.6, 2.2], [1.4, 2.9], [2.1, 3.1], [2.3, 2.4]], 0.9);
    show(&mut scene, "crate", crate_shape, red);
    // In the last room, above its opening, facing away from it.
    let light_mesh = quad([2.0 * LENGTH + 0.2, 2.0, 3.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]);
    show(&mut scene, "lamp", light_mesh, light);
    scene.add_camera(Camera {
        name: "in the first room".into(),
        eye: [0.3, 1.6, 3.7],
        target: [3.0, 1.1, 0.9],
        up: [0.0, 1.0, 0.0],
        fov_y: 55.0,
        ..Camera::default()
    });
    scene
}

/// Floor, ceiling and outer walls of all rooms.
fn shell() -> Mesh {
    let (x, y, z) = ([3.0 * LENGTH, 0.0, 0.0], [0.0, HEIGHT, 0.0], [0.0, 0.0, WIDTH]);
    let mut shell = quad([0.0; 3], z, x);
    append(&mut shell, &quad([0.0, HEIGHT, 0.0], x, z));
    append(&mut shell, &quad([0.0; 3], x, y));
    append(&mut shell, &quad([0.0, 0.0, WIDTH], y, x));
    append(&mut shell, &quad([0.0; 3], y, z));
    append(&mut shell, &quad([3.0 * LENGTH, 0.0, 0.0], z, y));
    shell
}

/// A wall across the rooms at `x`, with an opening from `z` on.
fn wall(x: f32, z: f32) -> Mesh {
    let [width, height] = OPENING;
    let up = [0.0, HEIGHT, 0.0];
    let mut wall = quad([x, 0.0, 0.0], [0.0, 0.0, z], up);
    append(&mut wall, &quad([x, 0.0, z + width], [0.0, 0.0, WIDTH - z - width], up));
    append(&mut wall, &quad([x, height, z], [0.0, 0.0, width], [0.0, HEIGHT - height, 0.0]));
    wall
}
