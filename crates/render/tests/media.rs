// SPDX-License-Identifier: GPL-3.0-or-later
//! Media between surfaces, against closed forms: Beer's law, single scattering, the furnace, emission, and
//! grids against even media. Pictures are of one direction.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::*;
use gnurt_render::{Integrator, RenderOptions, Silent, World, render};
use gnurt_scene::medium::{DensityGrid, Extent, Medium, Phase};
use gnurt_scene::{Affine, Light, Material, MaterialId, Scene};

const EVERYWHERE: Extent = Extent::Around { centre: [0.0; 3], radius: f32::INFINITY };

fn path(spp: u32, max_depth: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth, ..options(4, 4, spp) }
}

/// Radiance from `eye` towards `target`.
fn seen(world: &World, eye: [f32; 3], target: [f32; 3], options: &RenderOptions) -> [f64; 3] {
    let view = camera(eye, target, 0.001);
    mean(&render(world, &view, options, &pool(1), &Silent).expect("sound options").picture)
}

fn near(found: [f64; 3], expected: [f64; 3], relative: f64, what: &str) {
    for (found, expected) in found.into_iter().zip(expected) {
        let off = (found - expected).abs();
        assert!(off <= relative * expected.abs().max(1e-6), "{what}: {found} instead of {expected}");
    }
}

fn cube(low: [f32; 3], high: [f32; 3], material: MaterialId) -> Vec<gnurt_scene::Mesh> {
    let edge: [f32; 3] = std::array::from_fn(|k| high[k] - low[k]);
    let [x, y, z] = [[edge[0], 0.0, 0.0], [0.0, edge[1], 0.0], [0.0, 0.0, edge[2]]];
    let at = |k: usize| {
        let mut corner = low;
        corner[k] = high[k];
        corner
    };
    vec![
        quad(low, y, x, material),
        quad(at(2), x, y, material),
        quad(low, z, y, material),
        quad(at(0), y, z, material),
        quad(low, x, z, material),
        quad(at(1), z, x, material),
    ]
}

/// A lamp in the plane z = 10 that shines down.
fn lamp(scene: &mut Scene, radiance: [f32; 3]) {
    let light = emitter(scene, radiance);
    put_mesh(scene, quad([-50.0, -50.0, 10.0], [0.0, 100.0, 0.0], [100.0, 0.0, 0.0], light));
}

/// A grid of density 1 in the unit cube at `low`, of the size `edge`.
fn even_grid(low: [f64; 3], edge: f64, size: [u32; 3]) -> Arc<DensityGrid> {
    Arc::new(DensityGrid {
        size,
        density: vec![1.0; size.iter().product::<u32>() as usize],
        emission: Vec::new(),
        world_from_unit: Affine::translation(low) * Affine::scale([edge; 3]),
    })
}

#[test]
fn absorption_follows_beers_law() {
    let absorption = [0.1, 0.3, 0.0];
    let expected = |way: f64| absorption.map(|a| 2.0 * (-f64::from(a) * way).exp());
    // Around everything; the camera inside a body; a body in between; the same with a grid.
    let mut around = Scene::new();
    lamp(&mut around, [2.0; 3]);
    around.add_medium(Medium { absorption, extent: EVERYWHERE, ..Medium::default() });
    let found = seen(&world_of(&around, false), [0.0; 3], [0.0, 0.0, 1.0], &path(1, 4));
    near(found, expected(10.0), 1e-4, "around");

    for (eye, way) in [([0.1, 0.2, -5.0], 4.0), ([0.1, 0.2, 1.0], 2.0)] {
        for with_grid in [false, true] {
            let mut scene = Scene::new();
            lamp(&mut scene, [2.0; 3]);
            let grid = with_grid.then(|| even_grid([-1.0, -1.0, -1.0], 4.0, [20, 9, 11]));
            let body = scene.add_medium(Medium { absorption, grid, ..Medium::default() });
            let boundary = scene.add_material(Material::boundary("air", body));
            for mesh in cube([-1.0; 3], [3.0; 3], boundary) {
                put_mesh(&mut scene, mesh);
            }
            let spp = if with_grid { 4096 } else { 1 };
            let found = seen(&world_of(&scene, false), eye, [0.1, 0.2, 10.0], &path(spp, 4));
            near(found, expected(way), if with_grid { 0.02 } else { 1e-4 }, "a body");
        }
    }
}

