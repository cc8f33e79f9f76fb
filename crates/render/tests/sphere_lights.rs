// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres that emit: closed forms, shaders, transforms, motion, mirrors, and the integrators against each other.

use std::f64::consts::PI;

use glam::Vec3;
use gnurt_render::{Integrator, RenderOptions, Silent, World, render};
use gnurt_scene::{Affine, Material, Scene, Surface};
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{SurfaceBatch, SurfaceShader};

use crate::common::*;

const ALL: [Integrator; 5] = [
    Integrator::Whitted,
    Integrator::Path,
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];
const CENTER: [f32; 3] = [0.6, -0.3, 1.2];
const RADIUS: f32 = 0.4;
/// The visible point of the floor.
const SPOT: [f32; 3] = [0.1, 0.2, 0.0];

/// The mean of a small picture of that point.
fn measured(world: &World, options: &RenderOptions) -> f64 {
    let view = camera([0.1, -1.5, 0.8], SPOT, 0.01);
    mean(&render(world, &view, options, &pool(1), &Silent).expect("sound options").picture)[0]
}

/// Direct light at the visible point of a floor of albedo 0.6, from a sphere whose radiance depends on the outward normal where
/// it is seen: midpoints over the cone of directions.
fn expected(radiance: impl Fn(Vec3) -> f64) -> f64 {
    let offset = Vec3::from(CENTER) - Vec3::from(SPOT);
    let (distance, radius) = (f64::from(offset.length()), f64::from(RADIUS));
    let axis = offset.normalize();
    let [side, up] = [axis.any_orthonormal_pair().0, axis.any_orthonormal_pair().1];
    let width = 1.0 - (1.0 - (radius / distance).powi(2)).sqrt();
    const N: usize = 512;
    let cell = 2.0 * PI * width / (N * N) as f64;
    let mut sum = 0.0;
    for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
        let cos = 1.0 - width * (i as f64 + 0.5) / N as f64;
        let (sin, turn) = ((1.0 - cos * cos).sqrt(), 2.0 * PI * (j as f64 + 0.5) / N as f64);
        let around = side * (sin * turn.cos()) as f32 + up * (sin * turn.sin()) as f32;
        let dir = axis * cos as f32 + around;
        let t = distance * cos - (radius * radius - (distance * sin).powi(2)).max(0.0).sqrt();
        let normal = (Vec3::from(SPOT) + dir * t as f32 - Vec3::from(CENTER)) / RADIUS;
        sum += radiance(normal) * f64::from(dir.z) * cell;
    }
    0.6 / PI * sum
}

#[test]
fn floors_are_lit_as_the_closed_form_says() {
    let offset = Vec3::from(CENTER) - Vec3::from(SPOT);
    let exact = 0.6 * 3.0 * f64::from((RADIUS / offset.length()).powi(2) * offset.z / offset.length());
    assert_close(expected(|_| 3.0), exact, 1e-4, "the cone's integral");
    for (scale, place) in [(1.0_f32, Affine::IDENTITY), (0.5, Affine::scale([0.5, -0.5, 0.5]))] {
        let mut scene = floor(0.6, 10.0);
        let lamp = emitter(&mut scene, [3.0, 2.0, 1.0]);
        let [x, y, z] = CENTER.map(|x| x / scale);
        let mesh = scene.add_mesh(ball([x, if scale < 1.0 { -y } else { y }, z], RADIUS / scale, lamp));
        let object = scene.add_object_of("lamp", vec![mesh]);
        scene.instantiate(object, place);
        let world = world_of(&scene, false);
        for integrator in ALL {
            let options = RenderOptions { integrator, max_depth: 2, vpls: 256, ..options(4, 4, 64) };
            let close = if integrator == Integrator::Path { 1e-3 } else { 0.01 };
            assert_close(measured(&world, &options), exact, close, &format!("{integrator}, scale {scale}"));
        }
    }
}

/// More above than below, and more seen straight on.
struct Uneven;

impl SurfaceShader for Uneven {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let light = if hits.front(i) { 1.0 - 0.9 * hits.ng.get(i).z } else { 0.0 };
            out.emit(i, Vec3::splat(light));
        }
    }

    fn emits(&self) -> bool {
        true
    }
}

