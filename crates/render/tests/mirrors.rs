// SPDX-License-Identifier: GPL-3.0-or-later
//! Where mirrors and glass lead the eye. Positions follow from the laws of reflection and refraction.

use crate::common::*;
use gnurt_scene::material::Color;
use gnurt_scene::{Light, Material, Scene, Surface};

/// A mirror on the floor, and a wall at y = 4 that shines below z = 2 and is brighter above.
fn hall() -> Scene {
    let mut scene = Scene::new();
    let mirror = Surface::Mirror { reflectance: Color::constant([0.5; 3]) };
    let mirror = scene.add_material(Material::of("mirror", mirror));
    put_mesh(&mut scene, quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], mirror));
    let (low, high) = (emitter(&mut scene, [1.0; 3]), emitter(&mut scene, [3.0; 3]));
    // Normals along -y.
    put_mesh(&mut scene, quad([-9.0, 4.0, 0.0], [18.0, 0.0, 0.0], [0.0, 0.0, 2.0], low));
    put_mesh(&mut scene, quad([-9.0, 4.0, 2.0], [18.0, 0.0, 0.0], [0.0, 0.0, 2.0], high));
    scene
}

#[test]
fn mirrors_show_the_right_place() {
    let scene = hall();
    // From (0, -4, 1) to the floor at y: the wall is met at height (4 - y) / (y + 4).
    let measured = |y: f32| radiance_at(&scene, [0.0, -4.0, 1.0], [0.0, y, 0.0], 1)[0];
    assert_close(measured(-1.30), 0.5, 1e-5, "height 1.96, below the line");
    assert_close(measured(-1.35), 1.5, 1e-5, "height 2.02, above it");
}

#[test]
fn depth_limit_shows_the_environment() {
    let mut scene = hall();
    scene.add_light(environment([10.0; 3]));
    let options = gnurt_render::RenderOptions { max_depth: 0, ..options(2, 2, 1) };
    let frame = frame(&scene, &camera([0.0, -4.0, 1.0], [0.0, -1.0, 0.0], 1.0), &options);
    assert_close(mean(&frame.picture)[0], 5.0, 1e-5, "half of the environment");
    assert_eq!(frame.stats.secondary_rays, 0, "nothing was traced");
}

/// A slab of glass shifts the image behind it, and Fresnel's equations hold at both faces.
#[test]
fn slabs_shift_and_dim() {
    let mut scene = Scene::new();
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [1.0; 3],
        interior: Default::default(),
    };
    let glass = scene.add_material(Material::of("glass", glass));
    // Faces at z = 1 (normal up) and z = 0 (normal down).
    put_mesh(&mut scene, quad([-9.0, -9.0, 1.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], glass));
    put_mesh(&mut scene, quad([-9.0, -9.0, 0.0], [0.0, 18.0, 0.0], [18.0, 0.0, 0.0], glass));
    let light = emitter(&mut scene, [1.0; 3]);
    // Shines up, from the edge y = 0 on.
    put_mesh(&mut scene, quad([-9.0, 0.0, -1.0], [18.0, 0.0, 0.0], [0.0, 9.0, 0.0], light));
    // 45 degrees down from (0, y - 2, 2): without glass it would meet z = -1 at y + 1.
    let inside = (0.5_f64.sqrt() / 1.5).asin().tan();
    let shift = 1.0 - inside;
    let measured = |landing: f64| {
        let y = (landing + shift - 1.0) as f32;
        radiance_at(&scene, [0.0, y - 2.0, 2.0], [0.0, y, 0.0], 512)[0]
    };
    // Only light reflected twice between the faces lands further on, on the light.
    assert!(measured(-0.05) < 0.01, "just before the edge");
    let through = {
        let (cos, beyond) = (0.5_f64.sqrt(), (1.0 - 0.5 / 2.25_f64).sqrt());
        let parallel = (1.5 * cos - beyond) / (1.5 * cos + beyond);
        let perpendicular = (cos - 1.5 * beyond) / (cos + 1.5 * beyond);
        1.0 - 0.5 * (parallel * parallel + perpendicular * perpendicular)
    };
    // Light reflected an even number of times between the faces lands further on, on the light too.
    let expected = through * through / (1.0 - (1.0 - through).powi(2));
    assert_close(measured(0.05), expected, 0.01, "just behind it");
}

#[test]
fn glass_balls_keep_the_furnace() {
    let mut scene = Scene::new();
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [1.0; 3],
        interior: Default::default(),
    };
    let glass = scene.add_material(Material::of("glass", glass));
    put_mesh(&mut scene, sphere([0.0; 3], 1.0, 32, glass));
    scene.add_light(environment([1.0; 3]));
    let frame = frame(&scene, &camera([0.0, -5.0, 0.0], [0.0; 3], 30.0), &options(24, 24, 8));
    for pixel in &frame.picture.color {
        assert_close(f64::from(pixel[0]), 1.0, 1e-4, "clear glass in a furnace cannot be seen");
    }
}

#[test]
fn smooth_metals_see_lights_once() {
    // Rough metals keep the energy of scattering between microfacets.
    for roughness in [0.0, 0.1, 0.2, 0.3, 0.6, 1.0] {
        let mut scene = Scene::new();
        let metal = Surface::MetallicRoughness {
            base_color: Color::constant([1.0; 3]),
            metallic: 1.0,
            roughness,
            metallic_roughness_texture: None,
            ior: 1.5,
            normal_texture: None,
        };
        let metal = scene.add_material(Material::of("metal", metal));
        put_mesh(&mut scene, quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], metal));
        // Met by mirrored rays and sampled by rough lobes: twice were too bright, never too dark.
        scene.add_light(environment([1.0; 3]));
        let measured = radiance_at(&scene, [0.0, -2.0, 4.0], [0.0; 3], 1024)[0];
        assert_close(measured, 1.0, 0.01, &format!("roughness {roughness}: a white metal under white"));
    }
}

#[test]
fn smooth_coats_show_point_lights() {
    let mut scene = Scene::new();
    let metal = Surface::MetallicRoughness {
        base_color: Color::constant([1.0; 3]),
        metallic: 1.0,
        roughness: 0.2,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture: None,
    };
    let metal = scene.add_material(Material::of("metal", metal));
    put_mesh(&mut scene, quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], metal));
    scene.add_light(Light::Point { position: [0.0, 2.0, 2.0], intensity: [1.0; 3], radius: 0.0 });
    let measured = radiance_at(&scene, [0.0, -2.0, 2.0], [0.0; 3], 4)[0];
    // At the mirror direction D = 1 / (pi a^2), G = 1 / (1 + 2 lambda), F = 1, all angles 45 degrees.
    let a2 = 0.04_f64 * 0.04;
    let lambda = 0.5 * ((1.0 + a2).sqrt() - 1.0);
    let cos = 0.5_f64.sqrt();
    let expected = 1.0 / (std::f64::consts::PI * a2) / (1.0 + 2.0 * lambda) / (4.0 * cos) / 8.0;
    assert_close(measured, expected, 0.01, "the highlight's peak");
}
