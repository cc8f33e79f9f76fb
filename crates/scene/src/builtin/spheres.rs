// SPDX-License-Identifier: GPL-3.0-or-later
//! Mirror, glass, metal and matte spheres on a checkerboard.
//! Source: after the pictures that ray tracing began with [Whi80].

use super::shapes::{moved, quad, show, sphere};
use super::sky::Sky;
use crate::affine::Affine;
use crate::camera::Camera;
use crate::id::MaterialId;
use crate::material::{Color, Material, Surface, TextureRef};
use crate::scene::Scene;
use crate::texture::{Filter, TexelData, Texels, Texture, Wrap};

/// Half the side of the floor.
const FLOOR: f32 = 40.0;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::new();
    let floor = checkerboard(&mut scene);
    let side = 2.0 * FLOOR;
    show(&mut scene, "floor", quad([-FLOOR, 0.0, FLOOR], [side, 0.0, 0.0], [0.0, 0.0, -side]), floor);

    let mirror = Surface::Mirror { reflectance: Color::constant([0.92, 0.93, 0.95]) };
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [0.96, 1.0, 0.98],
        interior: Default::default(),
    };
    let big = [
        ("mirror", mirror, [-0.1, 1.0, -1.3], 1.0),
        ("glass", glass, [1.25, 0.75, 0.35], 0.75),
        ("gold", metal([1.0, 0.71, 0.29], 0.1), [-1.75, 0.7, 0.0], 0.7),
    ];
    for (name, surface, at, radius) in big {
        let material = scene.add_material(Material::of(name, surface));
        show(&mut scene, name, moved(sphere(radius, 64), at), material);
    }
    let small = [
        ("red", [0.62, 0.07, 0.05], [-0.55, 0.32, 0.85]),
        ("blue", [0.06, 0.16, 0.52], [0.35, 0.26, 1.35]),
        ("green", [0.10, 0.38, 0.12], [2.35, 0.34, -0.75]),
        ("ivory", [0.78, 0.71, 0.55], [-2.6, 0.36, 1.05]),
        ("violet", [0.32, 0.10, 0.42], [1.2, 0.28, -2.1]),
    ];
    for (name, albedo, at) in small {
        let material = scene.add_material(Material::matte(name, albedo));
        show(&mut scene, name, moved(sphere(at[1], 40), at), material);
    }
    Sky {
        zenith: [0.16, 0.34, 0.75],
        horizon: [0.72, 0.82, 0.95],
        glow_radiance: [0.9, 0.7, 0.4],
        ground: [0.25, 0.24, 0.22],
        sun: [-0.594, 0.653, 0.470],
        sunlight: [2.6, 2.4, 2.0],
    }
    .add_to(&mut scene, Affine::IDENTITY);
    scene.add_camera(Camera {
        name: "front".into(),
        eye: [0.4, 1.75, 6.2],
        target: [-0.1, 0.72, -0.3],
        up: [0.0, 1.0, 0.0],
        fov_y: 36.0,
        ..Camera::default()
    });
    scene
}

pub(super) fn metal(color: [f32; 3], roughness: f32) -> Surface {
    Surface::MetallicRoughness {
        base_color: Color::constant(color),
        metallic: 1.0,
        roughness,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture: None,
    }
}

fn checkerboard(scene: &mut Scene) -> MaterialId {
    let (dark, light) = ([0.05, 0.055, 0.06, 1.0], [0.75, 0.74, 0.72, 1.0]);
    let data = TexelData::Float(vec![dark, light, light, dark]);
    let texture = scene.add_texture(Texture {
        name: "checkerboard".into(),
        texels: Texels { width: 2, height: 2, data }.into(),
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Nearest,
    });
    let squares = FLOOR;
    let reference =
        TextureRef { uv_from_mesh: [squares, 0.0, 0.0, squares, 0.0, 0.0], ..TextureRef::new(texture) };
    let base_color = Color { factor: [1.0; 3], texture: Some(reference) };
    scene.add_material(Material::of("checkerboard", Surface::Matte { base_color }))
}
