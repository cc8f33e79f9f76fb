// SPDX-License-Identifier: GPL-3.0-or-later
//! Two rooms: a light that faces the far wall of one, a slit in the wall between them, the camera in the
//! other one. A test of hard visibility after the ajar door of [VG97]. Space: metres, y upwards. Nothing
//! visible to the camera is lit by the light directly: light passes the slit after one bounce at least.

use super::shapes::{append, block, moved, quad, show};
use crate::camera::Camera;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Half the length of both rooms together, their height and their width.
const LENGTH: f32 = 4.0;
const HEIGHT: f32 = 3.0;
const WIDTH: f32 = 4.0;
/// Where the slit is, and how high.
const SLIT: [f32; 2] = [1.92, 2.08];
const SLIT_HEIGHT: f32 = 2.4;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::matte("white", [0.75; 3]));
    let blue = scene.add_material(Material::matte("blue", [0.2, 0.35, 0.65]));
    let orange = scene.add_material(Material::matte("orange", [0.75, 0.45, 0.15]));
    let mut light = Material::matte("light", [0.0; 3]);
    light.emission = [160.0, 150.0, 130.0];
    let light = scene.add_material(light);

    show(&mut scene, "rooms", rooms(), white);
    show(&mut scene, "wall", wall(), white);
    show(
        &mut scene,
        "far wall",
        quad([LENGTH - 0.001, 0.0, 0.0], [0.0, 0.0, WIDTH], [0.0, HEIGHT, 0.0]),
        blue,
    );
    let crate_shape = block([[2.6, 2.4], [2.4, 3.1], [3.1, 3.3], [3.3, 2.6]], 0.8);
    show(&mut scene, "crate", crate_shape, orange);
    show(
        &mut scene,
        "shelf",
        moved(block([[1.2, 3.4], [1.2, 3.9], [2.2, 3.9], [2.2, 3.4]], 0.05), [0.0, 1.2, 0.0]),
        orange,
    );
    // On the wall's other side, facing away from it.
    show(&mut scene, "lamp", quad([-0.4, 1.2, 0.5], [0.0, 0.0, 0.5], [0.0, 0.5, 0.0]), light);
    scene.add_camera(Camera {
        name: "behind the slit".into(),
        eye: [0.4, 1.6, 0.3],
        target: [3.0, 1.1, 2.9],
        up: [0.0, 1.0, 0.0],
        fov_y: 55.0,
        ..Camera::default()
    });
    scene
}

/// Floor, ceiling and outer walls of both rooms.
fn rooms() -> Mesh {
    let (x, y, z) = ([2.0 * LENGTH, 0.0, 0.0], [0.0, HEIGHT, 0.0], [0.0, 0.0, WIDTH]);
    let mut shell = quad([-LENGTH, 0.0, 0.0], z, x);
    append(&mut shell, &quad([-LENGTH, HEIGHT, 0.0], x, z));
    append(&mut shell, &quad([-LENGTH, 0.0, 0.0], x, y));
    append(&mut shell, &quad([-LENGTH, 0.0, WIDTH], y, x));
    append(&mut shell, &quad([-LENGTH, 0.0, 0.0], y, z));
    append(&mut shell, &quad([LENGTH, 0.0, 0.0], z, y));
    shell
}

/// The wall between them, around the slit.
fn wall() -> Mesh {
    let mut wall = quad([0.0; 3], [0.0, 0.0, SLIT[0]], [0.0, HEIGHT, 0.0]);
    append(&mut wall, &quad([0.0, 0.0, SLIT[1]], [0.0, 0.0, WIDTH - SLIT[1]], [0.0, HEIGHT, 0.0]));
    let above =
        quad([0.0, SLIT_HEIGHT, SLIT[0]], [0.0, 0.0, SLIT[1] - SLIT[0]], [0.0, HEIGHT - SLIT_HEIGHT, 0.0]);
    append(&mut wall, &above);
    wall
}
