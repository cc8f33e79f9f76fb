// SPDX-License-Identifier: GPL-3.0-or-later
//! Balls from smooth to rough (left to right) and from plastic to metal (front to back).
//! The axes are those of glTF 2.0's metallic-roughness model.

use super::shapes::{append, moved, quad, show, sphere};
use crate::affine::Affine;
use crate::camera::Camera;
use crate::light::Light;
use crate::material::{Color, Material, Surface};
use crate::scene::Scene;

const COLUMNS: u32 = 7;
const ROWS: u32 = 3;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::new();
    let ball = sphere(0.42, 48);
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let metallic = row as f32 / (ROWS - 1) as f32;
            let roughness = 0.05 + 0.95 * column as f32 / (COLUMNS - 1) as f32;
            let name = format!("metallic {metallic:.1}, roughness {roughness:.2}");
            let surface = Surface::MetallicRoughness {
                base_color: Color::constant(
                    [[0.55, 0.05, 0.04], [0.85, 0.40, 0.22], [0.95, 0.64, 0.54]][row as usize],
                ),
                metallic,
                roughness,
                metallic_roughness_texture: None,
                ior: 1.5,
                normal_texture: None,
            };
            let material = scene.add_material(Material::of(name.clone(), surface));
            let at =
                [column as f32 - (COLUMNS - 1) as f32 / 2.0, 0.42 + 0.35 * row as f32, -1.15 * row as f32];
            show(&mut scene, &name, moved(ball.clone(), at), material);
        }
    }
    let stage = scene.add_material(Material::matte("stage", [0.36, 0.37, 0.40]));
    let mut steps = quad([-30.0, 0.0, 30.0], [60.0, 0.0, 0.0], [0.0, 0.0, -30.575]);
    for row in 0..ROWS {
        // Each row is on a step of its own.
        let (y, z) = (0.35 * row as f32, -1.15 * row as f32 + 0.575);
        append(&mut steps, &quad([-30.0, y, z], [60.0, 0.0, 0.0], [0.0, 0.0, -1.15]));
        append(&mut steps, &quad([-30.0, y - 0.35, z], [60.0, 0.0, 0.0], [0.0, 0.35, 0.0]));
    }
    let back = 0.575 - 1.15 * ROWS as f32;
    append(&mut steps, &quad([-30.0, 0.35 * (ROWS - 1) as f32, back], [60.0, 0.0, 0.0], [0.0, 12.0, 0.0]));
    show(&mut scene, "stage", steps, stage);

    add_lamp(&mut scene, [-5.5, 5.5, 3.0], [2.9, 2.5, 2.1]);
    add_lamp(&mut scene, [0.5, 7.0, 4.5], [1.8, 1.8, 1.8]);
    add_lamp(&mut scene, [6.5, 4.5, 2.0], [1.45, 1.7, 2.1]);
    let world_from_light = Affine::IDENTITY;
    scene.add_light(Light::Environment { radiance: [0.10, 0.11, 0.13], texture: None, world_from_light });
    scene.add_camera(Camera {
        name: "front".into(),
        eye: [0.0, 3.0, 7.4],
        target: [0.0, 0.72, -1.05],
        up: [0.0, 1.0, 0.0],
        fov_y: 33.0,
        ..Camera::default()
    });
    scene
}

/// A soft box that faces the middle row.
fn add_lamp(scene: &mut Scene, at: [f32; 3], radiance: [f32; 3]) {
    let mut material = Material::matte("lamp", [0.0; 3]);
    material.emission = radiance;
    let material = scene.add_material(material);
    let view = Camera {
        name: String::new(),
        eye: at,
        target: [0.0, 0.5, -1.15],
        up: [0.0, 1.0, 0.0],
        fov_y: 1.0,
        ..Camera::default()
    };
    let Some(frame) = view.frame() else {
        return;
    };
    let half = 2.1;
    let corner = [0, 1, 2].map(|k| at[k] + half * (frame.right[k] - frame.up[k]));
    // `left x up` faces forward.
    let panel = quad(corner, frame.right.map(|x| -2.0 * half * x), frame.up.map(|x| 2.0 * half * x));
    show(scene, "lamp", panel, material);
}
