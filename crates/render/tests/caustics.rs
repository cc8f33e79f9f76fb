// SPDX-License-Identifier: GPL-3.0-or-later
//! Searches for lamps behind mirrors and glass: closed forms of plane mirrors and slabs, brute force, the same bytes however a
//! picture is divided, and without smooth surfaces.

use std::f64::consts::PI;

use crate::common::*;
use gnurt_render::{Caustics, Integrator, RenderOptions, SceneCamera, Silent, World, render};
use gnurt_scene::detail::Interior;
use gnurt_scene::material::Color;
use gnurt_scene::{Light, Material, MaterialId, Mesh, Primitives, Scene, Surface};

const ALBEDO: f32 = 0.6;
const VIRTUAL: [Integrator; 3] = [
    Integrator::InstantRadiosity,
    Integrator::BidirectionalInstantRadiosity,
    Integrator::MetropolisInstantRadiosity,
];

fn with(spp: u32, max_depth: u32, caustics: Caustics) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth, caustics, ..options(4, 4, spp) }
}

/// Radiance near the origin, seen from just above.
fn measured(world: &World, options: &RenderOptions) -> f64 {
    let view = camera([0.01, 0.0, 0.05], [0.0; 3], 0.01);
    mean(&render(world, &view, options, &pool(1), &Silent).expect("sound options").picture)[0]
}

fn mirror(scene: &mut Scene) -> MaterialId {
    scene.add_material(Material::of("", Surface::Mirror { reflectance: Color::constant([0.9; 3]) }))
}

fn glass(scene: &mut Scene, ior: f32, interior: Interior) -> MaterialId {
    let (reflectance, transmittance) = ([1.0; 3], [1.0; 3]);
    scene.add_material(Material::of("", Surface::Dielectric { ior, reflectance, transmittance, interior }))
}

/// A wall of mirror at x = 2 shows each lamp once more.
#[test]
fn plane_mirrors_show_lamps_once_more() {
    let lamp = [1.0, 0.5, 1.5];
    for kind in 0..4 {
        let mut scene = floor(ALBEDO, 20.0);
        let mirror = mirror(&mut scene);
        put_mesh(&mut scene, quad([2.0, -20.0, 0.0], [0.0, 0.0, 20.0], [0.0, 40.0, 0.0], mirror));
        let lit = |x: f64| 7.0 * 1.5 / (x * x + 0.25 + 2.25).powf(1.5);
        // A disc that faces the lit point: the floor, or the mirror a third of the way from the lamp.
        let radius = 0.4_f32;
        let square = f64::from(radius * radius);
        let wide = |x: f64, by: f64| lit(x) * (x * x + 2.5) / (x * x + 2.5 + by * by * square);
        let discs = (wide(1.0, 1.0), wide(3.0, 3.0));
        let (direct, image) = [(lit(1.0), lit(3.0)), (0.0, lit(3.0)), (1.6, 1.6), discs][kind];
        let light = match kind {
            0 => Light::Point { position: lamp, intensity: [7.0; 3], radius: 0.0 },
            // From behind it lights the mirror only.
            1 => Light::Spot {
                position: lamp,
                direction: [1.0, -0.5 / 3.0, -0.5],
                intensity: [7.0; 3],
                inner_angle: 0.4,
                outer_angle: 0.5,
                edge: gnurt_scene::ConeEdge::default(),
                radius: 0.0,
            },
            3 => Light::Point { position: lamp, intensity: [7.0; 3], radius },
            _ => Light::Directional { direction: [0.6, 0.0, -0.8], irradiance: [2.0; 3], angle: 0.0 },
        };
        scene.add_light(light);
        let world = world_of(&scene, false);
        let scale = f64::from(ALBEDO) / PI;
        for (caustics, share) in [(Caustics::Off, 0.0), (Caustics::Auto, 0.9), (Caustics::On, 0.9)] {
            let expected = scale * (direct + share * image);
            let found = measured(&world, &with(512, 3, caustics));
            assert!(
                (found - expected).abs() <= 0.02 * expected.max(1e-3),
                "{kind} {caustics}: {found}, not {expected}"
            );
        }
        let few = measured(&world, &with(4, 2, Caustics::On));
        assert!(
            (few - scale * direct).abs() <= [1e-3, 1e-3, 1e-3, 0.02][kind] * direct,
            "{kind}: two edges are too few: {few}"
        );
    }
}

