// SPDX-License-Identifier: GPL-3.0-or-later
//! Light samples that look through smooth glass for lamps that no scattered ray meets: closed forms of panes.
//! Fresnel's formulas.

use std::f64::consts::PI;

use crate::common::*;
use gnurt_render::{Integrator, RenderOptions, Silent, World, render};
use gnurt_scene::detail::Interior;
use gnurt_scene::material::{Alpha, Opacity, OpacityChannel};
use gnurt_scene::{Light, Material, MaterialId, Mesh, Scene, Surface};

const ALBEDO: f32 = 0.6;
const TINT: f32 = 0.9;

fn glass(scene: &mut Scene, ior: f32, interior: Interior) -> MaterialId {
    let (reflectance, transmittance) = ([1.0; 3], [TINT; 3]);
    scene.add_material(Material::of(
        "glass",
        Surface::Dielectric { ior, reflectance, transmittance, interior },
    ))
}

/// The two faces of a level pane from `low` to `high`, which look outward.
fn faces(low: f32, high: f32, half: f32, material: MaterialId) -> [Mesh; 2] {
    let edge = 2.0 * half;
    [
        quad([-half, -half, high], [edge, 0.0, 0.0], [0.0, edge, 0.0], material),
        quad([-half, -half, low], [0.0, edge, 0.0], [edge, 0.0, 0.0], material),
    ]
}

fn pane(scene: &mut Scene, low: f32, high: f32, material: MaterialId) {
    faces(low, high, 20.0, material).into_iter().for_each(|mesh| put_mesh(scene, mesh));
}

/// Share of unpolarized light that glass lets through at the cosine outside, and the cosine inside.
fn through(cos: f64, ior: f64) -> (f64, f64) {
    let inside = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
    let (s, p) = ((cos - ior * inside) / (cos + ior * inside), (ior * cos - inside) / (ior * cos + inside));
    (1.0 - (s * s + p * p) / 2.0, inside)
}

fn with(integrator: Integrator, spp: u32, max_depth: u32) -> RenderOptions {
    RenderOptions { integrator, max_depth, vpls: 16, ..options(4, 4, spp) }
}

/// Radiance of the floor's middle, seen from below all glass.
fn measured(world: &World, options: &RenderOptions) -> f64 {
    let view = camera([0.01, 0.0, 0.05], [0.0; 3], 0.01);
    mean(&render(world, &view, options, &pool(1), &Silent).expect("sound options").picture)[0]
}

const ALL: [Integrator; 4] = [
    Integrator::Path,
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

/// The sun through one pane and through two, tinted, by all integrators: no noise at all, for no scattered ray could find it.
#[test]
fn the_sun_shines_through_windows() {
    let (cos, ior) = (0.8, 1.5);
    let (once, inside) = through(cos, ior);
    let (color, distance) = (0.3, 0.5_f64);
    for panes in [1_usize, 2] {
        let mut scene = floor(ALBEDO, 20.0);
        let interior = Interior {
            attenuation_color: [color; 3],
            attenuation_distance: distance as f32,
            ..Interior::default()
        };
        let glass = glass(&mut scene, ior as f32, interior);
        for k in 0..panes {
            pane(&mut scene, 0.5 + k as f32, 0.7 + k as f32, glass);
        }
        scene.add_light(Light::Directional { direction: [0.6, 0.0, -0.8], irradiance: [2.0; 3], angle: 0.0 });
        let world = world_of(&scene, false);
        let left = f64::from(color).powf(0.2 / inside / distance);
        let one = (once * f64::from(TINT)).powi(2) * left;
        let expected = f64::from(ALBEDO) / PI * 2.0 * cos * one.powi(panes as i32);
        for integrator in ALL {
            let edges = 2 + 2 * panes as u32;
            let found = measured(&world, &with(integrator, 1, edges));
            assert_close(found, expected, 1e-3, &format!("{integrator}, {panes} panes"));
            assert_eq!(measured(&world, &with(integrator, 1, edges - 1)), 0.0, "{integrator}: too few edges");
        }
    }
}

/// Point lights shine through glass without refraction only.
#[test]
fn points_shine_through_what_does_not_bend() {
    for (ior, share) in [(1.0, f64::from(TINT).powi(2)), (1.5, 0.0)] {
        let mut scene = floor(ALBEDO, 20.0);
        let glass = glass(&mut scene, ior, Interior::default());
        pane(&mut scene, 0.5, 0.7, glass);
        scene.add_light(Light::Point { position: [1.0, 1.0, 2.0], intensity: [7.0; 3], radius: 0.0 });
        let world = world_of(&scene, false);
        let expected = f64::from(ALBEDO) / PI * 7.0 / 6.0 * (2.0 / 6.0_f64.sqrt()) * share;
        for integrator in ALL {
            let found = measured(&world, &with(integrator, 1, 4));
            assert!((found - expected).abs() <= 1e-3 * expected, "{integrator}: {found}, not {expected}");
        }
    }
}

/// A pane that is there in part, and a veil within it: holes and glass are passed by chance, each as often as it says.
#[test]
fn the_sun_shines_through_panes_with_holes() {
    let half = |material: &mut Material| {
        let opacity = Opacity { factor: 0.5, texture: None, channel: OpacityChannel::Alpha };
        material.alpha = Alpha::Blend { opacity };
    };
    // It mirrors nothing back to the floor.
    let (reflectance, transmittance) = ([0.0; 3], [TINT; 3]);
    let surface = Surface::Dielectric { ior: 1.5, reflectance, transmittance, interior: Interior::default() };
    let (mut pane, mut veil) = (Material::of("", surface), Material::matte("veil", [0.0; 3]));
    [&mut pane, &mut veil].into_iter().for_each(half);
    let mut scene = floor(ALBEDO, 20.0);
    let [pane, veil] = [pane, veil].map(|material| scene.add_material(material));
    faces(0.5, 0.8, 20.0, pane).into_iter().for_each(|mesh| put_mesh(&mut scene, mesh));
    put_mesh(&mut scene, quad([-20.0, -20.0, 0.65], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], veil));
    scene.add_light(Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [2.0; 3], angle: 0.0 });
    let world = world_of(&scene, false);
    // Straight down a face that is not there is as one that does not bend.
    let face = 0.5 + 0.5 * through(1.0, 1.5).0 * f64::from(TINT);
    let expected = f64::from(ALBEDO) / PI * 2.0 * face * face * 0.5;
    for integrator in ALL {
        let spp = if integrator == Integrator::Path { 512 } else { 16 };
        let found = measured(&world, &with(integrator, spp, 6));
        assert!((found - expected).abs() < 0.1 * expected, "{integrator}: {found}, not {expected}");
    }
}