#[test]
fn shaders_say_how_spheres_shine() {
    let mut scene = floor(0.6, 10.0);
    let lamp = scene.add_material(Material::of("lamp", Surface::Shader(0)));
    put_mesh(&mut scene, ball(CENTER, RADIUS, lamp));
    let world = world_with(&scene, Uneven);
    let exact = expected(|normal| f64::from(1.0 - 0.9 * normal.z));
    for integrator in ALL {
        let options = RenderOptions { integrator, max_depth: 2, vpls: 256, ..options(4, 4, 64) };
        assert_close(measured(&world, &options), exact, 0.015, &format!("{integrator}"));
    }
}

#[test]
fn integrators_agree_below_a_ceiling() {
    let mut scene = floor(0.6, 3.0);
    let [grey, lamp] = [matte(&mut scene, [0.7; 3]), emitter(&mut scene, [4.0; 3])];
    put_mesh(&mut scene, quad([-3.0, -3.0, 2.0], [0.0, 6.0, 0.0], [6.0, 0.0, 0.0], grey));
    put_mesh(&mut scene, ball(CENTER, RADIUS, lamp));
    let world = world_of(&scene, false);
    let by = |integrator, spp| {
        let options = RenderOptions { integrator, max_depth: 5, vpls: 128, ..options(4, 4, spp) };
        measured(&world, &options)
    };
    let paths = by(Integrator::Path, 1024);
    assert!(paths > 1.2 * expected(|_| 4.0), "the ceiling sends much of it back: {paths}");
    for integrator in &ALL[2..] {
        assert_close(by(*integrator, 32), paths, 0.02, &format!("{integrator}"));
    }
}

/// A sphere that its instance stretches is no light that is sampled; scattered rays find it.
#[test]
fn stretched_spheres_shine_too() {
    let picture = |stretch: [f32; 3], spp: u32| {
        let mut scene = floor(0.6, 10.0);
        let lamp = emitter(&mut scene, [3.0; 3]);
        let mesh = scene.add_mesh(ball([0.0; 3], RADIUS, lamp));
        let object = scene.add_object_of("lamp", vec![mesh]);
        scene.instantiate(
            object,
            Affine::translation(CENTER.map(Into::into)) * Affine::scale(stretch.map(Into::into)),
        );
        let options = RenderOptions { integrator: Integrator::Path, max_depth: 2, ..options(8, 8, spp) };
        measured(&world_of(&scene, false), &options)
    };
    let exact = expected(|_| 3.0);
    assert_close(picture([1.0; 3], 16), exact, 2e-3, "as it stands");
    assert_close(picture([1.0, 1.001, 1.0], 1024), exact, 0.02, "hardly stretched");
}

/// A mirror shows the lamp itself, and rough metal has the light of both strategies.
#[test]
fn rays_that_meet_a_sphere_have_their_share() {
    let mut scene = floor(0.6, 10.0);
    let lamp = emitter(&mut scene, [3.0; 3]);
    put_mesh(&mut scene, ball(CENTER, RADIUS, lamp));
    let seen = radiance_at(&scene, [0.6, -3.0, 1.2], CENTER, 1)[0];
    assert_close(seen, 3.0, 1e-6, "the camera sees its radiance");
    // The floor as metal whose lobe is wider and narrower than the lamp: by light samples alone and with both the same.
    for roughness in [0.1, 0.3, 0.6] {
        let mut scene = Scene::default();
        let metal = Surface::Metal { eta: [0.2, 0.9, 1.2], k: [3.9, 2.4, 2.2], roughness };
        let metal = scene.add_material(Material::of("metal", metal));
        put_mesh(&mut scene, quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], metal));
        let lamp = emitter(&mut scene, [3.0; 3]);
        let tessellated = {
            let mut scene = scene.clone();
            put_mesh(&mut scene, sphere(CENTER, RADIUS, 64, lamp));
            world_of(&scene, false)
        };
        put_mesh(&mut scene, ball(CENTER, RADIUS, lamp));
        let options = RenderOptions { integrator: Integrator::Path, max_depth: 2, ..options(16, 16, 256) };
        let view = camera([2.0, -2.0, 1.2], [0.9, -0.6, 0.0], 60.0);
        let by = |world: &World| {
            mean(&render(world, &view, &options, &pool(1), &Silent).expect("sound").picture)[0]
        };
        assert_close(by(&world_of(&scene, false)), by(&tessellated), 0.01, &format!("roughness {roughness}"));
    }
}
