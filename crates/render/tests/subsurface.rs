// SPDX-License-Identifier: GPL-3.0-or-later
//! Light below surfaces, against plain walks in doubles and the colour of thick bodies.

use crate::common::*;
use gnurt_render::{Integrator, RenderOptions, Silent, World, render};
use gnurt_scene::detail::Subsurface;
use gnurt_scene::material::{Color, Principled};
use gnurt_scene::medium::single_albedo;
use gnurt_scene::{Light, Material, MaterialId, Mesh, Scene, Surface};
use gnurt_simd::Level;

/// A material that only scatters light below its surface, without a gloss; with one if `specular` is above 0.
fn wax(scene: &mut Scene, color: [f32; 3], subsurface: Subsurface, specular: f32) -> MaterialId {
    let surface = Surface::Principled(Box::new(Principled {
        base_color: Color::constant(color),
        metallic: 0.0,
        roughness: 0.3,
        specular,
        subsurface,
        ..Principled::default()
    }));
    scene.add_material(Material::of("wax", surface))
}

fn below(radius: [f32; 3], anisotropy: f32) -> Subsurface {
    Subsurface { factor: 1.0, radius, anisotropy }
}

/// A closed box between two corners.
fn block(low: [f32; 3], high: [f32; 3], material: MaterialId) -> Mesh {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 != 0 { high[axis] } else { low[axis] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        indices: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        material,
        ..Mesh::default()
    }
}

fn path(spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth: 2, ..options(4, 4, spp) }
}

/// Radiance from `eye` towards `target`.
fn seen(scene: &Scene, eye: [f32; 3], target: [f32; 3], options: &RenderOptions) -> [f64; 3] {
    let view = camera(eye, target, 0.001);
    let world: World = world_of(scene, false);
    mean(&render(&world, &view, options, &pool(1), &Silent).expect("sound options").picture)
}

/// A small generator of random numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 ^ self.0 >> 33) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A unit direction around `axis` by the cosine `cos`.
fn turned(axis: [f64; 3], cos: f64, random: &mut Random) -> [f64; 3] {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let helper = if axis[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let along = dot(axis, helper);
    let flat = [0, 1, 2].map(|k| helper[k] - axis[k] * along);
    let length = dot(flat, flat).sqrt();
    let x = flat.map(|f| f / length);
    let y =
        [axis[1] * x[2] - axis[2] * x[1], axis[2] * x[0] - axis[0] * x[2], axis[0] * x[1] - axis[1] * x[0]];
    let (sin, angle) = ((1.0 - cos * cos).max(0.0).sqrt(), std::f64::consts::TAU * random.next());
    [0, 1, 2].map(|k| axis[k] * cos + (x[k] * angle.cos() + y[k] * angle.sin()) * sin)
}

/// Share of light that enters at `start` to all sides alike below the normal `n`, and leaves a body of mean free path 1,
/// where `wall` gives the distance along a ray to its surface, and whether that counts.
fn plain_walks(
    (albedo, g): (f64, f64),
    (start, n): ([f64; 3], [f64; 3]),
    wall: impl Fn([f64; 3], [f64; 3]) -> (f64, bool),
    walks: u32,
) -> f64 {
    let (mut random, mut left) = (Random(7), 0.0);
    for _ in 0..walks {
        let (mut p, mut weight) = (start, 1.0);
        let cos = (1.0 - random.next()).sqrt();
        let mut dir = turned(n.map(|x| -x), cos, &mut random);
        while weight > 1e-4 {
            let t = -(1.0 - random.next()).ln();
            let (far, counts) = wall(p, dir);
            if t > far {
                left += if counts { weight } else { 0.0 };
                break;
            }
            p = [0, 1, 2].map(|k| p[k] + dir[k] * t);
            weight *= albedo;
            let u = random.next();
            let cos = if g == 0.0 {
                1.0 - 2.0 * u
            } else {
                let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
                (1.0 + g * g - s * s) / (2.0 * g)
            };
            dir = turned(dir, cos, &mut random);
        }
    }
    left / f64::from(walks)
}

#[test]
fn thick_bodies_have_their_colour() {
    for anisotropy in [0.0, 0.7] {
        let mut scene = Scene::new();
        let color = [0.9, 0.5, 0.2];
        let material = wax(&mut scene, color, below([1.0, 0.3, 2.0], anisotropy), 0.0);
        put_mesh(&mut scene, block([-500.0, -500.0, -500.0], [500.0, 500.0, 0.0], material));
        scene.add_light(environment([1.0; 3]));
        let found = seen(&scene, [0.0, 0.0, 10.0], [0.1, 0.2, 0.0], &path(2048));
        for (found, expected) in found.into_iter().zip(color) {
            assert_close(found, f64::from(expected), 0.02, "the colour of a thick body");
        }
    }
}

#[test]
fn balls_send_back_the_light_of_plain_walks() {
    for g in [0.0_f32, 0.5] {
        let (radius, mut scene) = ([1.0, 0.5, 0.25], Scene::new());
        let color = [0.8, 0.8, 0.4];
        let material = wax(&mut scene, color, below(radius, g), 0.0);
        put_mesh(&mut scene, sphere([0.0; 3], 1.0, 64, material));
        scene.add_light(environment([1.0; 3]));
        let found = seen(&scene, [0.0, 0.0, 9.0], [0.0; 3], &path(4096));
        for c in 0..3 {
            let size = 1.0 / f64::from(radius[c]);
            let wall = |p: [f64; 3], d: [f64; 3]| {
                let along: f64 = (0..3).map(|k| p[k] * d[k]).sum();
                let square: f64 = p.iter().map(|x| x * x).sum();
                (-along + (along * along - square + size * size).max(0.0).sqrt(), true)
            };
            let albedo = f64::from(single_albedo(color[c], g));
            let start = ([0.0, 0.0, size], [0.0, 0.0, 1.0]);
            let expected = plain_walks((albedo, f64::from(g)), start, wall, 200_000);
            assert_close(found[c], expected, 0.01, &format!("channel {c}, g = {g}"));
        }
    }
}

#[test]
fn light_comes_through_thin_bodies() {
    let mut scene = Scene::new();
    let (color, thickness) = ([0.9, 0.7, 0.5], 2.0);
    let material = wax(&mut scene, color, below([1.0; 3], 0.0), 0.0);
    put_mesh(&mut scene, block([-100.0, -100.0, 0.0], [100.0, 100.0, 2.0], material));
    scene.add_light(Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [1.0; 3], angle: 0.0 });
    let found = seen(&scene, [0.0, 0.0, -9.0], [0.1, 0.2, 0.0], &path(1 << 14));
    for c in 0..3 {
        let wall = |p: [f64; 3], d: [f64; 3]| {
            let far = if d[2] > 0.0 { (thickness - p[2]) / d[2] } else { -p[2] / d[2] };
            (far, d[2] > 0.0)
        };
        let albedo = f64::from(single_albedo(color[c], 0.0));
        let through = plain_walks((albedo, 0.0), ([0.0; 3], [0.0, 0.0, -1.0]), wall, 400_000);
        assert_close(found[c], through / std::f64::consts::PI, 0.02, &format!("channel {c}"));
    }
}

