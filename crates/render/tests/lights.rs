// SPDX-License-Identifier: GPL-3.0-or-later
//! Radiance of a floor under each kind of light, against closed forms. Form factors as in [Gol94].

use std::f64::consts::PI;

use crate::common::*;
use gnurt_render::{Integrator, RenderOptions, Silent, render};
use gnurt_scene::{Affine, Light, Material, Scene, Surface};

const EYE: [f32; 3] = [0.5, -2.0, 3.0];
const ALBEDO: f64 = 0.6;

fn floor_under(light: Light) -> f64 {
    let mut scene = floor(ALBEDO as f32, 10.0);
    scene.add_light(light);
    radiance_at(&scene, EYE, [0.5, 0.25, 0.0], 1)[0]
}

#[test]
fn point_light() {
    let found = floor_under(Light::Point { position: [1.0, 1.0, 2.0], intensity: [7.0; 3], radius: 0.0 });
    let d2 = 0.25 + 0.5625 + 4.0_f64;
    assert_close(found, ALBEDO / PI * 7.0 / d2 * (2.0 / d2.sqrt()), 1e-3, "I cos / d²");
}

#[test]
fn a_lamp_on_a_ceiling_is_not_shadowed_by_it() {
    let mut scene = floor(ALBEDO as f32, 10.0);
    let white = matte(&mut scene, [0.5; 3]);
    // A height that floats cannot hold exactly: the end of a shadow ray may round to either side of the ceiling.
    let height = 2.1_f32;
    put_mesh(&mut scene, quad([-10.0, 10.0, height], [20.0, 0.0, 0.0], [0.0, -20.0, 0.0], white));
    scene.add_light(Light::Point { position: [1.0, 1.0, height], intensity: [7.0; 3], radius: 0.0 });
    for step in 0..40 {
        let x = 0.37 * step as f32 - 7.0;
        let found = radiance_at(&scene, [x, -2.0, 1.5], [x, 0.25, 0.0], 1)[0];
        let d2 = f64::from(x - 1.0).powi(2) + 0.5625 + f64::from(height).powi(2);
        let expected = ALBEDO / PI * 7.0 / d2 * (f64::from(height) / d2.sqrt());
        assert_close(found, expected, 2e-3, "I cos / d² below a lamp that lies on the ceiling");
    }
}

#[test]
fn spot_light() {
    let spot = |direction| Light::Spot {
        position: [0.5, 0.25, 2.0],
        direction,
        intensity: [7.0; 3],
        inner_angle: 0.2,
        outer_angle: 0.4,
        edge: gnurt_scene::ConeEdge::default(),
        radius: 0.0,
    };
    let full = ALBEDO / PI * 7.0 / 4.0;
    assert_close(floor_under(spot([0.0, 0.0, -3.0])), full, 1e-3, "inside the inner cone");
    let angle = 0.3_f32;
    let share = {
        let cos = |a: f64| a.cos();
        (cos(0.3) - cos(0.4)) / (cos(0.2) - cos(0.4))
    };
    let interpolated = floor_under(spot([angle.sin(), 0.0, -angle.cos()]));
    assert_close(interpolated, full * share * share, 5e-3, "between the cones");
    assert_eq!(floor_under(spot([1.0, 0.0, -1.0])), 0.0, "outside");
}

#[test]
fn directional_light() {
    let found =
        floor_under(Light::Directional { direction: [3.0, 0.0, -4.0], irradiance: [2.0; 3], angle: 0.0 });
    assert_close(found, ALBEDO / PI * 2.0 * 0.8, 1e-4, "E cos");
}

/// The half shadow of a sun of 40 degrees behind an edge at height 1, against the part of the disc that a point sees.
#[test]
fn suns_have_half_shadows() {
    let (angle, sin_half) = (40.0_f32.to_radians(), f64::from(20.0_f32.to_radians().sin()));
    let mut scene = floor(ALBEDO as f32, 10.0);
    let black = matte(&mut scene, [0.0; 3]);
    put_mesh(&mut scene, quad([-10.0, -10.0, 1.0], [20.0, 0.0, 0.0], [0.0, 10.0, 0.0], black));
    scene.add_light(Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [2.0; 3], angle });
    let world = world_of(&scene, false);
    for y in [-0.3_f32, -0.1, 0.0, 0.2, 0.4] {
        const N: usize = 400;
        let at = |k: usize| sin_half * ((2 * k + 1) as f64 / N as f64 - 1.0);
        let (mut seen, mut all) = (0.0, 0.0);
        for (a, b) in (0..N).flat_map(|i| (0..N).map(move |j| (at(i), at(j)))) {
            let square = a * a + b * b;
            let is_seen = f64::from(y) + b / (1.0 - square).sqrt() > 0.0;
            all += f64::from(u8::from(square < sin_half * sin_half));
            seen += f64::from(u8::from(square < sin_half * sin_half && is_seen));
        }
        let exact = ALBEDO / PI * 2.0 * seen / all;
        let view = camera([0.5, y + 3.0, 0.7], [0.0, y, 0.0], 0.01);
        for integrator in [Integrator::Whitted, Integrator::Path, Integrator::InstantRadiosity] {
            let options = RenderOptions { integrator, max_depth: 2, vpls: 256, ..options(16, 16, 64) };
            let found =
                mean(&render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture);
            let off = (found[0] - exact).abs();
            assert!(off < 0.01 * ALBEDO / PI * 2.0, "{integrator} at {y}: {} instead of {exact}", found[0]);
        }
    }
}

/// Irradiance from a rectangle parallel to the floor, above one of whose corners it lies at height 1.
fn corner_form_factor(a: f64, b: f64) -> f64 {
    let (x, y) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    (a / x * (b / x).atan() + b / y * (a / y).atan()) / (2.0 * PI)
}