#[test]
fn media_give_light_off() {
    let (absorption, emission) = ([0.5, 0.1, 0.0], [3.0, 1.0, 7.0]);
    for scattering in [0.0, 1e-4] {
        let mut scene = Scene::new();
        let medium = Medium {
            absorption,
            emission,
            scattering: [scattering; 3],
            extent: Extent::Around { centre: [0.0; 3], radius: 2.0 },
            ..Medium::default()
        };
        scene.add_medium(medium);
        let found = seen(&world_of(&scene, false), [0.0, 0.0, -9.0], [0.0; 3], &path(8192, 4));
        let expected: [f64; 3] =
            std::array::from_fn(|c| f64::from(emission[c]) * (1.0 - (-4.0 * f64::from(absorption[c])).exp()));
        near(found, expected, 0.02, "emission");
    }
}

/// Light of a point light of intensity 1 that a ray's medium scatters once: the integral along the ray. `is_flat`: the lamp
/// faces along -x, and its intensity falls with the cosine.
fn single(sigma: [f64; 3], albedo: f64, g: f64, (light, is_flat): ([f64; 3], bool), length: f64) -> [f64; 3] {
    let steps = 20_000;
    let mut sum = [0.0; 3];
    for k in 0..steps {
        let t = (f64::from(k) + 0.5) / f64::from(steps) * length;
        let offset = [light[0], light[1], light[2] - t];
        let d2: f64 = offset.iter().map(|x| x * x).sum();
        // Light travels from the lamp to the ray, then against the ray.
        let cos = offset[2] / d2.sqrt();
        let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
        for c in 0..3 {
            let facing = if is_flat { light[0] / d2.sqrt() } else { 1.0 };
            let left = facing * (-sigma[c] * (t + d2.sqrt())).exp();
            sum[c] += albedo * sigma[c] * phase * left / d2 * length / f64::from(steps);
        }
    }
    sum
}

#[test]
fn light_scattered_once_is_the_integral_along_the_ray() {
    let (sigma, albedo, light) = ([0.2, 0.5, 1.2], 0.7, [1.5, 0.0, 3.0]);
    for (g, with_grid) in [(0.0, false), (0.6, false), (-0.4, false), (0.6, true)] {
        let mut scene = Scene::new();
        let wall = matte(&mut scene, [0.0; 3]);
        put_mesh(&mut scene, quad([-50.0, -50.0, 6.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], wall));
        let position = light.map(|x| x as f32);
        scene.add_light(Light::Point { position, intensity: [1.0; 3], radius: 0.0 });
        let grid = with_grid.then(|| even_grid([-8.0; 3], 16.0, [16; 3]));
        scene.add_medium(Medium {
            absorption: sigma.map(|s| (s * (1.0 - albedo)) as f32),
            scattering: sigma.map(|s| (s * albedo) as f32),
            phase: Phase { anisotropy: g as f32, ..Phase::default() },
            extent: if with_grid { Extent::Free } else { EVERYWHERE },
            grid,
            ..Medium::default()
        });
        let found = seen(&world_of(&scene, false), [0.0; 3], [0.0, 0.0, 1.0], &path(1 << 14, 2));
        near(
            found,
            single(sigma, albedo, g, (light, false), 6.0),
            0.02,
            &format!("g = {g}, grid: {with_grid}"),
        );
    }
}

/// The spread of the pixels of a picture of one direction, over their mean.
fn spread(world: &World, options: &RenderOptions) -> f64 {
    let view = camera([0.0; 3], [0.0, 0.0, 1.0], 0.001);
    let picture = render(world, &view, options, &pool(1), &Silent).expect("sound options").picture;
    let light: Vec<f64> = picture.color.iter().map(|pixel| f64::from(pixel[1])).collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let variance = light.iter().map(|light| (light - mean).powi(2)).sum::<f64>() / light.len() as f64;
    variance.sqrt() / mean
}

