// SPDX-License-Identifier: GPL-3.0-or-later
//! Holdouts: holes in the picture as large as the thing, which mirrors and shadows still show.

use std::sync::Arc;

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{
    CommitOptions, Integrator, LightLayer, RenderOptions, ShaderTable, Silent, World, render,
};
use gnurt_scene::material::{Alpha, Opacity, OpacityChannel};
use gnurt_scene::{Affine, InstanceId, Material, MaterialId, Scene, Surface};
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{SurfaceBatch, SurfaceShader};

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
    render(&world_of(scene, false), &view, &options, &pool(1), &Silent).expect("sound").picture
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

/// A grey surface that emits, and is a hole in this share.
struct Holed(f32);

impl SurfaceShader for Holed {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            out.emit(i, glam::Vec3::splat(0.5));
            out.hold_out(i, self.0);
        }
    }

    fn has_holes(&self) -> bool {
        true
    }
}

#[test]
fn closures_hold_out_their_share() {
    for integrator in [Integrator::Path, Integrator::Whitted, Integrator::InstantRadiosity] {
        let cases = [(1.0, false, false), (0.25, false, false), (0.25, false, true), (0.25, true, true)];
        for (share, net, aovs) in cases {
            let mut scene = scene(false, net);
            // The material of the ball.
            scene.edit_material(MaterialId(1)).surface = Surface::Shader(0);
            let table = ShaderTable { surfaces: vec![Arc::new(Holed(share))], ..ShaderTable::default() };
            let mut world = World::new();
            world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
            let options = RenderOptions { integrator, aovs, ..options(40, 30, if net { 64 } else { 2 }) };
            let view = camera([0.0, -5.0, 2.0], [0.0, 0.0, 0.6], 40.0);
            let picture = render(&world, &view, &options, &pool(1), &Silent).expect("sound").picture;
            let [r, _, _, alpha] = picture.color[15 * 40 + 20];
            if net && integrator != Integrator::Path {
                // The net is the first hit.
                assert_eq!(alpha, 1.0, "{integrator}");
                continue;
            }
            // A black net is there in a quarter.
            let behind = if net { 0.75 } else { 1.0 };
            let tolerance = if net { 0.12 } else { 1e-6 };
            assert!(
                (alpha - (1.0 - share * behind)).abs() < tolerance,
                "{integrator}, {share}: opacity {alpha}"
            );
            assert!((r - 0.5 * behind).abs() < tolerance, "{integrator}, {share}: its light, {r}");
            let corner = picture.color[29 * 40 + 20];
            assert_eq!(corner[3], 1.0, "{integrator}: the floor");
        }
    }
}