/// Share of unpolarized light that a face of glass lets through, at the sine outside.
fn face(sine: f64, ior: f64) -> f64 {
    let (cos, inside) = ((1.0 - sine * sine).sqrt(), (1.0 - (sine / ior).powi(2)).sqrt());
    let (s, p) = ((cos - ior * inside) / (cos + ior * inside), (ior * cos - inside) / (ior * cos + inside));
    1.0 - (s * s + p * p) / 2.0
}

/// Irradiance of a floor `across` from the foot of a point lamp of intensity 1, `open` of whose height is air and the rest a slab
/// that absorbs by Beer's law.
fn behind_a_slab(across: f64, open: f64, thickness: f64, ior: f64, absorption: f64) -> f64 {
    let inside = |sine: f64| (1.0 - (sine / ior).powi(2)).sqrt();
    let reach =
        |sine: f64| open * sine / (1.0 - sine * sine).sqrt() + thickness * (sine / ior) / inside(sine);
    let (mut low, mut high) = (0.0, 1.0 - 1e-9);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if reach(middle) < across { low = middle } else { high = middle }
    }
    let (sine, step) = (low, 1e-5);
    let slope = (reach(sine + step) - reach(sine - step)) / (2.0 * step);
    let cos = (1.0 - sine * sine).sqrt();
    // Solid angle over area, ring by ring; the angle's change is that of its sine over its cosine.
    sine / (cos * slope * across) * face(sine, ior).powi(2) * (-absorption * thickness / inside(sine)).exp()
}

/// A level slab from 0.5 to 1, over the whole floor.
fn slab(scene: &mut Scene, glass: MaterialId) {
    put_mesh(scene, quad([-20.0, -20.0, 1.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], glass));
    put_mesh(scene, quad([-20.0, -20.0, 0.5], [0.0, 40.0, 0.0], [40.0, 0.0, 0.0], glass));
}

/// A point lamp above a slab: it bends light, so that light samples do not find it.
#[test]
fn slabs_bend_the_light_of_points() {
    let (ior, density) = (1.5, 0.7_f64);
    for (across, absorbs) in [(0.5_f64, false), (2.0, false), (2.0, true)] {
        let mut scene = floor(ALBEDO, 20.0);
        let interior = Interior {
            attenuation_color: [(-density).exp() as f32; 3],
            attenuation_distance: if absorbs { 1.0 } else { f32::INFINITY },
            ..Interior::default()
        };
        let glass = glass(&mut scene, ior as f32, interior);
        slab(&mut scene, glass);
        scene.add_light(Light::Point {
            position: [across as f32, 0.0, 2.0],
            intensity: [7.0; 3],
            radius: 0.0,
        });
        let world = world_of(&scene, false);
        let absorption = if absorbs { density } else { 0.0 };
        let expected = f64::from(ALBEDO) / PI * 7.0 * behind_a_slab(across, 1.5, 0.5, ior, absorption);
        let found = measured(&world, &with(2048, 4, Caustics::Auto));
        assert_close(found, expected, 0.04, &format!("{across} across"));
        assert_eq!(measured(&world, &with(16, 4, Caustics::Off)), 0.0, "by chance nothing");
        assert_eq!(measured(&world, &with(16, 3, Caustics::Auto)), 0.0, "too few edges");
    }
}

/// Virtual lights leave lamps behind glass to searches, too.
#[test]
fn virtual_lights_search_at_what_is_seen() {
    let mut scene = floor(ALBEDO, 20.0);
    let glass = glass(&mut scene, 1.5, Interior::default());
    slab(&mut scene, glass);
    scene.add_light(Light::Point { position: [0.5, 0.0, 2.0], intensity: [7.0; 3], radius: 0.0 });
    let world = world_of(&scene, false);
    let expected = f64::from(ALBEDO) / PI * 7.0 * behind_a_slab(0.5, 1.5, 0.5, 1.5, 0.0);
    for integrator in VIRTUAL {
        let with = |spp, caustics| RenderOptions { integrator, vpls: 8, ..with(spp, 4, caustics) };
        assert_close(measured(&world, &with(512, Caustics::Auto)), expected, 0.06, integrator.name());
        assert_eq!(measured(&world, &with(16, Caustics::Off)), 0.0, "by chance nothing");
    }
}