/// A lamp next to a ray, whose light is far from even along it: the same integral, with little noise.
#[test]
fn lamps_near_a_ray_light_its_medium() {
    let (sigma, albedo, light) = ([0.1, 0.2, 0.4], 0.8, [0.05, 0.0, 3.0]);
    for (g, with_grid) in [(0.0, false), (0.6, false), (0.6, true)] {
        for is_area in [false, true] {
            let mut scene = Scene::new();
            let wall = matte(&mut scene, [0.0; 3]);
            put_mesh(&mut scene, quad([-50.0, -50.0, 6.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], wall));
            let position = light.map(|x| x as f32);
            if is_area {
                let (half, shine) = (5e-4, emitter(&mut scene, [1e6; 3]));
                let [x, y, z] = position;
                put_mesh(
                    &mut scene,
                    quad([x, y - half, z - half], [0.0, 0.0, 1e-3], [0.0, 1e-3, 0.0], shine),
                );
            } else {
                scene.add_light(Light::Point { position, intensity: [1.0; 3], radius: 0.0 });
            }
            scene.add_medium(Medium {
                absorption: sigma.map(|s| (s * (1.0 - albedo)) as f32),
                scattering: sigma.map(|s| (s * albedo) as f32),
                phase: Phase { anisotropy: g as f32, ..Phase::default() },
                extent: if with_grid { Extent::Free } else { EVERYWHERE },
                grid: with_grid.then(|| even_grid([-8.0; 3], 16.0, [16; 3])),
                ..Medium::default()
            });
            let world = world_of(&scene, false);
            let what = format!("g = {g}, grid: {with_grid}, area: {is_area}");
            let found = seen(&world, [0.0; 3], [0.0, 0.0, 1.0], &path(1 << 13, 2));
            near(found, single(sigma, albedo, g, (light, is_area), 6.0), 0.01, &what);
            let noise = spread(&world, &path(64, 2));
            assert!(noise < 0.2, "{what}: {noise}");
        }
    }
}

/// A lamp next to a ray and a brighter one farther from it: wherever a place is drawn, a flight that ends near the first does not count much.
#[test]
fn two_lamps_near_a_ray_light_its_medium() {
    let (sigma, albedo, lights) = ([0.1, 0.2, 0.4], 0.8, [([0.05, 0.0, 3.0], 1.0), ([0.0, 2.0, 4.0], 40.0)]);
    let mut scene = Scene::new();
    let wall = matte(&mut scene, [0.0; 3]);
    put_mesh(&mut scene, quad([-50.0, -50.0, 6.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], wall));
    for (position, intensity) in lights {
        scene.add_light(Light::Point {
            position: position.map(|x| x as f32),
            intensity: [intensity as f32; 3],
            radius: 0.0,
        });
    }
    scene.add_medium(Medium {
        absorption: sigma.map(|s| (s * (1.0 - albedo)) as f32),
        scattering: sigma.map(|s| (s * albedo) as f32),
        extent: EVERYWHERE,
        ..Medium::default()
    });
    let world = world_of(&scene, false);
    let found = seen(&world, [0.0; 3], [0.0, 0.0, 1.0], &path(1 << 12, 2));
    let one = |(at, intensity): ([f64; 3], f64)| {
        single(sigma, albedo, 0.0, (at, false), 6.0).map(|x| x * intensity)
    };
    let [near_one, far_one] = lights.map(one);
    near(found, [0, 1, 2].map(|c| near_one[c] + far_one[c]), 0.01, "both");
    let noise = spread(&world, &path(64, 2));
    assert!(noise < 0.2, "{noise}");
}

/// A thin medium before a wall, lit from the side: most flights pass it, and bring light nevertheless.
#[test]
fn thin_media_are_lit_by_flights_that_pass() {
    let (sigma, albedo, radius) = ([0.02, 0.04, 0.08], 0.8, 7.0);
    let mut scene = Scene::new();
    let wall = matte(&mut scene, [0.0; 3]);
    put_mesh(&mut scene, quad([-50.0, -50.0, 6.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0], wall));
    scene.add_light(Light::Directional { direction: [-1.0, 0.0, 0.0], irradiance: [1.0; 3], angle: 0.0 });
    scene.add_medium(Medium {
        absorption: sigma.map(|s| (s * (1.0 - albedo)) as f32),
        scattering: sigma.map(|s| (s * albedo) as f32),
        extent: Extent::Around { centre: [0.0; 3], radius: radius as f32 },
        ..Medium::default()
    });
    let world = world_of(&scene, false);
    let found = seen(&world, [0.0; 3], [0.0, 0.0, 1.0], &path(1 << 10, 2));
    let expected = sigma.map(|s| {
        let steps = 1000;
        let at = |k: u32| (f64::from(k) + 0.5) / f64::from(steps) * 6.0;
        let lit = |t: f64| (-s * (t + (radius * radius - t * t).sqrt())).exp();
        s * albedo / (4.0 * PI) * (0..steps).map(|k| lit(at(k))).sum::<f64>() * 6.0 / f64::from(steps)
    });
    near(found, expected, 0.005, "lit from the side");
    let noise = spread(&world, &path(64, 2));
    assert!(noise < 0.03, "{noise}");
}

