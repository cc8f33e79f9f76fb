// SPDX-License-Identifier: GPL-3.0-or-later
//! Integrators of many virtual lights: the same pictures as by path tracing, edges counted alike, the same bits for any
//! number of threads.

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Integrator, RenderOptions, SceneCamera, Silent, World, render};
use gnurt_scene::material::Color;
use gnurt_scene::{Material, Scene, Surface};

/// Edge of the picture and of its tiles.
const SIZE: u32 = 24;
const TILE: u32 = 8;

fn cornell() -> (World, SceneCamera) {
    view(&gnurt_scene::builtin::load("cornell").expect("it is built in"), true)
}

fn view(scene: &Scene, force_diffuse: bool) -> (World, SceneCamera) {
    let camera = SceneCamera::new(&scene.cameras()[0]).expect("a view");
    (world_of(scene, force_diffuse), camera)
}

/// Means of tiles and channels, once for each of some independent renderings.
fn tiles(view: &(World, SceneCamera), options: &RenderOptions, batches: usize) -> Vec<Vec<f64>> {
    let of_picture = |picture: &Picture| {
        let mut means = vec![0.0; ((SIZE / TILE) * (SIZE / TILE) * 3) as usize];
        for y in 0..SIZE {
            for x in 0..SIZE {
                let tile = (y / TILE) * (SIZE / TILE) + x / TILE;
                let pixel = picture.pixel(x, y).expect("inside");
                for k in 0..3 {
                    means[tile as usize * 3 + k] += f64::from(pixel[k]) / f64::from(TILE * TILE);
                }
            }
        }
        means
    };
    side_by_side(batches, |number, threads| {
        let seed = 1000 + number as u64;
        let options = RenderOptions { seed, width: SIZE, height: SIZE, ..options.clone() };
        of_picture(&render(&view.0, &view.1, &options, threads, &Silent).expect("sound options").picture)
    })
}

