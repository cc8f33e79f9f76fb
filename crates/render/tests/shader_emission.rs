// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces whose shaders define their emission are lights: against the definition, against lights of the
//! description, and the integrators against each other.

use std::sync::Arc;

use crate::common::*;
use glam::Vec3;
use gnurt_render::{
    CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};
use gnurt_scene::{Affine, Material, Scene, Surface};
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{EnvironmentShader, SurfaceBatch, SurfaceShader, Tracer, Vec3s};

const ALL: [Integrator; 5] = [
    Integrator::Whitted,
    Integrator::Path,
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

/// Exit radiance: more on the right of the front, more straight on; less on the back.
fn side_emission(u: f32, v: f32, front: bool, cos: f32) -> f32 {
    if front { (if u > 0.5 { 4.0 } else { 0.5 }) * (0.3 + cos) } else { 1.5 * (1.0 - v) }
}

/// Gives that off.
struct Uneven;

impl SurfaceShader for Uneven {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            let cos = hits.ng.get(i).dot(hits.ray_dir.get(i)).abs();
            let light = side_emission(hits.texcoord[0][i], hits.texcoord[1][i], hits.front(i), cos);
            out.emit(i, Vec3::splat(light));
        }
    }

    fn emits(&self) -> bool {
        true
    }
}

/// Gives off the same everywhere on its front.
struct Even(Vec3);

impl SurfaceShader for Even {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        (0..hits.len()).filter(|&i| hits.front(i)).for_each(|i| out.emit(i, self.0));
    }

    fn emits(&self) -> bool {
        true
    }
}

/// Emission that its front and its back have everywhere; `says` whether it is known without evaluation.
struct Sided {
    sides: [Vec3; 2],
    says: bool,
}

impl SurfaceShader for Sided {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        (0..hits.len()).for_each(|i| out.emit(i, self.sides[usize::from(!hits.front(i))]));
    }

    fn emits(&self) -> bool {
        true
    }

    fn even_emission(&self) -> Option<[Vec3; 2]> {
        self.says.then_some(self.sides)
    }
}

/// An even lamp, and lets all light through.
struct Clear(Even);

impl SurfaceShader for Clear {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        self.0.evaluate(hits, out);
        (0..hits.len()).for_each(|i| out.cover(i, 0.0));
    }

    fn transmit(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, Vec3::ONE));
    }

    fn is_opaque(&self) -> bool {
        false
    }

    fn emits(&self) -> bool {
        true
    }
}

/// The same radiance from everywhere.
struct Sky;

impl EnvironmentShader for Sky {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        (0..dir.len()).for_each(|i| out.set(i, Vec3::splat(2.0)));
    }
}

const CORNER: [f32; 3] = [0.2, -0.4, 1.0];
const EDGES: [[f32; 3]; 2] = [[0.9, 0.0, 0.0], [0.0, 0.7, 0.0]];