/// The sun straight through a pane is that of light samples; a search does not count it again.
#[test]
fn the_sun_through_a_window_counts_once() {
    let mut scene = floor(ALBEDO, 20.0);
    let glass = glass(&mut scene, 1.5, Interior::default());
    slab(&mut scene, glass);
    scene.add_light(Light::Directional { direction: [0.6, 0.0, -0.8], irradiance: [2.0; 3], angle: 0.0 });
    let world = world_of(&scene, false);
    let [off, on] = [Caustics::Off, Caustics::On].map(|caustics| measured(&world, &with(16, 4, caustics)));
    assert_close(off, f64::from(ALBEDO) / PI * 1.6 * face(0.6, 1.5).powi(2), 1e-3, "by light samples");
    assert_close(on, off, 1e-6, "and with searches");
}

/// A small lamp, a ball of glass and a bowl of mirror on a floor.
fn ball_and_bowl(has_ball: bool, spheres: bool) -> (World, SceneCamera) {
    below_a_lamp(0.3, has_ball, spheres)
}

/// The same below a lamp with edges of this length.
fn below_a_lamp(edge: f32, has_ball: bool, spheres: bool) -> (World, SceneCamera) {
    let mut scene = floor(0.7, 6.0);
    let lamp = emitter(&mut scene, [60.0, 50.0, 40.0]);
    let corner = [-1.05 - 0.5 * edge, -0.65 - 0.5 * edge, 2.8];
    put_mesh(&mut scene, quad(corner, [0.0, edge, 0.0], [edge, 0.0, 0.0], lamp));
    let [glass, mirror] = [glass(&mut scene, 1.5, Interior::default()), mirror(&mut scene)];
    if has_ball && spheres {
        let ball = Mesh {
            positions: vec![[0.6, 0.3, 0.7]],
            primitives: Primitives::Spheres(vec![0.6]),
            material: glass,
            ..Default::default()
        };
        put_mesh(&mut scene, ball);
    } else if has_ball {
        put_mesh(&mut scene, sphere([0.6, 0.3, 0.7], 0.6, 24, glass));
    } else {
        put_mesh(&mut scene, sphere([0.9, 0.4, 0.4], 0.8, 20, mirror));
    }
    (world_of(&scene, false), camera([-3.0, -3.0, 3.0], [0.3, 0.2, 0.1], 50.0))
}

fn small(spp: u32, caustics: Caustics) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth: 7, caustics, ..options(32, 24, spp) }
}

/// The mean of the picture and its standard error, over pictures of many seeds.
fn statistics(of: &(World, SceneCamera), options: &RenderOptions, seeds: usize) -> [f64; 2] {
    let means = side_by_side(seeds, |number, threads| {
        let options = RenderOptions { seed: 100 + number as u64, ..options.clone() };
        mean(&render(&of.0, &of.1, &options, threads, &Silent).expect("sound options").picture)[1]
    });
    let n = seeds as f64;
    let all = means.iter().sum::<f64>() / n;
    let error = means.iter().map(|mean| (mean - all).powi(2)).sum::<f64>() / (n - 1.0) / n;
    [all, error.sqrt()]
}

/// Where a caustic is, which is nearly all light there: in the focus of a ball, of triangles and as a sphere, and in a bowl.
#[test]
fn the_mean_is_that_of_scattered_rays() {
    for (has_ball, spheres) in [(true, false), (true, true), (false, false)] {
        let mut of = below_a_lamp(if has_ball { 0.8 } else { 0.3 }, has_ball, spheres);
        // A pilot costs as much as 256 samples of each pixel, up to a limit: few pixels have few.
        let (width, height, samples, seeds, direct) = match has_ball {
            true => (8, 8, [128, 256], 6, 0.1),
            false => (16, 12, [1024, 48], 4, 0.96),
        };
        of.1 = match has_ball {
            true => camera([3.4, 1.9, 2.0], [1.15, 0.62, 0.0], 8.0),
            false => camera([-0.4, -0.3, 4.0], [-0.4, -0.35, 0.0], 12.0),
        };
        let with = |spp, caustics| RenderOptions { width, height, ..small(spp, caustics) };
        let [off, off_error] = statistics(&of, &with(samples[0], Caustics::Off), 8);
        let [on, on_error] = statistics(&of, &with(samples[1], Caustics::On), seeds);
        let error = off_error.hypot(on_error);
        let [short, _] = statistics(&of, &RenderOptions { max_depth: 2, ..with(64, Caustics::Off) }, 2);
        assert!(short < direct * off, "there are caustics: {short} of {off} is direct");
        assert!(error < 0.04 * off, "enough samples to tell: {off} within {error}");
        let most = 3.0 * error;
        assert!((on - off).abs() < most, "searched {on}, by chance {off}, standard error {error}");
    }
}

