// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures that grow are the pictures that are rendered at once, bit for bit.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Accumulation, Integrator, Progress, RenderOptions, SceneCamera, Silent, World, render};
use gnurt_scene::material::Color;
use gnurt_scene::{Light, Material, Surface};

/// A mirror and a matte floor under two lights, one of them sampled.
fn corner() -> (World, SceneCamera) {
    let mut scene = floor(0.6, 5.0);
    let mirror = Material::of("", Surface::Mirror { reflectance: Color::constant([0.9; 3]) });
    let mirror = scene.add_material(mirror);
    put_mesh(&mut scene, sphere([0.0, 0.0, 0.7], 0.7, 8, mirror));
    let light = emitter(&mut scene, [8.0, 7.0, 6.0]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 4.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], light));
    scene.add_light(Light::Point { position: [-3.0, -3.0, 2.0], intensity: [4.0; 3], radius: 0.0 });
    (world_of(&scene, false), camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0))
}

fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    picture.color.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Stops once this many samples were taken, in the middle of whatever is done.
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
fn passes_threads_and_stops_do_not_matter() {
    let (world, camera) = corner();
    let options = RenderOptions { aovs: true, heatmap: true, ..options(61, 43, 9) };
    let whole = render(&world, &camera, &options, &pool(2), &Silent).expect("sound options");
    for threads in [1, 2, 7] {
        let pool = pool(threads);
        let mut grown = Accumulation::new(options.clone()).expect("sound options");
        let mut taken = Vec::new();
        for (samples, stop) in [(1, 400), (2, u64::MAX), (1, 9_000), (3, 14_000), (100, u64::MAX)] {
            let stop = StopAfter(stop, AtomicU64::new(0));
            grown.pass(&world, &camera, samples, &pool, &stop);
            taken.push(grown.samples());
        }
        assert_eq!(taken[0], 0, "the first pass was stopped: {taken:?}");
        assert!(taken.is_sorted() && taken[4] == 9, "no sample is lost: {taken:?}");
        assert!(grown.is_complete() && grown.stats().complete, "all samples are there");
        let samples = grown.stats().samples;
        assert_eq!(samples, 61 * 43 * 9, "each sample was taken once");
        assert!(bits(&grown.picture()) == bits(&whole.picture), "{threads} threads: other bits");
        assert!(grown.picture().layers == whole.picture.layers, "{threads} threads: other layers");
        assert!(grown.heatmap() == whole.heatmap, "{threads} threads: other costs");
        assert!(grown.pass(&world, &camera, 1, &pool, &Silent), "there is nothing left to do");
        assert_eq!(grown.stats().samples, samples, "and nothing is done");
    }
}

#[test]
fn each_pass_shows_the_picture_of_its_samples() {
    let (world, camera) = corner();
    let pool = pool(2);
    let mut grown = Accumulation::new(options(40, 30, 5)).expect("sound options");
    assert!(grown.picture().color.iter().all(|&pixel| pixel == [0.0; 4]), "nothing is seen before");
    for spp in 1..=3 {
        assert!(grown.pass(&world, &camera, 1, &pool, &Silent), "nobody stops it");
        let frame = render(&world, &camera, &options(40, 30, spp), &pool, &Silent).expect("sound options");
        assert!(bits(&grown.picture()) == bits(&frame.picture), "after {spp} samples");
    }
}

/// State that virtual lights of all passes share is computed once, for one camera.
#[test]
fn passes_share_what_they_learn() {
    let (_, camera) = corner();
    let mut scene = floor(0.6, 5.0);
    for i in 0..6 {
        let position = [i as f32 - 2.5, 0.3 * i as f32, 0.2 + 0.1 * i as f32];
        scene.add_light(Light::Point { position, intensity: [1.0 + i as f32; 3], radius: 0.0 });
    }
    let (world, pool) = (world_of(&scene, false), pool(2));
    let options = RenderOptions { integrator: Integrator::InstantRadiosity, vpls: 64, ..options(12, 9, 3) };
    let other = crate::common::camera([3.0, -5.0, 4.0], [2.0, 0.0, 0.6], 20.0);
    let mut grown = Accumulation::new(options.clone()).expect("sound options");
    grown.pass(&world, &other, 1, &pool, &Silent);
    grown.restart(options.clone()).expect("sound options");
    let rays: Vec<u64> = (0..3)
        .map(|_| {
            let before = grown.stats().secondary_rays;
            grown.pass(&world, &camera, 1, &pool, &Silent);
            grown.stats().secondary_rays - before
        })
        .collect();
    assert!(rays[1] < rays[0] / 2, "the first learns, others do not: {rays:?}");
    let frame = render(&world, &camera, &options, &pool, &Silent).expect("sound options");
    assert!(bits(&grown.picture()) == bits(&frame.picture), "another picture");
}

#[test]
fn restarts_forget_everything() {
    let (world, camera) = corner();
    let other = crate::common::camera([3.0, -5.0, 4.0], [0.0, 0.0, 0.6], 50.0);
    let pool = pool(2);
    let with_layers = RenderOptions { aovs: true, heatmap: true, ..options(40, 30, 2) };
    let mut grown = Accumulation::new(with_layers.clone()).expect("sound options");
    grown.pass(&world, &other, 2, &pool, &Silent);
    // The same size, another size, a crop.
    let cropped = RenderOptions { crop: Some([5, 18, 33, 50]), ..options(45, 50, 2) };
    for options in [with_layers, options(33, 20, 2), cropped] {
        grown.restart(options.clone()).expect("sound options");
        assert_eq!((grown.samples(), grown.stats().samples), (0, 0), "no sample is left");
        grown.pass(&world, &camera, 2, &pool, &Silent);
        let frame = render(&world, &camera, &options, &pool, &Silent).expect("sound options");
        assert!(grown.picture() == frame.picture, "{options:?}: another picture");
        assert!(grown.heatmap() == frame.heatmap, "{options:?}: other costs");
        let mut colors = vec![[0.0; 4]; frame.picture.color.len()];
        grown.write_colors(&mut colors, &pool);
        assert!(colors == frame.picture.color, "{options:?}: written otherwise");
        grown.write_colors(&mut colors[..37], &pool);
        grown.write_colors(&mut [], &pool);
    }
    let nothing = RenderOptions { width: 0, ..options(1, 1, 1) };
    assert!(grown.restart(nothing).is_err() && grown.is_complete(), "what fails changes nothing");
}
