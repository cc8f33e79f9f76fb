// SPDX-License-Identifier: GPL-3.0-or-later
//! A floor that only catches shadow: not seen where no shadow is, as dark as a true floor where one is. //! the oracle is a Lambertian floor of the same albedo under the same sky.

use crate::common::*;
use gnurt_image::{Opacity, Picture};
use gnurt_render::{Integrator, RenderOptions, Silent, render};
use gnurt_scene::{Material, Scene, Surface};

const SKY: f32 = 0.5;
const ALBEDO: f32 = 0.6;

/// A red ball on a floor under a sky of one colour, or no ball.
fn scene(floor: Surface, ball: bool) -> Scene {
    let mut scene = Scene::new();
    let floor = scene.add_material(Material::of("floor", floor));
    put_mesh(&mut scene, quad([-50.0, -50.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], floor));
    if ball {
        let red = scene.add_material(Material::matte("red", [0.7, 0.1, 0.1]));
        put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 1.0, 24, red));
    }
    scene.add_light(environment([SKY; 3]));
    scene
}

fn picture(scene: &Scene, integrator: Integrator, spp: u32) -> Picture {
    let options =
        RenderOptions { width: 32, height: 24, spp, integrator, aovs: true, ..RenderOptions::default() };
    let camera = camera([0.0, -8.0, 3.0], [0.0, 0.0, 0.8], 40.0);
    render(&world_of(scene, false), &camera, &options, &pool(1), &Silent).expect("sound options").picture
}

/// A floor with its own unshadowed radiance as backdrop: under the whole sky, albedo times sky.
fn catcher() -> Surface {
    Surface::ShadowCatcher { albedo: [ALBEDO; 3], radiance: [ALBEDO * SKY; 3] }
}

/// With an opacity, an emission or bumps it catches shadow as it does without.
#[test]
fn it_may_be_there_in_part() {
    use gnurt_scene::material::{Alpha, Opacity as Share, OpacityChannel};
    let with = |alpha: Alpha| {
        let mut scene = Scene::new();
        let floor = scene.add_material(Material { alpha, ..Material::of("floor", catcher()) });
        put_mesh(&mut scene, quad([-50.0, -50.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], floor));
        scene.add_light(environment([SKY; 3]));
        picture(&scene, Integrator::Path, 64)
    };
    let opacity = Share { factor: 0.99, texture: None, channel: OpacityChannel::Alpha };
    let (whole, part) = (with(Alpha::Opaque), with(Alpha::Blend { opacity }));
    assert_eq!(part.opacity, whole.opacity, "still a picture with opacity");
    let row = 22 * 32..23 * 32;
    let mean = |picture: &Picture| picture.color[row.clone()].iter().map(|p| p[0] / 32.0).sum::<f32>();
    let expected = 0.99 * mean(&whole) + 0.01 * SKY;
    assert!((mean(&part) - expected).abs() < 4e-3 * expected, "{} in place of {expected}", mean(&part));
    for (i, pixel) in part.color[row].iter().enumerate() {
        // A sample in a hundred sees the sky below; no other noise is there.
        let off = (pixel[0] - ALBEDO * SKY) / SKY;
        assert!(pixel[3] < 0.01 && (-1e-5..0.04).contains(&off), "pixel {i} is clear: {pixel:?}");
    }
}

#[test]
fn nothing_is_seen_of_it_without_shadow() {
    let picture = picture(&scene(catcher(), false), Integrator::Path, 2);
    assert_eq!(picture.opacity, Opacity::Associated, "so that it can be put over something");
    let floor = ALBEDO * SKY;
    for (i, (pixel, behind)) in picture.color.iter().zip(background(&picture)).enumerate() {
        assert_eq!((pixel[3], behind[3]), (0.0, 1.0), "pixel {i} is clear");
        for k in 0..3 {
            let is_sky = pixel[k] == SKY;
            assert!(is_sky || (floor - 1e-5..SKY).contains(&pixel[k]), "pixel {i} shows {}", pixel[k]);
            assert!((pixel[k] - behind[k]).abs() < 1e-5, "and nothing in front of it");
        }
    }
}

#[test]
fn shadows_are_those_of_a_true_floor() {
    let matte = Surface::Matte { base_color: gnurt_scene::material::Color::constant([ALBEDO; 3]) };
    let truth = picture(&scene(matte, true), Integrator::Path, 256);
    for integrator in [Integrator::Path, Integrator::InstantRadiosity] {
        let found = picture(&scene(catcher(), true), integrator, 256);
        let mean = |picture: &Picture, rows: std::ops::Range<usize>| -> [f64; 3] {
            let pixels = &picture.color[rows.start * 32..rows.end * 32];
            [0, 1, 2].map(|k| pixels.iter().map(|p| f64::from(p[k])).sum::<f64>() / pixels.len() as f64)
        };
        for rows in [0..6, 6..12, 12..18, 18..24] {
            let (a, b) = (mean(&found, rows.clone()), mean(&truth, rows.clone()));
            for k in 0..3 {
                assert!((a[k] / b[k] - 1.0).abs() < 0.01, "{integrator}, rows {rows:?}: {a:?} for {b:?}");
            }
        }
    }
}

#[test]
fn its_opacity_is_its_shadow() {
    let picture = picture(&scene(catcher(), true), Integrator::Path, 64);
    let behind = background(&picture);
    // In front of the ball, in its shadow; and far from it.
    let (near, far) = (17 * 32 + 16, 22 * 32 + 1);
    assert!(picture.color[near][3] > 0.1, "{:?}", picture.color[near]);
    assert!(picture.color[far][3] < 0.05, "{:?}", picture.color[far]);
    for (pixel, behind) in picture.color.iter().zip(&behind) {
        assert!(
            (pixel[3] + behind[3] - 1.0).abs() < 1e-6 && (0.0..=1.0).contains(&pixel[3]),
            "{pixel:?} {behind:?}"
        );
    }
    // The foreground plus the background is the picture, and the foreground is not negative except for noise.
    let front = picture.color.iter().zip(&behind).map(|(a, b)| a[0] - b[0]);
    assert!(front.fold(0.0, f32::min) > -0.02, "associated");
}