/// A lamp above a floor under a ceiling, and its mirror image; their fronts look up or down.
fn scratch(material: Material, is_up: bool) -> Scene {
    let mut scene = floor(0.6, 3.0);
    let grey = matte(&mut scene, [0.7; 3]);
    put_mesh(&mut scene, quad([-3.0, -3.0, 1.6], [0.0, 6.0, 0.0], [6.0, 0.0, 0.0], grey));
    let area_light = scene.add_material(material);
    let [a, b] = if is_up { EDGES } else { [EDGES[1], EDGES[0]] };
    let mesh = scene.add_mesh(quad(CORNER, a, b, area_light));
    let object = scene.add_object_of("", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
    scene.instantiate(object, Affine::scale([-1.0, 1.0, 1.0]));
    scene
}

fn measured(world: &World, options: &RenderOptions) -> f64 {
    let view = camera([0.1, -1.5, 0.8], [0.1, 0.2, 0.0], 0.01);
    mean(&render(world, &view, options, &pool(1), &Silent).expect("sound options").picture)[0]
}

/// Direct light at the visible point, by the definition.
fn expected(is_up: bool) -> f64 {
    const N: u32 = 200;
    let p = Vec3::new(0.1, 0.2, 0.0);
    let area = EDGES[0][0] * EDGES[1][1] / (N * N) as f32;
    let mut sum = 0.0;
    for (mirror, i, j) in [1.0, -1.0].iter().flat_map(|m| (0..N * N).map(move |k| (m, k % N, k / N))) {
        let [s, t] = [i, j].map(|k| (k as f32 + 0.5) / N as f32);
        let placement = Vec3::from(CORNER) + Vec3::from(EDGES[0]) * s + Vec3::from(EDGES[1]) * t;
        let offset = placement * Vec3::new(*mirror, 1.0, 1.0) - p;
        let cos = offset.normalize().z;
        let (u, v) = if is_up { (s, t) } else { (t, s) };
        sum += f64::from(side_emission(u, v, !is_up, cos) * cos * cos / offset.length_squared() * area);
    }
    0.6 / std::f64::consts::PI * sum
}

#[test]
fn lamps_of_shaders_shine_as_they_say() {
    for is_up in [false, true] {
        let scene = scratch(Material::of("lamp", Surface::Shader(0)), is_up);
        let world = world_with(&scene, Uneven);
        let expected = expected(is_up);
        for integrator in ALL {
            let options = RenderOptions { integrator, max_depth: 2, vpls: 256, ..options(4, 4, 256) };
            let found = measured(&world, &options);
            assert_close(found, expected, 0.015, &format!("{integrator}, front up: {is_up}"));
        }
    }
}

#[test]
fn integrators_agree_on_lamps_of_shaders() {
    let scene = scratch(Material::of("lamp", Surface::Shader(0)), true);
    let world = world_with(&scene, Uneven);
    let by = |integrator, spp| {
        let options = RenderOptions { integrator, max_depth: 5, vpls: 128, ..options(4, 4, spp) };
        measured(&world, &options)
    };
    let paths = by(Integrator::Path, 1024);
    assert!(paths > 1.2 * expected(true), "the ceiling sends much of it back: {paths}");
    for integrator in &ALL[2..] {
        assert_close(by(*integrator, 32), paths, 0.02, &format!("{integrator}"));
    }
}

#[test]
fn a_shader_that_glows_is_a_lamp_of_the_description() {
    let reported = Material { emission: [4.0, 2.0, 1.0], ..Material::matte("lamp", [0.0; 3]) };
    let requests = Material::of("lamp", Surface::Shader(0));
    let [reported, requests] = [reported, requests]
        .map(|material| world_with(&scratch(material, false), Even(Vec3::new(4.0, 2.0, 1.0))));
    for integrator in ALL {
        let options = RenderOptions { integrator, max_depth: 4, vpls: 64, ..options(4, 4, 4) };
        let (expected, found) = (measured(&reported, &options), measured(&requests, &options));
        assert_close(found, expected, 1e-3, &format!("{integrator}: the same light, and the same samples"));
    }
}

/// Of either side, of both, and of mirror images.
#[test]
fn even_lamps_shine_as_their_shaders_say() {
    let bright = Vec3::new(4.0, 2.0, 1.0);
    for (sides, is_up) in [
        ([bright, Vec3::ZERO], false),
        ([Vec3::ZERO, bright], true),
        ([bright, bright * 0.25], false),
        ([bright * 0.25, bright], false),
    ] {
        let scene = scratch(Material::of("lamp", Surface::Shader(0)), is_up);
        let [said, found] = [true, false].map(|says| world_with(&scene, Sided { sides, says }));
        for integrator in ALL {
            let options = RenderOptions { integrator, max_depth: 4, vpls: 64, ..options(4, 4, 16) };
            let (said, found) = (measured(&said, &options), measured(&found, &options));
            assert!(said > 0.1, "{integrator}, {sides:?}: {said}");
            assert_close(said, found, 1e-3, &format!("{integrator}, {sides:?}: as by the shader"));
        }
    }
}

#[test]
fn lamps_follow_their_shaders() {
    let scene = scratch(Material::of("lamp", Surface::Shader(0)), false);
    let table = |strength| ShaderTable {
        surfaces: vec![Arc::new(Even(Vec3::splat(strength)))],
        ..ShaderTable::default()
    };
    let (mut world, commit) = (World::new(), CommitOptions::default());
    let options = RenderOptions { integrator: Integrator::Path, max_depth: 2, ..options(4, 4, 4) };
    let mut light = |table: &ShaderTable| {
        let report = world.commit(&scene, table, &commit, &pool(1)).expect("the scene is sound");
        (measured(&world, &options), report.found_emitters)
    };
    let dim = table(1.0);
    let (one, _) = light(&dim);
    let (two, found) = light(&table(2.0));
    assert!(found, "another shader is another lamp");
    assert_close(two, 2.0 * one, 1e-4, "twice the light");
    let (dark, _) = light(&table(0.0));
    assert_eq!(dark, 0.0, "none");
    let (again, _) = light(&dim);
    assert_eq!(again, one, "as before");
    assert!(!light(&dim).1, "nothing was edited");
}

/// Light of the lamp and light through it add up, on the floor and where the camera sees the lamp.
#[test]
fn lamps_may_let_light_through() {
    let mut scene = floor(0.6, 3.0);
    let clear = scene.add_material(Material::of("lamp", Surface::Shader(0)));
    put_mesh(&mut scene, quad(CORNER, EDGES[1], EDGES[0], clear));
    let seen = |lamp: f32, sky: bool, view: &SceneCamera, integrator| {
        let shader = Clear(Even(Vec3::splat(lamp)));
        let environment = sky.then(|| Arc::new(Sky) as Arc<dyn EnvironmentShader>);
        let table = ShaderTable { surfaces: vec![Arc::new(shader)], environment, ..ShaderTable::default() };
        let mut world = World::new();
        world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
        let options = RenderOptions { integrator, max_depth: 2, vpls: 16, ..options(4, 4, 1024) };
        mean(&render(&world, view, &options, &pool(1), &Silent).expect("sound options").picture)[0]
    };
    let on_floor = camera([0.1, -1.5, 0.8], [0.4, -0.1, 0.0], 0.01);
    let at_lamp = camera([0.6, -0.1, 0.1], [0.6, -0.05, 1.0], 0.01);
    for integrator in ALL {
        let by = |lamp, sky, view| seen(lamp, sky, view, integrator);
        assert_close(
            by(3.0, true, &at_lamp),
            5.0,
            1e-3,
            &format!("{integrator}: the lamp and the sky behind it"),
        );
        let (lamp, sky) = (by(3.0, false, &on_floor), by(0.0, true, &on_floor));
        if integrator != Integrator::Whitted {
            assert_close(sky, 1.2, 0.01, &format!("{integrator}: nothing shades the floor"));
        }
        assert!(lamp > 0.1, "{integrator}: {lamp}");
        assert_close(by(3.0, true, &on_floor), lamp + sky, 0.01, &format!("{integrator}: the sum"));
    }
}
