// SPDX-License-Identifier: GPL-3.0-or-later
//! The same picture, bit for bit, whatever threads, passes, crops and kernels do.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crate::common::*;
use gnurt_accel::RayBatch;
use gnurt_render::{Integrator, Progress, RenderOptions, SceneCamera, Silent, render, trace_pixel};
use gnurt_scene::material::Color;
use gnurt_scene::{Light, Material, Scene, Surface};
use gnurt_shading::{CameraSamples, CameraShader};
use gnurt_simd::Level;

/// A bit of everything.
fn still_life() -> (Scene, SceneCamera) {
    let mut scene = floor(0.6, 5.0);
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [0.9; 3],
        interior: Default::default(),
    };
    let mirror = Surface::Mirror { reflectance: Color::constant([0.9; 3]) };
    let coat = Surface::MetallicRoughness {
        base_color: Color::constant([0.8, 0.3, 0.2]),
        metallic: 0.2,
        roughness: 0.15,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture: None,
    };
    for (x, surface) in [(-1.5, glass), (0.0, mirror), (1.5, coat)] {
        let material = scene.add_material(Material::of("", surface));
        put_mesh(&mut scene, sphere([x, 0.0, 0.7], 0.7, 16, material));
    }
    let light = emitter(&mut scene, [8.0, 7.0, 6.0]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 4.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], light));
    scene.add_light(environment([0.2, 0.3, 0.5]));
    scene.add_light(Light::Point { position: [-3.0, -3.0, 2.0], intensity: [4.0; 3], radius: 0.0 });
    (scene, camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0))
}