#[test]
fn rectangle_light() {
    for (mirrored, name) in [(false, "as it stands"), (true, "under a mirroring instance")] {
        let mut scene = floor(ALBEDO as f32, 10.0);
        let light = emitter(&mut scene, [3.0, 2.0, 1.0]);
        // Normal down: along y, then along x.
        let mesh = scene.add_mesh(quad([0.5, 0.25, 1.0], [0.0, 2.0, 0.0], [1.5, 0.0, 0.0], light));
        let object = scene.add_object_of("light", vec![mesh]);
        let turned = if mirrored {
            // Mirrored at x = 0.5: still above the same corner, still shining down.
            Affine::translation([1.0, 0.0, 0.0]) * Affine::scale([-1.0, 1.0, 1.0])
        } else {
            Affine::IDENTITY
        };
        scene.instantiate(object, turned);
        let found = radiance_at(&scene, EYE, [0.5, 0.25, 0.0], 4096);
        let expected = ALBEDO * corner_form_factor(2.0, 1.5);
        assert_close(found[0], 3.0 * expected, 2e-3, name);
        assert_close(found[2], expected, 2e-3, name);
    }
}

#[test]
fn emission_leaves_the_front_only() {
    let mut scene = floor(0.5, 10.0);
    let light = emitter(&mut scene, [5.0; 3]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 2.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], light));
    let below = radiance_at(&scene, [0.0, 0.1, 1.0], [0.0, 0.0, 2.0], 1);
    assert_eq!(below, [0.0; 3], "the back is dark");
    assert_eq!(radiance_at(&scene, [2.0, -2.0, 0.5], [0.0, 0.0, 0.0], 16), [0.0; 3], "and lights nothing");
    let above = radiance_at(&scene, [0.0, 0.1, 3.0], [0.0, 0.0, 2.0], 1);
    assert_close(above[0], 5.0, 1e-6, "the front shows its radiance");
}

#[test]
fn furnace() {
    let mut scene = Scene::new();
    let white = matte(&mut scene, [0.75, 0.5, 0.25]);
    put_mesh(&mut scene, sphere([0.0; 3], 1.0, 24, white));
    scene.add_light(environment([2.0; 3]));
    let found = radiance_at(&scene, [0.0, -5.0, 0.0], [0.2, 0.0, 0.3], 64);
    // Each triangle of the sphere lies below the horizon of its neighbours: only shading normals lose a little.
    for (found, albedo) in found.into_iter().zip([0.75, 0.5, 0.25]) {
        assert_close(found, 2.0 * albedo, 5e-3, "radiance = albedo times that of the environment");
    }
    let neighbours = radiance_at(&scene, [0.0, -5.0, 0.0], [3.0, 0.0, 0.0], 1);
    assert_close(neighbours[0], 2.0, 1e-6, "misses see the environment");
}

#[test]
fn instances_share_an_object_and_shine_alone() {
    let mut scene = floor(ALBEDO as f32, 20.0);
    let light = emitter(&mut scene, [1.0; 3]);
    let mesh = scene.add_mesh(quad([-0.5, -0.5, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], light));
    let object = scene.add_object_of("lamp", vec![mesh]);
    scene.instantiate(object, Affine::translation([0.0, 0.0, 2.0]));
    let one = radiance_at(&scene, [0.0, -9.0, 3.0], [0.0, 0.0, 0.0], 4096)[0];
    // Twice as large and twice as high: the same solid angle. Side by side with a screen nowhere: light adds up.
    scene.instantiate(object, Affine::translation([0.0, 0.0, 4.0]) * Affine::scale([2.0, 2.0, 2.0]));
    scene.edit_instance(gnurt_scene::InstanceId(1)).visible = false;
    let other = radiance_at(&scene, [0.0, -9.0, 3.0], [0.0, 0.0, 0.0], 4096)[0];
    assert_close(other, one, 2e-3, "the same solid angle");
    let world = world_of(&scene, false);
    assert_eq!(world.stats().instances, 2, "the hidden instance is not there");
}

#[test]
fn glass_lets_light_through_and_holes_too() {
    let lit = |material: Option<Material>| {
        let mut scene = floor(ALBEDO as f32, 10.0);
        scene.add_light(Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [1.0; 3], angle: 0.0 });
        if let Some(material) = material {
            let material = scene.add_material(material);
            for z in [1.0, 1.5] {
                put_mesh(&mut scene, quad([-1.0, -1.0, z], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], material));
            }
        }
        radiance_at(&scene, [0.0, -4.0, 0.5], [0.0; 3], 1)[0]
    };
    let free = lit(None);
    assert_eq!(lit(Some(Material::matte("screen", [0.5; 3]))), 0.0, "a screen");
    let surface = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [0.9; 3],
        interior: Default::default(),
    };
    let through = lit(Some(Material::of("pane", surface)));
    assert_close(through, free * (0.9_f64 * 0.96).powi(2), 1e-3, "two panes at normal incidence");
    let opacity = gnurt_scene::material::Opacity {
        factor: 0.25,
        texture: None,
        channel: gnurt_scene::material::OpacityChannel::Alpha,
    };
    let veil = |alpha| Material { alpha, ..Material::matte("veil", [0.5; 3]) };
    let blend = lit(Some(veil(gnurt_scene::material::Alpha::Blend { opacity })));
    assert_close(blend, free * 0.75 * 0.75, 1e-4, "two veils");
    let mask = lit(Some(veil(gnurt_scene::material::Alpha::Mask { cutoff: 0.5, opacity })));
    assert_close(mask, free, 1e-4, "a mask that is nowhere there");
}
