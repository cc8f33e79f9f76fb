// SPDX-License-Identifier: GPL-3.0-or-later
//! Blue noise between pixels against independent errors: the same mean and error of pixels, less error of means over
//! neighbours. The noise of two seeds is their difference, in which the picture itself cancels out.

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Integrator, PixelNoise, RenderOptions};
use gnurt_scene::{Material, Scene};

const SIZE: usize = 64;

/// A floor under a lamp, half behind a screen.
fn lamp_and_screen() -> Scene {
    let mut scene = Scene::new();
    let white = matte(&mut scene, [0.7; 3]);
    let lamp = scene.add_material(Material { emission: [5.0; 3], ..Material::matte("lamp", [0.0; 3]) });
    put_mesh(&mut scene, quad([-4.0, 0.0, 4.0], [8.0, 0.0, 0.0], [0.0, 0.0, -8.0], white));
    put_mesh(&mut scene, quad([-1.0, 3.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], lamp));
    put_mesh(&mut scene, quad([-0.5, 1.0, -1.0], [1.5, 0.0, 0.0], [0.0, 0.0, 2.0], white));
    scene
}

fn picture(spp: u32, seed: u64, pixel_noise: PixelNoise, crop: Option<[u32; 4]>) -> Picture {
    let options = RenderOptions {
        integrator: Integrator::Path,
        max_depth: 2,
        seed,
        pixel_noise,
        crop,
        ..options(SIZE as u32, SIZE as u32, spp)
    };
    frame(&lamp_and_screen(), &camera([0.0, 0.5, 3.0], [0.0, 0.0, 0.0], 40.0), &options).picture
}

/// Mean, variance of pixels, and variance of means over 4 x 4 pixels times 16: equal to it where errors are independent.
fn statistics(spp: u32, noise: PixelNoise) -> [f64; 3] {
    let [a, b] = [1, 2].map(|seed| picture(spp, seed, noise, None));
    let red = |picture: &Picture, x: usize, y: usize| {
        f64::from(picture.pixel(x as u32, y as u32).expect("inside")[0])
    };
    let mut sums = [0.0; 3];
    for (left, top) in (0..SIZE).step_by(4).flat_map(|y| (0..SIZE).step_by(4).map(move |x| (x, y))) {
        let mut block = 0.0;
        for (x, y) in (top..top + 4).flat_map(|y| (left..left + 4).map(move |x| (x, y))) {
            let difference = red(&a, x, y) - red(&b, x, y);
            block += difference;
            sums[0] += red(&a, x, y);
            sums[1] += difference * difference;
        }
        sums[2] += block * block;
    }
    sums.map(|sum| sum / (SIZE * SIZE) as f64)
}

#[test]
fn blue_noise_cancels_out_between_neighbours() {
    // Sequences are evenly spread in blocks of powers of two only; more samples leave less to neighbours.
    for (spp, most) in [(1, 0.4), (4, 0.5), (6, 1.0), (16, 0.9)] {
        let [white, blue] = PixelNoise::ALL.map(|noise| statistics(spp, noise));
        let said = format!("{spp} samples: white {white:?}, blue {blue:?}");
        assert!((blue[0] / white[0] - 1.0).abs() < 0.03, "means: {said}");
        assert!(blue[1] < 1.15 * white[1], "errors of pixels: {said}");
        assert!((0.75..1.35).contains(&(white[2] / white[1])), "white is independent: {said}");
        assert!(blue[2] < most * white[2], "errors of 4 x 4 pixels: {said}");
    }
}

#[test]
fn a_part_of_a_picture_has_the_bits_of_the_whole() {
    let whole = picture(3, 7, PixelNoise::Blue, None);
    let part = picture(3, 7, PixelNoise::Blue, Some([13, 22, 41, 37]));
    for (x, y) in (22..37).flat_map(|y| (13..41).map(move |x| (x, y))) {
        assert_eq!(whole.pixel(x, y), part.pixel(x, y), "{x},{y}");
    }
}
