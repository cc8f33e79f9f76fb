// SPDX-License-Identifier: GPL-3.0-or-later
//! Neither acne nor leaks, from scenes of a tenth of a unit to those of a hundred thousand.

use crate::common::*;
use gnurt_render::{Silent, render};
use gnurt_scene::{Affine, Light, MaterialId, Scene};

/// Worlds are `scale` large and lie `away` times their size from the origin.
const SCALES: [f32; 5] = [0.1, 1.0, 37.0, 1e3, 1e5];

/// A ball on a floor under a directional light: where both are lit, nothing may be speckled.
#[test]
fn surfaces_do_not_shade_themselves() {
    for scale in SCALES {
        for away in [0.0, 3.0] {
            let at = |p: [f32; 3]| p.map(|x| (x + away) * scale);
            let mut scene = Scene::new();
            let white = matte(&mut scene, [1.0; 3]);
            let edge = 40.0 * scale;
            put_mesh(&mut scene, quad(at([-20.0, -20.0, 0.0]), [edge, 0.0, 0.0], [0.0, edge, 0.0], white));
            let irradiance = std::f32::consts::PI;
            scene.add_light(Light::Directional {
                direction: [0.3, 0.2, -0.01],
                irradiance: [irradiance; 3],
                angle: 0.0,
            });
            let view = camera(at([0.0, -6.0, 2.0]), at([0.0, 0.0, 0.0]), 40.0);
            let cos = 0.01 / (0.09_f64 + 0.04 + 0.0001).sqrt();
            let picture = frame(&scene, &view, &options(48, 32, 1)).picture;
            for (i, pixel) in picture.color.iter().enumerate().filter(|(_, pixel)| pixel[3] > 0.0) {
                assert_close(
                    f64::from(pixel[0]),
                    cos,
                    1e-2,
                    &format!("scale {scale}, away {away}, pixel {i}"),
                );
            }
        }
    }
}

/// A closed box with the light outside: all of its inside must be black, in the corners too.
#[test]
fn boxes_do_not_leak() {
    for scale in SCALES {
        for place_by_instance in [false, true] {
            let size = if place_by_instance { 1.0 } else { scale };
            let mut scene = Scene::new();
            let white = matte(&mut scene, [1.0; 3]);
            let meshes = cube(size, white).map(|mesh| scene.add_mesh(mesh));
            let object = scene.add_object_of("box", meshes.into());
            let factor = f64::from(scale / size);
            let turned = Affine::rotation([1.0, 2.0, 3.0], 0.7);
            scene.instantiate(object, turned * Affine::scale([factor; 3]));
            scene.add_light(Light::Point {
                position: [2.5 * scale; 3],
                intensity: [scale * scale; 3],
                radius: 0.0,
            });
            scene.add_light(environment([1.0; 3]));
            let view =
                camera([0.1 * scale, 0.05 * scale, 0.0], [0.3 * scale, 0.4 * scale, 0.2 * scale], 120.0);
            let world = world_of(&scene, false);
            let frame = render(&world, &view, &options(64, 64, 4), &pool(1), &Silent).expect("sound options");
            let leaks = frame.picture.color.iter().filter(|pixel| pixel[0] > 0.0 || pixel[3] < 1.0).count();
            assert_eq!(leaks, 0, "scale {scale}, by instance: {place_by_instance}");
        }
    }
}

/// Six faces with edges of twice the size, normals outwards.
fn cube(size: f32, material: MaterialId) -> [gnurt_scene::Mesh; 6] {
    let (s, e) = (size, 2.0 * size);
    [
        quad([-s, -s, -s], [0.0, e, 0.0], [e, 0.0, 0.0], material),
        quad([-s, -s, s], [e, 0.0, 0.0], [0.0, e, 0.0], material),
        quad([-s, -s, -s], [e, 0.0, 0.0], [0.0, 0.0, e], material),
        quad([-s, s, -s], [0.0, 0.0, e], [e, 0.0, 0.0], material),
        quad([-s, -s, -s], [0.0, 0.0, e], [0.0, e, 0.0], material),
        quad([s, -s, -s], [0.0, e, 0.0], [0.0, 0.0, e], material),
    ]
}