/// A body of a medium that absorbs nothing, under the same light from everywhere, is not to be seen.
#[test]
fn furnaces_are_even() {
    for (kind, scattering) in [(0, [1.0, 3.0, 0.2]), (1, [1.0, 3.0, 0.2]), (2, [2.0; 3])] {
        let mut scene = Scene::new();
        let room = emitter(&mut scene, [1.0; 3]);
        let mut shell = sphere([0.0; 3], 20.0, 24, room);
        shell.indices.iter_mut().for_each(|triangle| triangle.reverse());
        shell.normals.iter_mut().flatten().for_each(|n| *n = -*n);
        put_mesh(&mut scene, shell);
        let grid = (kind == 1).then(|| {
            let mut grid = even_grid([-1.0; 3], 2.0, [12; 3]).as_ref().clone();
            grid.density.iter_mut().enumerate().for_each(|(i, d)| *d = (i % 7) as f32 / 3.0);
            Arc::new(grid)
        });
        let phase = Phase { anisotropy: 0.8, second_anisotropy: -0.5, second_share: 0.3 };
        let medium = scene.add_medium(Medium { scattering, phase, grid, ..Medium::default() });
        let material = if kind == 2 {
            let glass = gnurt_scene::Surface::Dielectric {
                ior: 1.3,
                reflectance: [1.0; 3],
                transmittance: [1.0; 3],
                interior: Default::default(),
            };
            scene.add_material(Material { medium: Some(medium), ..Material::of("glass", glass) })
        } else {
            scene.add_material(Material::boundary("air", medium))
        };
        if kind == 1 {
            cube([-1.0; 3], [1.0; 3], material).into_iter().for_each(|mesh| put_mesh(&mut scene, mesh));
        } else {
            put_mesh(&mut scene, sphere([0.0; 3], 1.0, 32, material));
        }
        let world = world_of(&scene, false);
        for eye in [[0.3, 0.2, -5.0], [0.1, 0.2, 0.0]] {
            let found = seen(&world, eye, [0.3, 0.2, 5.0], &path(2048, 4000));
            near(found, [1.0; 3], 0.02, &format!("kind {kind} from {eye:?}"));
        }
    }
}

/// Light that is scattered some fifty times on average, and some hundreds of times in one path of a hundred.
#[test]
fn thick_white_bodies_lose_nothing() {
    let mut scene = Scene::new();
    scene.add_light(environment([1.0; 3]));
    let medium = scene.add_medium(Medium { scattering: [20.0; 3], ..Medium::default() });
    let boundary = scene.add_material(Material::boundary("air", medium));
    cube([-1.0; 3], [1.0; 3], boundary).into_iter().for_each(|mesh| put_mesh(&mut scene, mesh));
    let found = seen(&world_of(&scene, false), [0.3, 0.2, -5.0], [0.3, 0.2, 0.0], &path(1024, 1000));
    near(found, [1.0; 3], 0.02, "a thick body");
}

/// The same light by an environment, which rays find that leave the scene.
#[test]
fn clouds_in_an_even_sky_are_not_seen() {
    for sky in [EVERYWHERE, Extent::Around { centre: [0.0; 3], radius: 2.0 }] {
        let mut scene = Scene::new();
        scene.add_light(environment([1.0; 3]));
        let phase = Phase { anisotropy: 0.5, ..Phase::default() };
        scene.add_medium(Medium { scattering: [0.5, 1.0, 0.1], phase, extent: sky, ..Medium::default() });
        let world = world_of(&scene, false);
        let options = path(if sky == EVERYWHERE { 64 } else { 4096 }, 4000);
        let view = camera([0.0, 0.0, -9.0], [0.0; 3], 0.001);
        let picture = render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture;
        if sky == EVERYWHERE {
            near(mean(&picture), [0.0; 3], 1e-6, "nothing comes from infinitely far away");
        } else {
            near(mean(&picture), [1.0; 3], 0.01, "a ball of fog");
            let alpha = picture.color.iter().map(|pixel| pixel[3]).sum::<f32>() / 16.0;
            assert!((0.6..0.98).contains(&alpha), "fog covers: {alpha}");
        }
    }
}

