// SPDX-License-Identifier: GPL-3.0-or-later
//! Searches in and near the focus of a ball of glass: their means beside the sums of all ways of light. Of counts that end after
//! 24 walks the mean is 0.92, which fails.

use std::f64::consts::PI;

use glam::DVec3;

use crate::common::chains::Ball;
use crate::common::*;
use gnurt_render::{Caustics, Integrator, RenderOptions, Silent, render};
use gnurt_scene::detail::Interior;
use gnurt_scene::{Light, Material, Surface};

const ALBEDO: f64 = 0.7;
const CENTER: [f32; 3] = [0.6, 0.3, 0.7];
const RADIUS: f32 = 0.6;
const LAMP: [f32; 3] = [-1.05, -0.65, 2.8];
/// Directions along an edge of a triangle: more find no more ways.
const DENSITY: usize = 2;
const POINTS: u32 = 48;
const SAMPLES: u32 = 1536;

/// A mesh of a few thousand triangles, whose facets part the focus, and points in it and to a fifth of the ball's width beside it.
#[test]
fn searches_sum_all_ways_of_light() {
    let (reflectance, transmittance, interior) = ([1.0; 3], [1.0; 3], Interior::default());
    let glass = Surface::Dielectric { ior: 1.5, reflectance, transmittance, interior };
    let mut scene = floor(ALBEDO as f32, 6.0);
    let glass = scene.add_material(Material::of("", glass));
    let mesh = sphere(CENTER, RADIUS, 24, glass);
    let ball = Ball::new(&mesh, CENTER, 1.5);
    put_mesh(&mut scene, mesh);
    scene.add_light(Light::Point { position: LAMP, intensity: [1.0; 3], radius: 0.0 });
    let world = world_of(&scene, false);
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let (mut ratios, mut most_ways) = (Vec::new(), 0);
    for i in 0..POINTS {
        let number = |by: f64| ((f64::from(i) + 0.5) * by).fract() as f32 - 0.5;
        let p = [1.15 + 0.24 * number(0.754_877), 0.62 + 0.24 * number(0.569_840), 0.0];
        let ways = ball.ways(wide(p), wide(LAMP), DENSITY);
        most_ways = most_ways.max(ways.len());
        let expected = ALBEDO / PI * ways.iter().map(|way| way.light).sum::<f64>();
        let view = camera([p[0] + 0.01, p[1], 0.05], p, 0.01);
        let options = RenderOptions {
            integrator: Integrator::Path,
            max_depth: 4,
            caustics: Caustics::On,
            seed: u64::from(i),
            ..options(1, 1, SAMPLES)
        };
        let found =
            mean(&render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture)[0];
        if ways.is_empty() {
            assert_eq!(found, 0.0, "no way leads to {p:?}");
        } else {
            ratios.push(found / expected);
        }
    }
    let n = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let error = (ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
    assert!(most_ways > 2, "{most_ways}: no focus");
    assert!(error < 0.02, "enough samples to tell: {error}");
    assert!((mean - 1.0).abs() < 3.0 * error, "{mean} of the sum, standard error {error}");
}