/// Mean and squared standard error of a value over batches.
fn mean_and_error(batches: &[Vec<f64>], i: usize) -> (f64, f64) {
    let n = batches.len() as f64;
    let mean = batches.iter().map(|b| b[i]).sum::<f64>() / n;
    (mean, batches.iter().map(|b| (b[i] - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}

/// Asserts that two ways of rendering have the same mean: the whole picture within `tolerance`, tiles within their noise.
fn assert_same(found: &[Vec<f64>], expected: &[Vec<f64>], tolerance: f64, what: &str) {
    let count = found[0].len();
    let (mut worst, mut squares, mut sums) = (0.0_f64, 0.0, [0.0; 2]);
    for i in 0..count {
        let ((a, va), (b, vb)) = (mean_and_error(found, i), mean_and_error(expected, i));
        let z = (a - b) / (va + vb).sqrt().max(1e-9);
        worst = worst.max(z.abs());
        squares += z * z / count as f64;
        sums = [sums[0] + a, sums[1] + b];
    }
    let off = sums[0] / sums[1] - 1.0;
    eprintln!("{what}: mean {off:+.4}, worst z {worst:.2}, rms z {:.2}", squares.sqrt());
    assert!(off.abs() < tolerance, "{what}: the mean is off by {off:+.4}");
    assert!(worst < 4.5 && squares.sqrt() < 2.0, "{what}: worst z {worst:.2}, rms {:.2}", squares.sqrt());
}

fn by(integrator: Integrator, spp: u32, vpls: u32, clamp: Option<f32>) -> RenderOptions {
    RenderOptions {
        integrator,
        spp,
        vpls,
        clamp,
        max_depth: 6,
        pixel_centres: true,
        ..RenderOptions::default()
    }
}

const WITH_VIRTUAL_LIGHTS: [Integrator; 3] = [
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

#[test]
fn virtual_lights_and_rays_agree() {
    let view = cornell();
    let rays = tiles(&view, &by(Integrator::Path, 32, 1, None), 16);
    for integrator in WITH_VIRTUAL_LIGHTS {
        let lights = tiles(&view, &by(integrator, 3, 64, None), 16);
        assert_same(&lights, &rays, 0.01, integrator.name());
    }
}

/// The Cornell box with walls of glazed plastic, a block of rough metal and a mirror.
fn shiny() -> Scene {
    let mut scene = gnurt_scene::builtin::load("cornell").expect("it is built in");
    let shiny = |base: [f32; 3], metallic, roughness| Surface::MetallicRoughness {
        base_color: Color::constant(base),
        metallic,
        roughness,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture: None,
    };
    let finishes = [("white", shiny([0.73; 3], 0.0, 0.4)), ("metal", shiny([0.9, 0.7, 0.4], 1.0, 0.45))];
    let of_mesh = [("floor, ceiling and back", 0), ("short block", 1)];
    let finishes = finishes
        .map(|(name, surface)| scene.add_material(Material { surface, ..Material::matte(name, [0.0; 3]) }));
    let mirror = Surface::Mirror { reflectance: Color::constant([0.9; 3]) };
    let mirror = scene.add_material(Material { surface: mirror, ..Material::matte("mirror", [0.0; 3]) });
    for (name, finish) in
        of_mesh.map(|(name, n)| (name, finishes[n])).into_iter().chain([("tall block", mirror)])
    {
        let placement = scene.meshes().iter().position(|mesh| mesh.name == name).expect("the box has it");
        scene.edit_mesh(gnurt_scene::MeshId(placement as u32)).material = finish;
    }
    scene
}

#[test]
fn gloss_and_mirrors_agree() {
    let view = view(&shiny(), false);
    let rays = tiles(&view, &by(Integrator::Path, 64, 1, None), 16);
    // Caustics make the paths' mean noisy: tiles, judged by their noise, say more.
    for integrator in WITH_VIRTUAL_LIGHTS {
        // One ray leaves a visible point; with many virtual lights several.
        for (spp, vpls) in [(3, 64), (1, 512)] {
            let what = format!("{integrator}, {vpls} virtual lights");
            assert_same(&tiles(&view, &by(integrator, spp, vpls, None), 16), &rays, 0.04, &what);
        }
    }
}

#[test]
fn edges_are_counted_alike() {
    let view = cornell();
    for depth in [1, 2, 3] {
        let with = |integrator, spp, vpls, clamp| {
            let options = RenderOptions { max_depth: depth, ..by(integrator, spp, vpls, clamp) };
            tiles(&view, &options, 8)
        };
        let rays = with(Integrator::Path, 16, 1, None);
        for integrator in WITH_VIRTUAL_LIGHTS {
            let what = format!("{integrator}, {depth} edges");
            assert_same(&with(integrator, 16, 32, None), &rays, 0.02, &what);
        }
    }
}

/// Glass without refraction adds one edge and nothing else: only scattered rays find light through it.
#[test]
fn light_through_glass_counts_once() {
    let mut scene = gnurt_scene::builtin::load("cornell").expect("it is built in");
    let clear = Surface::Dielectric {
        ior: 1.0001,
        reflectance: [1.0; 3],
        transmittance: [1.0; 3],
        interior: Default::default(),
    };
    let clear = scene.add_material(Material::of("clear", clear));
    let (low, high) = bounds_of_lamp(&scene);
    let below = low[1] - 0.02 * (high[0] - low[0]);
    let corner = [2.0 * low[0] - high[0], below, 2.0 * low[2] - high[2]];
    let edge = |k: usize| 3.0 * (high[k] - low[k]);
    put_mesh(&mut scene, quad(corner, [edge(0), 0.0, 0.0], [0.0, 0.0, edge(2)], clear));
    let (bare, glazed) = (cornell(), view(&scene, false));
    let with = |integrator, max_depth, spp| RenderOptions { max_depth, ..by(integrator, spp, 32, None) };
    let expected = tiles(&bare, &with(Integrator::Path, 2, 16), 8);
    for integrator in [Integrator::Path].into_iter().chain(WITH_VIRTUAL_LIGHTS) {
        let found = tiles(&glazed, &with(integrator, 3, 96), 8);
        assert_same(&found, &expected, 0.02, &format!("{integrator} through glass"));
    }
}

/// Corners of the box around all that shines.
fn bounds_of_lamp(scene: &Scene) -> ([f32; 3], [f32; 3]) {
    let emits = |mesh: &&std::sync::Arc<gnurt_scene::Mesh>| {
        scene.materials()[mesh.material.0 as usize].emission != [0.0; 3]
    };
    let corners = || scene.meshes().iter().filter(emits).flat_map(|mesh| mesh.positions.iter());
    let bound = |pick: fn(f32, f32) -> f32, from: f32| {
        [0, 1, 2].map(|k| corners().fold(from, |bound, corner| pick(bound, corner[k])))
    };
    (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY))
}

#[test]
fn threads_do_not_show() {
    let view = cornell();
    for integrator in WITH_VIRTUAL_LIGHTS {
        let options = RenderOptions { width: 20, height: 20, ..by(integrator, 2, 300, None) };
        let one = render(&view.0, &view.1, &options, &pool(1), &Silent).expect("sound options");
        let seven = render(&view.0, &view.1, &options, &pool(7), &Silent).expect("sound options");
        assert_eq!(one.picture.color, seven.picture.color, "{integrator}: bit for bit");
        assert_eq!(one.stats.shadow_rays, seven.stats.shadow_rays, "{integrator}: the same work");
    }
}
