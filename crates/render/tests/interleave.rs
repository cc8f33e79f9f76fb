// SPDX-License-Identifier: GPL-3.0-or-later
//! Interleaved sampling: the light of the full gather for a fraction of its rays, nothing over edges, the same bits for any
//! number of threads.

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Accumulation, Integrator, RenderOptions, SceneCamera, Silent, World, render};
use gnurt_scene::Scene;

const ALL: [Integrator; 3] = [
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

fn cornell() -> (World, SceneCamera) {
    let scene = gnurt_scene::builtin::load("cornell").expect("it is built in");
    (world_of(&scene, true), SceneCamera::new(&scene.cameras()[0]).expect("a view"))
}

fn by(integrator: Integrator, interleave: u32, spp: u32) -> RenderOptions {
    let options = options(90, 70, spp);
    RenderOptions { integrator, interleave, max_depth: 6, vpls: 360, ..options }
}

fn picture((world, camera): &(World, SceneCamera), options: &RenderOptions) -> Picture {
    render(world, camera, options, &pool(2), &Silent).expect("sound options").picture
}

/// A floor that bounces light of a lamp to a wall, on which the camera looks.
fn wall() -> (World, SceneCamera) {
    let mut scene = Scene::new();
    let (wall, ground, area_light) =
        (matte(&mut scene, [0.7; 3]), matte(&mut scene, [0.8; 3]), emitter(&mut scene, [30.0; 3]));
    put_mesh(&mut scene, quad([-4.0, 4.0, -4.0], [8.0, 0.0, 0.0], [0.0, 0.0, 8.0], wall));
    put_mesh(&mut scene, quad([-4.0, -4.0, -4.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], ground));
    // Behind the camera, and it shines down.
    put_mesh(&mut scene, quad([-0.5, -1.5, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], area_light));
    (world_of(&scene, false), camera([0.0, 0.0, 0.0], [0.0, 4.0, 0.0], 50.0))
}

#[test]
fn a_wall_shows_the_light_of_the_full_gather() {
    let view = wall();
    for n in [3, 5] {
        // The same virtual lights, gathered by other pixels.
        let [full, part] = [1, n].map(|n| mean(&picture(&view, &by(Integrator::InstantRadiosity, n, 4))));
        eprintln!("{n} by {n}: {part:?} instead of {full:?}");
        (0..3).for_each(|k| assert_close(part[k], full[k], 0.01, &format!("{n} by {n}")));
    }
}

#[test]
fn rooms_show_the_same_light_for_fewer_rays() {
    let view = cornell();
    for integrator in ALL {
        let [full, part] = [1, 3].map(|n| {
            // So few that a full gather asks all of them.
            let options = RenderOptions { vpls: 252, ..by(integrator, n, 4) };
            render(&view.0, &view.1, &options, &pool(2), &Silent).expect("sound options")
        });
        let [expected, found] = [&full, &part].map(|frame| mean(&frame.picture));
        (0..3).for_each(|k| assert_close(found[k], expected[k], 0.02, integrator.name()));
        let ratio = full.stats.shadow_rays as f64 / part.stats.shadow_rays as f64;
        eprintln!("{integrator}: {ratio:.1} times fewer shadow rays");
        // Chains and candidates are traced in any case.
        let least = if integrator == Integrator::InstantRadiosity { 8.0 } else { 3.0 };
        assert!(ratio > least, "{integrator}: {ratio}");
    }
}

/// A bright strip before a dark wall: its light stays with it.
#[test]
fn edges_stay_sharp() {
    let mut scene = Scene::new();
    let (bright, dark) = (matte(&mut scene, [0.9; 3]), matte(&mut scene, [0.9; 3]));
    put_mesh(&mut scene, quad([-9.0, 5.0, -9.0], [18.0, 0.0, 0.0], [0.0, 0.0, 18.0], dark));
    put_mesh(&mut scene, quad([-0.5, 2.0, -9.0], [1.0, 0.0, 0.0], [0.0, 0.0, 18.0], bright));
    scene.add_light(gnurt_scene::Light::Point {
        position: [0.0, -4.0, 0.0],
        intensity: [9.0; 3],
        radius: 0.0,
    });
    let view = (world_of(&scene, false), camera([0.0, 0.0, 0.0], [0.0, 4.0, 0.0], 40.0));
    let options = RenderOptions { pixel_centres: true, ..by(Integrator::InstantRadiosity, 1, 1) };
    let [full, part] = [1, 5].map(|interleave| {
        let options = RenderOptions { interleave, max_depth: 2, ..options.clone() };
        picture(&view, &options)
    });
    let row = |picture: &Picture, x: u32| picture.pixel(x, 35).expect("inside")[0];
    let edge = (1..90).find(|&x| row(&full, x) > 1.5 * row(&full, x - 1)).expect("the strip begins");
    let strip = row(&full, edge);
    for x in edge - 3..edge + 3 {
        let (found, expected) = (row(&part, x), row(&full, x));
        assert!(
            (found - expected).abs() < 0.05 * strip,
            "column {x}, edge {edge}: {found} instead of {expected}"
        );
    }
}

#[test]
fn threads_and_passes_do_not_show() {
    let view = cornell();
    for integrator in ALL {
        let options = RenderOptions { crop: Some([7, 5, 61, 50]), aovs: true, ..by(integrator, 3, 3) };
        let one = render(&view.0, &view.1, &options, &pool(1), &Silent).expect("sound options");
        let mut seven = Accumulation::new(options).expect("sound options");
        while !seven.is_complete() {
            seven.pass(&view.0, &view.1, 1, &pool(7), &Silent);
        }
        assert_eq!(one.picture, seven.picture(), "{integrator}: bit for bit");
        assert_eq!(one.stats.shadow_rays, seven.stats().shadow_rays, "{integrator}: the same work");
    }
}
