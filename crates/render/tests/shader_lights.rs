// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders with only `shade` and `illuminate` under integrators with virtual lights: the same pictures as
//! with closures under the same lights.

use std::f32::consts::PI;
use std::sync::{Arc, LazyLock};

use crate::common::*;
use glam::Vec3;
use gnurt_render::{
    CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};
use gnurt_scene::{Material, MaterialId, Scene, Surface};
use gnurt_shading::{
    EnvironmentShader, LightBatch, LightShader, RadianceShader, RayRequest, SurfaceBatch, SurfaceShader,
    Tracer, Vec3s,
};

const SIZE: u32 = 16;
const ALL: [Integrator; 3] = [
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

/// A light at a point that sends more upwards, or one far away.
struct PluginLight {
    placement: Vec3,
    is_far: bool,
    strength: f32,
}

impl LightShader for PluginLight {
    fn illuminate(&self, p: &Vec3s, _: &Vec3s, _: &[[f32; 2]], out: &mut LightBatch) {
        for i in 0..p.len() {
            let offset = if self.is_far { self.placement } else { self.placement - p.get(i) };
            let dir = offset.normalize();
            out.dir.set(i, dir);
            out.dist[i] = if self.is_far { f32::INFINITY } else { offset.length() };
            let falls = if self.is_far { 1.0 } else { (1.5 - dir.z) / offset.length_squared() };
            out.radiance.set(i, Vec3::splat(self.strength * falls));
        }
    }
}

/// The shader of an old program: light times colour times cosine, one light after the other, with shadows.
struct Diffuse(Vec3);

impl RadianceShader for Diffuse {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let (mut light, mut through) = (LightBatch::default(), Vec3s::default());
        for number in 0..tracer.light_count() {
            tracer.illuminate(number, hits, &mut light);
            let mut request = RayRequest::default();
            for i in 0..hits.len() {
                request.rays.push(hits.spawn_to(i, light.dir.get(i), light.dist[i]));
                request.parent.push(i as u32);
                request.key.push(hits.key[i]);
            }
            tracer.occluded(&request, &mut through);
            for i in 0..hits.len() {
                let cos = hits.facing_ns(i).dot(light.dir.get(i)).max(0.0);
                out.add(i, self.0 * light.radiance.get(i) * through.get(i) * cos);
            }
        }
    }
}

impl SurfaceShader for Diffuse {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }
}

/// A dim sky that only misses see.
struct Sky;

impl EnvironmentShader for Sky {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        (0..dir.len()).for_each(|i| out.set(i, Vec3::new(0.1, 0.2, 0.3) * (1.0 + dir.get(i).z)));
    }
}

/// How a scene is described.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    Materials,
    Shaders,
    /// Every second one.
    Both,
}

/// A room without a front, two blocks in it, and a light in a corner; `white` is the radiance of a white
/// surface under light 1.
fn view(by: By, white: f32, is_far: bool) -> (World, SceneCamera) {
    let mut scene = Scene::new();
    let mut shaders = ShaderTable::default();
    let mut matter = |scene: &mut Scene, color: [f32; 3]| -> MaterialId {
        let number = shaders.surfaces.len() as u32;
        shaders.surfaces.push(Arc::new(Diffuse(Vec3::from(color) * white)));
        if by == By::Materials || by == By::Both && number.is_multiple_of(2) {
            return scene.add_material(Material::matte("", color));
        }
        scene.add_material(Material::of("", Surface::Shader(number)))
    };
    let (x, y, z) = ([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    let walls = [
        ([0.8; 3], [-1.0, -1.0, 0.0], x, y),
        ([0.7; 3], [-1.0, -1.0, 2.0], y, x),
        ([0.8, 0.2, 0.1], [-1.0, -1.0, 0.0], y, z),
        ([0.2, 0.7, 0.1], [1.0, -1.0, 0.0], z, y),
        ([0.8; 3], [-1.0, 1.0, 0.0], x, z),
        ([0.5, 0.5, 0.9], [-0.7, 0.0, 0.7], [0.9, 0.3, 0.0], [0.0, 0.6, 0.2]),
        ([0.9; 3], [0.1, -0.6, 0.3], [0.6, 0.2, 0.2], [0.0, 0.5, 0.0]),
    ];
    for (color, corner, a, b) in walls {
        let material = matter(&mut scene, color);
        put_mesh(&mut scene, quad(corner, a, b, material));
    }
    let placement = if is_far { Vec3::new(0.3, -1.0, 0.6) } else { Vec3::new(-0.5, -0.3, 1.6) };
    // In a light model without pi the same lamp is said to be weaker.
    let strength = if by == By::Materials { 3.0 } else { 3.0 / (PI * white) };
    shaders.lights.push(Arc::new(PluginLight { placement, is_far, strength }));
    shaders.environment = Some(Arc::new(Sky));
    let mut world = World::new();
    world.commit(&scene, &shaders, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    (world, camera([0.0, -3.5, 1.0], [0.0, 0.0, 1.0], 38.0))
}

/// Means of four parts of the picture and three channels, and their standard errors.
fn parts((world, camera): &(World, SceneCamera), options: &RenderOptions) -> Vec<[f64; 2]> {
    const BATCHES: usize = 10;
    let batch = |number: usize, threads: &rayon::ThreadPool| {
        let seed = 100 + number as u64;
        let options = RenderOptions { seed, width: SIZE, height: SIZE, max_depth: 5, ..options.clone() };
        let picture = render(world, camera, &options, threads, &Silent).expect("sound options").picture;
        let mut means = vec![0.0; 12];
        for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))) {
            let part = (2 * y / SIZE * 2 + 2 * x / SIZE) as usize;
            let pixel = picture.pixel(x, y).expect("inside");
            (0..3).for_each(|k| means[part * 3 + k] += f64::from(pixel[k]) * 4.0 / f64::from(SIZE * SIZE));
        }
        means
    };
    let batches: Vec<Vec<f64>> = side_by_side(BATCHES, batch);
    (0..12)
        .map(|i| {
            let n = BATCHES as f64;
            let mean = batches.iter().map(|b| b[i]).sum::<f64>() / n;
            let variance = batches.iter().map(|b| (b[i] - mean).powi(2)).sum::<f64>() / (n * (n - 1.0));
            [mean, variance]
        })
        .collect()
}

