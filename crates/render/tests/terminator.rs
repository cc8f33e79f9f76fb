// SPDX-License-Identifier: GPL-3.0-or-later
//! Light ends on a coarse ball where it ends on a round one, not along its facets. Source: [Hanika2021]; original.

use crate::common::*;
use gnurt_render::{Integrator, Silent, render};
use gnurt_scene::{Light, MaterialId, Mesh, Scene};

const SIZE: u32 = 96;
const TO_LIGHT: [f32; 3] = [1.0, 0.0, 0.0];

/// A ball in light from +x.
fn ball(smooth: bool) -> Scene {
    let mut scene = Scene::new();
    let material: MaterialId = matte(&mut scene, [1.0; 3]);
    let mesh = sphere([0.0; 3], 1.0, 7, material);
    put_mesh(&mut scene, if smooth { mesh } else { Mesh { normals: Vec::new(), ..mesh } });
    scene.add_light(Light::Directional {
        direction: [-1.0, 0.0, 0.0],
        irradiance: [std::f32::consts::PI; 3],
        angle: 0.0,
    });
    scene
}

/// Cosine to the light by the normals that rays see, and radiance, for each pixel on the ball.
fn lit(scene: &Scene, eye: [f32; 3], force_diffuse: bool) -> Vec<(f32, f32)> {
    let world = world_of(scene, force_diffuse);
    let picture = |integrator| {
        let options = gnurt_render::RenderOptions { integrator, ..options(SIZE, SIZE, 1) };
        let camera = camera(eye, [0.0; 3], 35.0);
        render(&world, &camera, &options, &pool(1), &Silent).expect("the options are sound").picture.color
    };
    let (normals, light) = (picture(Integrator::Normals), picture(Integrator::Whitted));
    let on_ball = normals.iter().zip(&light).filter(|(n, _)| n[3] > 0.0);
    let cosine = |n: &[f32; 4]| (0..3).map(|k| (2.0 * n[k] - 1.0) * TO_LIGHT[k]).sum();
    on_ball.map(|(n, l)| (cosine(n), l[0])).collect()
}

#[test]
fn coarse_balls_have_no_staircase() {
    for eye in [[0.0, -4.0, 0.0], [-2.0, -3.0, 1.0], [1.0, -1.0, 3.7]] {
        let pixels = lit(&ball(true), eye, false);
        assert!(pixels.len() > 2000, "the ball is in the picture: {} pixels", pixels.len());
        // The last grey levels before the end may go to either side.
        let wrong = pixels.iter().filter(|(cos, light)| (*cos > 0.02) != (*light > 0.0) && cos.abs() > 0.02);
        let share = wrong.count() as f64 / pixels.len() as f64;
        assert!(
            share < 0.005,
            "seen from {eye:?} {share} of the ball is lit where it should not be, or dark"
        );
        let round = pixels.iter().filter(|(cos, _)| *cos > 0.0).count() as f64;
        let found = pixels.iter().filter(|(_, light)| *light > 0.0).count() as f64;
        assert_close(found, round, 0.02, "lit pixels, against the round ball");
    }
}

#[test]
fn flat_meshes_keep_their_facets() {
    for (scene, force_diffuse) in [(ball(false), false), (ball(true), true)] {
        for (cos, light) in lit(&scene, [-2.0, -3.0, 1.0], force_diffuse) {
            // A convex body shades itself exactly where a facet turns away.
            let expected = cos.max(0.0);
            assert!((light - expected).abs() < 2e-3, "{light} where the cosine is {cos}");
        }
    }
}

#[test]
fn no_light_leaks_into_hollow_balls() {
    let pixels = lit(&ball(true), [0.0, -0.5, 0.0], false);
    assert!(!pixels.is_empty() && pixels.iter().all(|(_, light)| *light == 0.0), "it is closed");
}
