// SPDX-License-Identifier: GPL-3.0-or-later
//! Which rays see an instance: for each kind of ray the picture is that of the scene with or without it.

use crate::common::*;
use gnurt_render::{Integrator, RenderOptions, SceneCamera, Silent, World, render};
use gnurt_scene::material::{Alpha, Opacity, OpacityChannel};
use gnurt_scene::{InstanceId, Light, Material, RayMask, Scene, Surface};

const INTEGRATORS: [Integrator; 2] = [Integrator::Path, Integrator::Whitted];

/// Radiance in a narrow camera.
fn measured(world: &World, camera: &SceneCamera, integrator: Integrator) -> f32 {
    let options =
        RenderOptions { width: 2, height: 2, spp: 4, max_depth: 3, integrator, ..RenderOptions::default() };
    let frame = render(world, camera, &options, &pool(1), &Silent).expect("sound options");
    frame.picture.color.iter().map(|pixel| pixel[0]).sum::<f32>() / 4.0
}

/// The radiance with the last instance hidden from rays of a kind, visible to those only, and absent.
fn with_and_without(
    scene: &mut Scene,
    kind: RayMask,
    view: [[f32; 3]; 2],
    integrator: Integrator,
) -> [f32; 3] {
    let camera = camera(view[0], view[1], 0.5);
    let last = InstanceId(scene.instances().len() as u32 - 1);
    let mut world = World::new();
    [(!kind, true), (kind, true), (RayMask::ALL, false)].map(|(mask, visible)| {
        let instance = scene.edit_instance(last);
        (instance.mask, instance.visible) = (mask, visible);
        let made = world.commit(scene, &Default::default(), &Default::default(), &pool(1));
        made.expect("all ids name something");
        measured(&world, &camera, integrator)
    })
}

/// A floor under a light from above.
fn lit_floor() -> Scene {
    let mut scene = floor(0.5, 10.0);
    scene.add_light(Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [2.0; 3], angle: 0.0 });
    scene
}

#[test]
fn the_camera_sees_through_what_its_rays_do_not_see() {
    for integrator in INTEGRATORS {
        let mut scene = lit_floor();
        let black = matte(&mut scene, [0.0; 3]);
        // Upright between the camera and the floor: its shadow misses the visible point.
        put_mesh(&mut scene, quad([-1.0, -2.0, 0.5], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], black));
        let view = [[0.0, -4.0, 2.0], [0.0, 0.0, 0.0]];
        let [hidden, shown, gone] = with_and_without(&mut scene, RayMask::CAMERA, view, integrator);
        assert!(gone > 0.1, "the floor is lit: {gone}");
        assert!((hidden - gone).abs() < 1e-4, "{integrator:?}: seen through: {hidden}, not {gone}");
        assert_eq!(shown, 0.0, "{integrator:?}: in front");
    }
}

#[test]
fn camera_rays_go_on_through_transparent_surfaces() {
    for integrator in [Integrator::Path, Integrator::InstantRadiosity] {
        let mut scene = lit_floor();
        let opacity = Opacity { factor: 0.0, texture: None, channel: OpacityChannel::Alpha };
        let clear = Material { alpha: Alpha::Blend { opacity }, ..Material::matte("clear", [0.5; 3]) };
        let [clear, black] = [scene.add_material(clear), matte(&mut scene, [0.0; 3])];
        for (y, material) in [(-3.0, clear), (-2.0, black)] {
            put_mesh(&mut scene, quad([-1.0, y, 0.5], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], material));
        }
        let view = [[0.0, -4.0, 2.0], [0.0, 0.0, 0.0]];
        let [hidden, shown, gone] = with_and_without(&mut scene, RayMask::CAMERA, view, integrator);
        assert!(gone > 0.1, "the floor is lit: {gone}");
        assert!((hidden - gone).abs() < 1e-4, "{integrator:?}: seen through: {hidden}, not {gone}");
        assert_eq!(shown, 0.0, "{integrator:?}: behind the pane");
    }
}

#[test]
fn nothing_casts_a_shadow_that_shadow_rays_do_not_see() {
    for integrator in INTEGRATORS {
        let mut scene = lit_floor();
        let black = matte(&mut scene, [0.0; 3]);
        put_mesh(&mut scene, quad([-1.0, -1.0, 5.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], black));
        let view = [[0.0, -4.0, 2.0], [0.0, 0.0, 0.0]];
        let [unseen, measured, gone] = with_and_without(&mut scene, RayMask::SHADOW, view, integrator);
        assert!(gone > 0.1, "the floor is lit: {gone}");
        assert!(unseen > 0.9 * gone, "{integrator:?}: no shadow: {unseen}, not {gone}");
        assert!(measured < 1e-6, "{integrator:?}: in the shadow: {measured}");
    }
}

#[test]
fn mirrors_show_what_other_rays_see() {
    for integrator in INTEGRATORS {
        let mut scene = Scene::new();
        let reflectance = gnurt_scene::material::Color::constant([1.0; 3]);
        let mirror = scene.add_material(Material::of("mirror", Surface::Mirror { reflectance }));
        put_mesh(&mut scene, quad([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], mirror));
        let shining = emitter(&mut scene, [3.0; 3]);
        // Its light side looks down.
        put_mesh(&mut scene, quad([-1.0, 1.0, 3.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], shining));
        let view = [[0.0, -2.0, 3.0], [0.0, 0.0, 0.0]];
        let [unseen, measured, gone] = with_and_without(&mut scene, RayMask::OTHER, view, integrator);
        assert_eq!((unseen, gone), (0.0, 0.0), "{integrator:?}: not in the mirror");
        assert!((measured - 3.0).abs() < 1e-4, "{integrator:?}: in the mirror: {measured}");
    }
}

#[test]
fn lamps_that_other_rays_do_not_see_give_no_light() {
    let mut scene = floor(0.5, 10.0);
    let shining = emitter(&mut scene, [3.0; 3]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 3.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], shining));
    let view = [[0.0, -4.0, 2.0], [0.0, 0.0, 0.0]];
    let [unseen, measured, gone] = with_and_without(&mut scene, RayMask::OTHER, view, Integrator::Path);
    assert_eq!((unseen, gone), (0.0, 0.0), "it does not shine on the floor");
    assert!(measured > 0.1, "it does: {measured}");
    let camera = camera([0.0, 0.0, 0.5], [0.0, 0.1, 3.0], 0.5);
    let last = scene.edit_instance(InstanceId(1));
    (last.mask, last.visible) = (RayMask::CAMERA, true);
    assert_eq!(seen_of(&scene, &camera), 3.0, "the camera sees that it shines");
}

fn seen_of(scene: &Scene, camera: &SceneCamera) -> f32 {
    measured(&world_of(scene, false), camera, Integrator::Path)
}
