// SPDX-License-Identifier: GPL-3.0-or-later
//! Persistent virtual lights: the mean of pictures is that of fresh lights, few are traced for each picture,
//! edits of the world appear at once, and any number of threads gives the same bits.

use crate::common::*;
use gnurt_render::{
    Accumulation, CommitOptions, Integrator, PersistentLights, RenderOptions, SceneCamera, ShaderTable,
    Silent, World, render,
};
use gnurt_scene::{Camera, Scene};

const ALL: [Integrator; 3] = [
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

fn by(integrator: Integrator) -> RenderOptions {
    let options = options(16, 16, 1);
    RenderOptions { integrator, max_depth: 5, vpls: 128, pixel_centres: true, ..options }
}

fn cornell() -> Scene {
    gnurt_scene::builtin::load("cornell").expect("it is built in")
}

/// The room's camera, a little to the side.
fn offset_camera(scene: &Scene, step: u32) -> SceneCamera {
    let camera = &scene.cameras()[0];
    let side = 0.002 * f32::from(u8::from(step % 2 == 1)) * camera.eye.iter().map(|x| x.abs()).sum::<f32>();
    let moved = Camera { eye: [camera.eye[0] + side, camera.eye[1], camera.eye[2]], ..camera.clone() };
    SceneCamera::new(&moved).expect("a view")
}

fn view(
    persistent: &mut PersistentLights,
    world: &World,
    camera: &SceneCamera,
    options: &RenderOptions,
    threads: &rayon::ThreadPool,
) -> Accumulation {
    let mut measured = Accumulation::new(options.clone()).expect("sound options");
    assert!(measured.pass_in_motion(persistent, world, camera, threads, &Silent), "nobody stops it");
    measured
}

#[test]
fn pictures_in_motion_have_the_right_mean() {
    // So many lamps that which of them matter is learned.
    let mut scene = cornell();
    let [low, high] = world_of(&scene, true).bounds().map(|(low, high)| [low, high]).expect("a room");
    for i in 1..6 {
        let position = [0, 1, 2].map(|k| low[k] + (high[k] - low[k]) * ((i * (k + 2)) as f32 * 0.37).fract());
        let strength = 0.02 * (high[0] - low[0]).powi(2) * i as f32;
        scene.add_light(gnurt_scene::Light::Point { position, intensity: [strength; 3], radius: 0.0 });
    }
    let world = world_of(&scene, true);
    const SEEDS: usize = 12;
    for integrator in ALL {
        let means = side_by_side(SEEDS, |number, threads| {
            // Light samples and rays are those of the still picture: only virtual lights differ.
            let options = RenderOptions { seed: number as u64, vpls: 512, ..by(integrator) };
            let (still, moved) = (offset_camera(&scene, 0), offset_camera(&scene, 1));
            let picture = render(&world, &still, &options, threads, &Silent).expect("sound options").picture;
            let mut persistent = PersistentLights::default();
            for camera in [&moved, &still, &moved] {
                let tiny = RenderOptions { crop: Some([0, 0, 1, 1]), ..options.clone() };
                view(&mut persistent, &world, camera, &tiny, threads);
            }
            // Most lights were chosen for the camera beside.
            let moving = view(&mut persistent, &world, &still, &options, threads).picture();
            [mean(&moving), mean(&picture)]
        });
        let sum = |which: usize, k: usize| means.iter().map(|means| means[which][k]).sum::<f64>();
        let [found, expected] = [0, 1].map(|which| [0, 1, 2].map(|k| sum(which, k)));
        for k in 0..3 {
            eprintln!("{integrator}: {:+.4}", found[k] / expected[k] - 1.0);
            assert_close(found[k], expected[k], 0.03, integrator.name());
        }
    }
}

#[test]
fn later_pictures_trace_few_lights() {
    let scene = cornell();
    let world = world_of(&scene, true);
    for integrator in ALL {
        let options = RenderOptions { width: 2, height: 2, vpls: 4096, ..by(integrator) };
        let mut persistent = PersistentLights::default();
        let rays = [0, 1, 2].map(|step| {
            view(&mut persistent, &world, &offset_camera(&scene, step), &options, &pool(1))
                .stats()
                .secondary_rays
        });
        assert!(rays[2] * 4 < rays[0], "{integrator}: {rays:?}");
    }
}

/// Lights that do not depend on the camera persist; for a camera at rest all do.
#[test]
fn nothing_flickers() {
    let scene = cornell();
    let world = world_of(&scene, true);
    for (integrator, steps) in ALL.into_iter().zip([1, 8, 8]) {
        let options = by(integrator);
        let mut persistent = PersistentLights::default();
        view(&mut persistent, &world, &offset_camera(&scene, 1), &options, &pool(1));
        let mut measured: Vec<_> = (0..=steps)
            .map(|_| view(&mut persistent, &world, &offset_camera(&scene, 0), &options, &pool(1)).picture())
            .collect();
        let (last, before) = (measured.pop(), measured.pop());
        assert_eq!(last, before, "{integrator}: the same view, the same bits");
    }
}

#[test]
fn what_moves_is_followed() {
    let mut scene = cornell();
    let mut world = world_of(&scene, true);
    for integrator in ALL {
        let options = by(integrator);
        let mut persistent = PersistentLights::default();
        view(&mut persistent, &world, &offset_camera(&scene, 0), &options, &pool(1));
        let instance = scene.edit_instance(gnurt_scene::InstanceId(0));
        instance.world_from_object.columns[3][1] += 0.01;
        let commit = CommitOptions { force_diffuse: true, ..CommitOptions::default() };
        world.commit(&scene, &ShaderTable::default(), &commit, &pool(1)).expect("the scene is sound");
        let found = view(&mut persistent, &world, &offset_camera(&scene, 0), &options, &pool(1)).picture();
        // The learned number of light paths is random.
        let first =
            view(&mut PersistentLights::default(), &world, &offset_camera(&scene, 0), &options, &pool(1))
                .picture();
        assert!(
            found == first || integrator == Integrator::InstantRadiosity,
            "{integrator}: as the world is"
        );
        for (found, expected) in mean(&found).into_iter().zip(mean(&first)) {
            assert_close(found, expected, 0.02, "the mean");
        }
    }
}

#[test]
fn threads_do_not_show() {
    let scene = cornell();
    let world = world_of(&scene, true);
    for integrator in ALL {
        let [mut one, mut seven] = [(); 2].map(|()| PersistentLights::default());
        for step in 0..3 {
            let camera = offset_camera(&scene, step);
            let [one, seven] = [(&mut one, 1), (&mut seven, 7)].map(|(persistent, n)| {
                view(persistent, &world, &camera, &by(integrator), &pool(n)).picture()
            });
            assert_eq!(one, seven, "{integrator}, picture {step}: bit for bit");
        }
    }
}