#[track_caller]
fn assert_same(found: &[[f64; 2]], expected: &[[f64; 2]], what: &str) {
    let sums = [found, expected].map(|parts| parts.iter().map(|[mean, _]| mean).sum::<f64>());
    // Few batches say little about small errors: those do not count below one per cent.
    let z = |([a, va], [b, vb]): (&[f64; 2], &[f64; 2])| ((a - b) / (va + vb).sqrt().max(0.01 * b)).abs();
    let worst = found.iter().zip(expected).map(z).fold(0.0, f64::max);
    let off = sums[0] / sums[1] - 1.0;
    eprintln!("{what}: mean {off:+.4}, worst z {worst:.2}");
    assert!(off.abs() < 0.025 && worst < 5.0, "{what}: mean off by {off:+.4}, worst z {worst:.2}");
}

fn by(integrator: Integrator, spp: u32) -> RenderOptions {
    RenderOptions { integrator, spp, vpls: 48, pixel_centres: true, ..RenderOptions::default() }
}

/// The scene of materials by paths.
fn by_paths(is_far: bool) -> Vec<[f64; 2]> {
    parts(&view(By::Materials, 1.0, is_far), &by(Integrator::Path, 64))
}

/// Below the near lamp, for several tests.
static NEAR: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| by_paths(false));

#[test]
fn shaders_show_what_materials_show() {
    for is_far in [false, true] {
        let paths = if is_far { &by_paths(true) } else { &*NEAR };
        let variants =
            [(By::Materials, 1.0), (By::Shaders, 1.0), (By::Shaders, 1.0 / PI), (By::Both, 1.0 / PI)];
        for (integrator, variants) in ALL.into_iter().zip([&variants[..], &variants[1..2], &variants[2..3]]) {
            for &(offset, white) in variants {
                let options = RenderOptions { white, ..by(integrator, 8) };
                let found = parts(&view(offset, white, is_far), &options);
                let placement = if is_far { "far away" } else { "near" };
                assert_same(
                    &found,
                    paths,
                    &format!("{integrator}, a lamp {placement}: {offset:?}, white shows {white}"),
                );
            }
        }
    }
}

/// Shows its own light beside the described emission.
struct Glowing;

impl RadianceShader for Glowing {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, Vec3::ONE));
    }
}

impl SurfaceShader for Glowing {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }
}

/// Light samples find a light's emission; only scattered rays find the additional radiance of its shader.
#[test]
fn lamps_may_show_more_than_they_emit() {
    let mut scene = floor(0.8, 4.0);
    let area_light = Material { emission: [1.0; 3], ..Material::of("lamp", Surface::Shader(0)) };
    let area_light = scene.add_material(area_light);
    put_mesh(&mut scene, quad([-1.0, -1.0, 1.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], area_light));
    let shaders = ShaderTable { surfaces: vec![Arc::new(Glowing)], ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(&scene, &shaders, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    let view = camera([2.5, 0.0, 0.4], [0.0, 0.0, 0.0], 1.0);
    let measured = |integrator, spp| {
        let options = RenderOptions { width: 4, height: 4, max_depth: 2, ..by(integrator, spp) };
        mean(&render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture)[0]
    };
    let expected = measured(Integrator::Path, 1024);
    for integrator in ALL {
        assert_close(measured(integrator, 1024), expected, 0.02, &format!("{integrator}"));
    }
}

/// Whatever the bound leaves to rays comes back.
#[test]
fn the_bound_takes_nothing_away() {
    let shaders = view(By::Shaders, 1.0, false);
    for (clamp, spp) in [(0.0, 40), (0.3, 8), (30.0, 8)] {
        let options = RenderOptions { clamp: Some(clamp), ..by(Integrator::InstantRadiosity, spp) };
        assert_same(&parts(&shaders, &options), &NEAR, &format!("bound {clamp}"));
    }
}

/// Each pixel's shader meets its share of the virtual lights.
#[test]
fn shaders_are_interleaved() {
    let (world, camera) = view(By::Shaders, 1.0, false);
    let [full, part] = [1, 3].map(|interleave| {
        let options = RenderOptions { interleave, width: 60, height: 60, vpls: 360, ..by(ALL[0], 2) };
        render(&world, &camera, &options, &pool(1), &Silent).expect("sound options")
    });
    let [expected, found] = [&full, &part].map(|frame| mean(&frame.picture));
    (0..3).for_each(|k| assert_close(found[k], expected[k], 0.02, "light"));
    let [many, few] = [&full, &part].map(|frame| frame.stats.shadow_rays);
    assert!(few * 6 < many, "{few} and {many} shadow rays");
}

#[test]
fn threads_do_not_show() {
    let (world, camera) = view(By::Both, 1.0, false);
    for integrator in ALL {
        let options = RenderOptions { width: 20, height: 20, ..by(integrator, 2) };
        let [one, seven] =
            [1, 7].map(|n| render(&world, &camera, &options, &pool(n), &Silent).expect("sound options"));
        assert_eq!(one.picture.color, seven.picture.color, "{integrator}: bit for bit");
    }
}
