// SPDX-License-Identifier: GPL-3.0-or-later
//! Unlit colours: visible from both sides, times the mesh's colours, in mirrors, without lighting other
//! surfaces. KHR_materials_unlit.

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Integrator, RenderOptions, Silent, render};
use gnurt_scene::material::Color;
use gnurt_scene::{Material, Scene, Surface};

const COLOR: [f32; 3] = [0.5, 0.25, 0.125];
const VERTEX: [f32; 4] = [0.5, 1.0, 1.0, 1.0];
const SEEN: [f32; 3] = [0.25, 0.25, 0.125];

/// A drawing in the plane x = 0, whose front looks along +x.
fn drawing(scene: &mut Scene) {
    let color = Surface::Unlit { color: Color::constant(COLOR) };
    let material = scene.add_material(Material::of("drawing", color));
    let mut mesh = quad([0.0, -1.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], material);
    mesh.colors = vec![VERTEX; 4];
    put_mesh(scene, mesh);
}

fn picture(scene: &Scene, integrator: Integrator, eye: [f32; 3], target: [f32; 3]) -> Picture {
    let options = RenderOptions { width: 4, height: 4, spp: 8, integrator, ..RenderOptions::default() };
    render(&world_of(scene, false), &camera(eye, target, 2.0), &options, &pool(1), &Silent)
        .expect("sound options")
        .picture
}

fn all_are(picture: &Picture, expected: [f32; 3], what: &str) {
    for pixel in &picture.color {
        let close = (0..3).all(|k| (pixel[k] - expected[k]).abs() < 1e-5);
        assert!(close, "{what}: {pixel:?}, not {expected:?}");
    }
}

const ALL: [Integrator; 5] = [
    Integrator::Path,
    Integrator::Whitted,
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

#[test]
fn a_drawing_is_seen_from_both_sides_and_lights_nothing() {
    let mut scene = Scene::new();
    drawing(&mut scene);
    // A wall before the drawing.
    let grey = matte(&mut scene, [0.8; 3]);
    put_mesh(&mut scene, quad([2.0, -1.0, -1.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], grey));
    for integrator in ALL {
        for (eye, side) in [([1.0, 0.1, 0.1], "front"), ([-3.0, 0.1, 0.1], "back")] {
            let measured = picture(&scene, integrator, eye, [0.0; 3]);
            all_are(&measured, SEEN, &format!("{integrator}: the {side} of the drawing"));
        }
        let wall = picture(&scene, integrator, [1.0, 0.1, 0.1], [2.0, 0.0, 0.0]);
        all_are(&wall, [0.0; 3], &format!("{integrator}: a wall beside it"));
    }
}

#[test]
fn mirrors_show_a_drawing() {
    let mut scene = Scene::new();
    drawing(&mut scene);
    let mirror = Surface::Mirror { reflectance: Color::constant([0.5; 3]) };
    let mirror = scene.add_material(Material::of("mirror", mirror));
    put_mesh(&mut scene, quad([2.0, -1.0, -1.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], mirror));
    for integrator in [Integrator::Path, Integrator::Whitted] {
        let measured = picture(&scene, integrator, [1.0, 0.1, 0.1], [2.0, 0.0, 0.0]);
        all_are(&measured, SEEN.map(|x| 0.5 * x), &format!("{integrator}: in a mirror"));
    }
}