#[test]
fn bodies_within_are_not_met_and_white_wax_under_gloss_keeps_its_light() {
    let picture = |with_core: bool, options: &RenderOptions| {
        let mut scene = Scene::new();
        let material = wax(&mut scene, [0.7, 0.6, 0.5], below([0.5, 0.3, 0.2], 0.0), 0.0);
        put_mesh(&mut scene, sphere([0.0; 3], 1.0, 24, material));
        if with_core {
            let coal = matte(&mut scene, [0.0; 3]);
            put_mesh(&mut scene, sphere([0.0; 3], 0.9, 12, coal));
        }
        scene.add_light(environment([1.0; 3]));
        seen(&scene, [0.0, 0.0, 9.0], [0.0; 3], options)
    };
    let (with, without) = (picture(true, &path(256)), picture(false, &path(256)));
    for c in 0..3 {
        assert_close(with[c], without[c], 1e-4, "a body within another");
    }
    for color in [[1.0; 3], [0.999; 3]] {
        let mut scene = Scene::new();
        let material = wax(&mut scene, color, below([0.05; 3], 0.0), 1.0);
        put_mesh(&mut scene, sphere([0.0; 3], 1.0, 48, material));
        scene.add_light(environment([1.0; 3]));
        let found = seen(&scene, [0.0, 0.0, 9.0], [0.0; 3], &RenderOptions { max_depth: 8, ..path(1024) });
        assert_close(found[0], 1.0, 0.02, "a white body under gloss");
    }
}

#[test]
fn walks_are_the_same_on_all_cpus_and_threads() {
    let mut scene = Scene::new();
    let wax =
        wax(&mut scene, [0.7, 0.6, 0.5], Subsurface { factor: 0.6, ..below([0.5, 0.3, 0.2], 0.3) }, 1.0);
    put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 1.0, 16, wax));
    let ground = matte(&mut scene, [0.5; 3]);
    put_mesh(&mut scene, quad([-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], ground));
    scene.add_light(Light::Point { position: [2.0, 3.0, 4.0], intensity: [30.0; 3], radius: 0.0 });
    scene.add_light(environment([0.2; 3]));
    let view = camera([6.0, 0.0, 3.0], [0.0, 0.0, 1.0], 0.5);
    let world = world_of(&scene, false);
    let render_at = |level: Level, threads: usize| {
        let options =
            RenderOptions { level, max_depth: 5, ..RenderOptions { width: 24, height: 24, ..path(4) } };
        render(&world, &view, &options, &pool(threads), &Silent).expect("sound options").picture.color
    };
    let levels = Level::available();
    let expected = render_at(levels[0], 1);
    for level in levels {
        assert!(expected == render_at(level, 4), "{level:?}");
    }
}

/// Integrators that do not follow light below surfaces show them as diffuse.
#[test]
fn virtual_lights_see_a_diffuse_body() {
    let radiance = |subsurface: Subsurface| {
        let mut scene = Scene::new();
        let material = wax(&mut scene, [0.7, 0.6, 0.5], subsurface, 1.0);
        put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 1.0, 16, material));
        scene.add_light(Light::Point { position: [2.0, 3.0, 4.0], intensity: [30.0; 3], radius: 0.0 });
        let options = RenderOptions { integrator: Integrator::BidirectionalInstantRadiosity, ..path(4) };
        seen(&scene, [6.0, 0.0, 3.0], [0.0, 0.0, 1.0], &options)
    };
    assert_eq!(radiance(below([0.5, 0.3, 0.2], 0.3)), radiance(Subsurface::default()));
}