/// A body in another replaces its medium; priorities choose where they overlap.
#[test]
fn bodies_nest_and_overlap() {
    let (weak, strong) = ([0.1; 3], [1.0; 3]);
    for (priorities, expected) in [([0, 0], 1.0 * 2.0 + 0.1 * 2.0), ([0, 1], 2.2), ([1, 0], 0.1 * 4.0)] {
        let mut scene = Scene::new();
        lamp(&mut scene, [1.0; 3]);
        let boxes = [([-2.0; 3], [2.0; 3], weak), ([-1.0; 3], [1.0; 3], strong)];
        for ((low, high, absorption), priority) in boxes.into_iter().zip(priorities) {
            let medium = scene.add_medium(Medium { absorption, priority, ..Medium::default() });
            let boundary = scene.add_material(Material::boundary("air", medium));
            cube(low, high, boundary).into_iter().for_each(|mesh| put_mesh(&mut scene, mesh));
        }
        let world = world_of(&scene, false);
        let outside = seen(&world, [0.1, 0.2, -5.0], [0.1, 0.2, 9.0], &path(1, 2));
        near(outside, [f64::exp(-expected); 3], 1e-4, &format!("{priorities:?} from outside"));
        let within = seen(&world, [0.1, 0.2, 0.0], [0.1, 0.2, 9.0], &path(1, 2));
        near(within, [f64::exp(-expected / 2.0); 3], 1e-4, &format!("{priorities:?} from within"));
    }
}

/// Bodies that add replace nothing: neither other bodies nor what is around.
#[test]
fn bodies_add() {
    let mut scene = Scene::new();
    lamp(&mut scene, [1.0; 3]);
    scene.add_medium(Medium { absorption: [0.05; 3], extent: EVERYWHERE, ..Medium::default() });
    // The third is whole, and has no other within it.
    for (low, high, absorption, adds) in
        [(-2.0, 2.0, 0.1, true), (-1.0, 1.0, 1.0, true), (-0.5, 0.5, 0.3, false)]
    {
        let medium = scene.add_medium(Medium { absorption: [absorption; 3], adds, ..Medium::default() });
        let boundary = scene.add_material(Material::boundary("air", medium));
        cube([low; 3], [high; 3], boundary).into_iter().for_each(|mesh| put_mesh(&mut scene, mesh));
    }
    let world = world_of(&scene, false);
    let outside = seen(&world, [0.1, 0.2, -5.0], [0.1, 0.2, 9.0], &path(1, 2));
    let expected: f64 = 0.05 * 14.0 + 0.1 * 4.0 + 1.0 * 2.0 + 0.3;
    near(outside, [(-expected).exp(); 3], 1e-4, "from outside");
    let within = seen(&world, [0.1, 0.2, 0.0], [0.1, 0.2, 9.0], &path(1, 2));
    let expected: f64 = 0.05 * 9.5 + 0.1 * 2.0 + 1.0 + 0.3 * 0.5;
    near(within, [(-expected).exp(); 3], 1e-4, "from within");
}

/// Shadow rays see media, and levels agree.
#[test]
fn lit_through_a_body_at_every_level() {
    let mut scene = floor(0.5, 50.0);
    scene.add_light(Light::Point { position: [0.0, 0.0, 6.0], intensity: [36.0; 3], radius: 0.0 });
    let absorption = [0.2, 0.5, 0.0];
    let medium = scene.add_medium(Medium { absorption, scattering: [1e-3; 3], ..Medium::default() });
    let boundary = scene.add_material(Material::boundary("air", medium));
    cube([-1.0, -1.0, 2.0], [1.0, 1.0, 4.0], boundary)
        .into_iter()
        .for_each(|mesh| put_mesh(&mut scene, mesh));
    let world = world_of(&scene, false);
    let mut all = Vec::new();
    for level in gnurt_simd::Level::available() {
        let options = RenderOptions { level, ..path(64, 3) };
        let found = seen(&world, [9.0, 0.0, 1.0], [0.0; 3], &options);
        let expected = absorption.map(|a| 0.5 / PI * (-2.0 * (f64::from(a) + 1e-3)).exp());
        near(found, expected, 0.01, "through the body");
        all.push(found);
    }
    assert!(all.iter().all(|found| *found == all[0]), "the same bits: {all:?}");
}