fn bits(picture: &gnurt_image::Picture) -> Vec<[u32; 4]> {
    picture.color.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn picture(options: &RenderOptions, threads: usize) -> gnurt_image::Picture {
    let (scene, camera) = still_life();
    let world = world_of(&scene, false);
    render(&world, &camera, options, &pool(threads), &Silent).expect("sound options").picture
}

#[test]
fn threads_do_not_matter() {
    let options = RenderOptions { aovs: true, ..options(61, 43, 5) };
    let one = picture(&options, 1);
    for threads in [2, 7] {
        let many = picture(&options, threads);
        assert!(bits(&one) == bits(&many), "{threads} threads give other bits");
        assert!(one.layers == many.layers, "{threads} threads give other layers");
    }
    let other_seed = picture(&RenderOptions { seed: 1, ..options }, 2);
    assert!(bits(&one) != bits(&other_seed), "another seed is another picture");
}

#[test]
fn levels_do_not_matter() {
    let integrator = Integrator::InstantRadiosity;
    let virtual_lights = RenderOptions { integrator, vpls: 512, ..options(16, 12, 1) };
    for options in [options(48, 32, 2), virtual_lights] {
        let best = picture(&options, 2);
        for level in Level::available() {
            let other = picture(&RenderOptions { level, ..options.clone() }, 2);
            assert!(bits(&best) == bits(&other), "{level} gives other bits by {}", options.integrator);
        }
    }
}

#[test]
fn crops_show_the_full_picture() {
    let full = picture(&options(61, 43, 3), 2);
    let crop = [13, 9, 50, 31];
    let cropped = picture(&RenderOptions { crop: Some(crop), ..options(61, 43, 3) }, 2);
    assert_eq!((cropped.width, cropped.height), (61, 43), "the picture keeps its size");
    for (x, y) in (0..43).flat_map(|y| (0..61).map(move |x| (x, y))) {
        let inside = x >= crop[0] && x < crop[2] && y >= crop[1] && y < crop[3];
        let expected = if inside { full.pixel(x, y) } else { Some([0.0; 4]) };
        assert_eq!(cropped.pixel(x, y), expected, "pixel {x},{y}");
    }
}

/// Stops after a number of samples, wherever that is.
struct StopAfter(u64, AtomicU64);

impl Progress for StopAfter {
    fn update(&self, done: f64, samples: u64) {
        assert!((0.0..=1.0).contains(&done), "{done} is a share");
        self.1.fetch_max(samples, Ordering::Relaxed);
    }

    fn should_stop(&self) -> bool {
        self.1.load(Ordering::Relaxed) >= self.0
    }
}

#[test]
fn stopped_pictures_are_those_of_fewer_samples() {
    let (scene, camera) = still_life();
    let world = world_of(&scene, false);
    let options = options(64, 48, 40);
    let pixels = 64 * 48;
    let stop = StopAfter(4 * pixels, AtomicU64::new(0));
    let frame = render(&world, &camera, &options, &pool(1), &stop).expect("sound options");
    assert!(!frame.stats.complete, "it was stopped");
    let range = (frame.stats.spp_min, frame.stats.spp_max);
    assert_eq!(range, (4, 4), "four samples of each pixel end with a pass");
    // Passes are cut otherwise when there is less to do: sums must not notice.
    let four = picture(&RenderOptions { spp: 4, ..options }, 2);
    assert!(bits(&frame.picture) == bits(&four), "passes do not matter");
}

#[test]
fn time_limits_hold() {
    let (scene, camera) = still_life();
    let world = world_of(&scene, false);
    let limit = Duration::from_millis(300);
    let options = RenderOptions { time_limit: Some(limit), ..options(320, 240, 1_000_000) };
    let start = std::time::Instant::now();
    let frame = render(&world, &camera, &options, &pool(2), &Silent).expect("sound options");
    assert!(start.elapsed() < limit + Duration::from_secs(2), "it ends within 2 s of its limit");
    assert!(!frame.stats.complete && frame.stats.samples > 0, "with a part of the samples");
}

/// A camera that gives nonsense: no rays, NaN, zero directions.
struct BrokenCamera;

impl CameraShader for BrokenCamera {
    fn rays(&self, samples: &CameraSamples, _aspect: f32, out: &mut RayBatch) {
        for i in 0..samples.len() / 2 {
            let bad = if i % 2 == 0 { f32::NAN } else { 0.0 };
            out.push(gnurt_accel::Ray::new([bad, 0.0, 0.0], [0.0, bad, 0.0]));
        }
    }
}

#[test]
fn broken_cameras_and_materials_leave_black_pixels() {
    let (mut scene, camera) = still_life();
    let world = world_of(&scene, false);
    let broken = render(&world, &BrokenCamera, &options(20, 20, 2), &pool(2), &Silent).expect("no panic");
    assert!(broken.picture.color.iter().flatten().all(|x| x.is_finite()), "numbers everywhere");
    scene.edit_material(gnurt_scene::MaterialId(0)).surface =
        Surface::Matte { base_color: Color::constant([f32::NAN, f32::INFINITY, 1.0]) };
    let frame = frame(&scene, &camera, &options(20, 20, 2));
    assert!(frame.stats.bad_samples > 0, "bad samples are counted");
    assert!(frame.picture.color.iter().flatten().all(|x| x.is_finite()), "and dropped");
}

#[test]
fn traces_tell_the_same_radiance() {
    let (scene, camera) = still_life();
    let world = world_of(&scene, false);
    let options = options(32, 24, 1);
    let frame = render(&world, &camera, &options, &pool(2), &Silent).expect("sound options");
    for (x, y) in [(9, 14), (16, 14), (22, 15), (2, 20), (0, 0)] {
        let trace = trace_pixel(&world, &camera, &options, x, y).expect("inside");
        let [r, g, b, _] = frame.picture.pixel(x, y).expect("inside");
        assert_eq!(trace.radiance, [r, g, b], "pixel {x},{y}:\n{trace}");
        assert!(trace.to_string().contains("ray"), "it says what happened");
    }
    assert!(trace_pixel(&world, &camera, &options, 32, 0).is_err(), "outside");
}

#[test]
fn previews_and_heat_maps() {
    let (scene, camera) = still_life();
    for integrator in [Integrator::Eyelight, Integrator::Normals] {
        let options = RenderOptions { integrator, heatmap: true, ..options(40, 30, 2) };
        let frame = frame(&scene, &camera, &options);
        let lit = frame.picture.color.iter().filter(|pixel| pixel[0] > 0.0).count();
        assert!(lit > 600, "{integrator}: {lit} pixels show something");
        let heat = frame.heatmap.expect("it was asked for");
        assert!(heat.color.iter().any(|pixel| pixel[0] > 0.5), "some pixel is hot");
        assert_eq!(frame.stats.shadow_rays, 0, "{integrator} needs no lights");
    }
}