/// Light of a lamp that a slab brings to a floor and a wall, and these to each other: by paths, and by virtual lights, which bring most of
/// it on. Without searches those have no light of a point lamp where it falls.
#[test]
fn virtual_lights_have_the_mean_of_paths() {
    for is_point in [true, false] {
        let mut scene = floor(0.8, 3.0);
        let white = matte(&mut scene, [0.8; 3]);
        put_mesh(&mut scene, quad([-3.0, 1.2, 0.0], [6.0, 0.0, 0.0], [0.0, 0.0, 0.5], white));
        let glass = glass(&mut scene, 1.5, Interior::default());
        slab(&mut scene, glass);
        if is_point {
            scene.add_light(Light::Point { position: [0.2, 0.3, 2.0], intensity: [7.0; 3], radius: 0.3 });
        } else {
            let lamp = emitter(&mut scene, [30.0; 3]);
            put_mesh(&mut scene, quad([0.0, 0.0, 2.0], [0.0, 0.6, 0.0], [0.6, 0.0, 0.0], lamp));
        }
        let of = (world_of(&scene, false), camera([0.0, -0.6, 0.3], [0.1, 1.2, 0.15], 50.0));
        let with = |integrator, caustics, spp| RenderOptions {
            integrator,
            vpls: 32,
            width: 8,
            height: 6,
            ..small(spp, caustics)
        };
        let path = if is_point { Caustics::On } else { Caustics::Off };
        let [path, path_error] =
            statistics(&of, &with(Integrator::Path, path, if is_point { 144 } else { 864 }), 4);
        let [none, _] = statistics(&of, &with(VIRTUAL[1], Caustics::Off, 36), 3);
        for integrator in if is_point { &VIRTUAL[..] } else { &VIRTUAL[1..2] } {
            let [found, error] = statistics(&of, &with(*integrator, Caustics::On, 48), 6);
            let error = error.hypot(path_error);
            assert!(error < 0.035 * path, "enough samples to tell: {integrator} {found} within {error}");
            assert!((found - path).abs() < 3.0 * error, "{integrator} {found}, paths {path}, error {error}");
            assert!(!is_point || none < 0.8 * path, "searches find what others do not: {none} of {path}");
        }
    }
}

/// Threads, levels, pieces and checkpoints.
#[test]
fn divided_pictures_have_the_same_bytes() {
    let (world, _) = ball_and_bowl(true, false);
    // A strip over the ball and its caustic: three tiles, and few pixels for pilots.
    let of = (world, camera([-3.0, -3.0, 3.0], [0.8, 0.4, 0.2], 3.0));
    for integrator in [Integrator::Path, Integrator::BidirectionalInstantRadiosity] {
        let with = |caustics| RenderOptions { integrator, width: 33, height: 1, ..small(4, caustics) };
        let whole = picture_of(&of, &with(Caustics::On), 1);
        let off = picture_of(&of, &with(Caustics::Off), 2);
        assert!(bits(&whole) != bits(&off), "searches are made");
        same_bytes_divided(&of, &with(Caustics::On), &whole, &off);
    }
}

#[test]
fn pictures_without_smooth_surfaces_keep_their_bytes() {
    let mut scene = floor(0.5, 5.0);
    let rough = matte(&mut scene, [0.6, 0.3, 0.2]);
    put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 0.9, 12, rough));
    scene.add_light(Light::Point { position: [1.0, -1.0, 3.0], intensity: [7.0; 3], radius: 0.0 });
    let of = (world_of(&scene, false), camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0));
    let off = bits(&picture_of(&of, &small(4, Caustics::Off), 2));
    for caustics in [Caustics::Auto, Caustics::On] {
        assert!(off == bits(&picture_of(&of, &small(4, caustics), 2)), "{caustics}: nothing to search at");
    }
}
