// SPDX-License-Identifier: GPL-3.0-or-later
//! Holdouts: holes in the picture as large as the thing, which mirrors and shadows still show.

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Integrator, LightLayer, RenderOptions, Silent, render};
use gnurt_scene::material::{Alpha, Opacity, OpacityChannel};
use gnurt_scene::{Affine, InstanceId, Material, Scene};

/// A floor and a ball, behind a net that is there in part; the ball is a holdout.
fn scene(is_held: bool, with_net: bool) -> Scene {
    let mut scene = floor(0.6, 4.0);
    let red = matte(&mut scene, [0.8, 0.1, 0.1]);
    let mesh = scene.add_mesh(sphere([0.0, 0.0, 0.8], 0.8, 16, red));
    let object = scene.add_object_of("ball", vec![mesh]);
    let ball = scene.instantiate(object, Affine::IDENTITY);
    if with_net {
        let opacity = Opacity { factor: 0.25, texture: None, channel: OpacityChannel::Alpha };
        let net = Material { alpha: Alpha::Blend { opacity }, ..Material::matte("net", [0.0; 3]) };
        let net = scene.add_material(net);
        put_mesh(&mut scene, quad([-4.0, -2.0, -1.0], [8.0, 0.0, 0.0], [0.0, 0.0, 5.0], net));
    }
    scene.add_light(environment([1.0; 3]));
    if is_held {
        scene.labels_mut().holdouts.insert(ball);
    }
    scene
}

fn seen(scene: &Scene, integrator: Integrator) -> Picture {
    let layers = if integrator == Integrator::Path {
        vec![LightLayer::of_word("diffuse").expect("a word")]
    } else {
        Vec::new()
    };
    let options = RenderOptions { integrator, aovs: true, light_layers: layers, ..options(40, 30, 16) };
    let view = camera([0.0, -5.0, 2.0], [0.0, 0.0, 0.6], 40.0);
    render(&world_of(scene, false), &view, &options, &pool(2), &Silent).expect("sound").picture
}

#[test]
fn holdouts_leave_holes() {
    for integrator in
        [Integrator::Path, Integrator::Whitted, Integrator::InstantRadiosity, Integrator::Normals]
    {
        let [plain, held] = [false, true].map(|is_held| seen(&scene(is_held, false), integrator));
        let mut alone = scene(false, false);
        alone.edit_instance(InstanceId(0)).visible = false;
        let alone = seen(&alone, integrator);
        let mut holes = 0;
        for (i, ball) in alone.color.iter().enumerate() {
            let [full, hole] = [&plain, &held].map(|picture| picture.color[i]);
            assert!(
                (full[3] - ball[3] - hole[3]).abs() < 1e-6,
                "{integrator}, {i}: {full:?} {ball:?} {hole:?}"
            );
            if ball[3] == 1.0 {
                holes += 1;
                assert_eq!(hole, [0.0; 4], "{integrator}: a hole");
            } else if ball[3] == 0.0 {
                assert_eq!(
                    hole, full,
                    "{integrator}: all else is as before, shadows and reflected red as well"
                );
            }
        }
        assert!(holes > 20, "{integrator}: {holes} pixels of the ball");
    }
}

#[test]
fn holes_are_seen_through_nets() {
    let picture = seen(&scene(true, true), Integrator::Path);
    let middle = 15 * 40 + 20;
    let [r, g, b, a] = picture.color[middle];
    assert!(
        (a - 0.25).abs() < 0.2 && r + g + b == 0.0,
        "a black net over nothing: {:?}",
        picture.color[middle]
    );
}
