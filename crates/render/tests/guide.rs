// SPDX-License-Identifier: GPL-3.0-or-later
//! Guided paths: the mean is that of paths without a guide and of closed forms, the bytes are the same however a picture is
//! divided, and `auto` leaves pictures alone that it would not help.

use crate::common::{self, *};
use gnurt_image::Picture;
use gnurt_render::{Accumulation, Guiding, Integrator, RenderOptions, SceneCamera, Silent, World, render};
use gnurt_scene::material::Color;
use gnurt_scene::medium::{Extent, Medium, Phase};
use gnurt_scene::{Material, MaterialId, Scene, Surface};

fn path(width: u32, height: u32, spp: u32, guiding: Guiding) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth: 8, guiding, ..options(width, height, spp) }
}

/// A closed cube from -1 to 1 whose sides look inward.
fn cube(scene: &mut Scene, material: MaterialId) {
    let (a, b) = (-1.0_f32, 2.0_f32);
    for [corner, s, t] in [
        [[a, a, a], [b, 0.0, 0.0], [0.0, b, 0.0]],
        [[a, a, 1.0], [0.0, b, 0.0], [b, 0.0, 0.0]],
        [[a, a, a], [0.0, b, 0.0], [0.0, 0.0, b]],
        [[1.0, a, a], [0.0, 0.0, b], [0.0, b, 0.0]],
        [[a, a, a], [0.0, 0.0, b], [b, 0.0, 0.0]],
        [[a, 1.0, a], [b, 0.0, 0.0], [0.0, 0.0, b]],
    ] {
        put_mesh(scene, quad(corner, s, t, material));
    }
}

/// A closed room whose lamp is above a ceiling of smooth glass, so that light samples never find it. On the floor a ball of
/// polished metal and one of rough metal.
fn room_below_glass() -> (World, SceneCamera) {
    room(0.0)
}

fn glass() -> Material {
    let [reflectance, transmittance] = [[1.0; 3]; 2];
    Material::of(
        "",
        Surface::Dielectric { ior: 1.5, reflectance, transmittance, interior: Default::default() },
    )
}

/// The same with a panel on a wall that light samples find.
fn room(panel: f32) -> (World, SceneCamera) {
    let mut scene = Scene::new();
    let grey = matte(&mut scene, [0.7, 0.6, 0.5]);
    common::room(&mut scene, grey);
    let lamp = emitter(&mut scene, [40.0, 36.0, 30.0]);
    put_mesh(&mut scene, quad([-0.3, -0.3, 2.95], [0.0, 0.6, 0.0], [0.6, 0.0, 0.0], lamp));
    if panel > 0.0 {
        let panel = emitter(&mut scene, [panel; 3]);
        put_mesh(&mut scene, quad([-2.9, 1.9, 0.05], [5.8, 0.0, 0.0], [0.0, 0.0, 2.8], panel));
    }
    let glass = scene.add_material(glass());
    put_mesh(&mut scene, quad([-3.0, -2.0, 2.9], [0.0, 4.0, 0.0], [6.0, 0.0, 0.0], glass));
    let mirror = Surface::Mirror { reflectance: Color::constant([0.9; 3]) };
    let coat = Surface::MetallicRoughness {
        base_color: Color::constant([0.8, 0.3, 0.2]),
        metallic: 0.5,
        roughness: 0.6,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture: None,
    };
    for (y, surface) in [(-0.7, mirror), (0.7, coat)] {
        let material = scene.add_material(Material::of("", surface));
        put_mesh(&mut scene, sphere([-1.5, y, 0.5], 0.5, 12, material));
    }
    (world_of(&scene, false), camera([-2.9, -1.6, 1.6], [-1.0, 0.4, 0.7], 70.0))
}

/// The mean of the picture, its standard error, and the mean of the variance of pixels, over pictures of many seeds.
fn statistics(of: &(World, SceneCamera), options: &RenderOptions, seeds: u64) -> [f64; 3] {
    let pictures: Vec<Picture> = side_by_side(seeds as usize, |number, threads| {
        let options = RenderOptions { seed: 100 + number as u64, ..options.clone() };
        render(&of.0, &of.1, &options, threads, &Silent).expect("sound options").picture
    });
    let n = seeds as f64;
    let means: Vec<f64> = pictures.iter().map(|picture| mean(picture)[1]).collect();
    let all = means.iter().sum::<f64>() / n;
    let error = means.iter().map(|mean| (mean - all).powi(2)).sum::<f64>() / (n - 1.0) / n;
    let count = pictures[0].pixel_count();
    let variance = (0..count).map(|i| {
        let values = pictures.iter().map(|picture| f64::from(picture.color[i][1]));
        let sum: f64 = values.clone().sum();
        (values.map(|value| value * value).sum::<f64>() - sum * sum / n) / (n - 1.0)
    });
    [all, error.sqrt(), variance.sum::<f64>() / count as f64]
}

/// Checks that the mean with a guide is that without, known to this share of it; returns the variances without and with.
fn variances_of_one_mean(
    of: &(World, SceneCamera),
    with: impl Fn(Guiding) -> RenderOptions,
    (seeds, known): (u64, f64),
) -> [f64; 2] {
    let [off, off_error, off_variance] = statistics(of, &with(Guiding::Off), seeds);
    let [on, on_error, on_variance] = statistics(of, &with(Guiding::On), seeds);
    let error = off_error.hypot(on_error);
    assert!(error < known * off, "enough samples to tell: {off} within {error}");
    assert!((on - off).abs() < 4.0 * error, "guided {on}, without {off}, standard error {error}");
    [off_variance, on_variance]
}

#[test]
fn the_mean_stays_and_the_noise_falls() {
    let with = |guiding| path(48, 36, 32, guiding);
    let [off_variance, on_variance] = variances_of_one_mean(&room_below_glass(), with, (6, 0.02));
    assert!(on_variance < 0.7 * off_variance, "variance {on_variance}, without a guide {off_variance}");
}

/// A light sample and a guided ray find the same lamp: both are weighed by the density of the mixture.
#[test]
fn lamps_that_light_samples_find_count_once() {
    let with = |guiding| RenderOptions { max_depth: 3, ..path(48, 36, 32, guiding) };
    variances_of_one_mean(&room(2.0), with, (6, 0.002));
}

/// A ball of fog that scatters forward a little, alone.
fn fog(scattering: f32) -> Scene {
    let mut scene = Scene::new();
    scene.add_medium(Medium {
        scattering: [scattering; 3],
        phase: Phase { anisotropy: 0.4, second_anisotropy: -0.2, second_share: 0.2 },
        extent: Extent::Around { centre: [0.0; 3], radius: 1.0 },
        ..Medium::default()
    });
    scene
}

/// A ball of fog below a lamp behind glass, which light samples do not find, and below a sky of this radiance, which they find.
fn fog_below_lamp(sky: f32) -> (World, SceneCamera) {
    let mut scene = fog(0.5);
    let lamp = emitter(&mut scene, [40.0, 36.0, 30.0]);
    put_mesh(&mut scene, quad([-0.5, -0.5, 2.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], lamp));
    let glass = scene.add_material(glass());
    put_mesh(&mut scene, quad([-0.6, -0.6, 1.9], [0.0, 1.2, 0.0], [1.2, 0.0, 0.0], glass));
    if sky > 0.0 {
        scene.add_light(environment([sky; 3]));
    }
    (world_of(&scene, false), camera([0.0, -4.0, 0.0], [0.0; 3], 25.0))
}

/// Vertices in media learn where light is, as those of surfaces do.
#[test]
fn fog_keeps_its_mean_and_its_noise_falls() {
    let with = |guiding| path(32, 32, 64, guiding);
    let [off_variance, on_variance] = variances_of_one_mean(&fog_below_lamp(0.0), with, (8, 0.03));
    assert!(on_variance < 0.5 * off_variance, "variance {on_variance}, without a guide {off_variance}");
}

/// Light samples in fog are weighed by the density of the mixture, too.
#[test]
fn skies_around_fog_count_once() {
    variances_of_one_mean(&fog_below_lamp(2.0), |guiding| path(32, 32, 64, guiding), (4, 0.01));
}

#[test]
fn fog_in_furnaces_stays_white() {
    let mut scene = fog(3.0);
    scene.add_light(environment([1.0; 3]));
    let (world, view) = (world_of(&scene, false), camera([0.0, -2.5, 0.3], [0.0; 3], 40.0));
    let options = RenderOptions { max_depth: 1000, ..path(24, 24, 64, Guiding::On) };
    let frame = render(&world, &view, &options, &pool(1), &Silent).expect("sound options");
    assert_close(mean(&frame.picture)[0], 1.0, 3e-3, "all light is scattered on");
    let guide = frame.stats.guide.expect("it was asked for");
    assert!(guide.is_on && guide.cells > 0, "something was learned: {guide}");
}

#[test]
fn furnaces_stay_furnaces() {
    let frame = white_under_white(&RenderOptions { max_depth: 1000, ..path(24, 24, 64, Guiding::On) });
    assert_close(mean(&frame.picture)[0], 1.0, 3e-3, "all light is scattered on");
    let guide = frame.stats.guide.expect("it was asked for");
    assert!(guide.is_on && guide.cells > 0, "something was learned: {guide}");
}

#[test]
fn a_shining_box_is_a_geometric_series() {
    let (radiance, rho) = (2.0, 0.7_f64);
    let mut scene = Scene::new();
    let material = scene
        .add_material(Material { emission: [radiance as f32; 3], ..Material::matte("", [rho as f32; 3]) });
    cube(&mut scene, material);
    let view = camera([0.1, 0.2, 0.3], [1.0, 0.4, -0.2], 20.0);
    let world = world_of(&scene, true);
    for edges in [2, 5] {
        let options = RenderOptions { max_depth: edges, ..path(16, 16, 64, Guiding::On) };
        let found = mean(&render(&world, &view, &options, &pool(1), &Silent).expect("sound").picture)[0];
        let expected = radiance * (1.0 - rho.powi(edges as i32)) / (1.0 - rho);
        assert_close(found, expected, 5e-3, &format!("{edges} edges"));
    }
}

#[test]
fn mirrors_keep_their_bits() {
    let mut scene = Scene::new();
    let mirror =
        scene.add_material(Material::of("", Surface::Mirror { reflectance: Color::constant([0.9; 3]) }));
    put_mesh(&mut scene, quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], mirror));
    put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 0.9, 12, mirror));
    scene.add_light(environment([0.3, 0.6, 1.0]));
    let of = (world_of(&scene, false), camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0));
    let [off, on] = [Guiding::Off, Guiding::On].map(|guiding| picture_of(&of, &path(20, 20, 4, guiding), 2));
    assert!(bits(&off) == bits(&on), "mirrors have nothing to guide");
}

/// Threads, levels, pieces, rows, crops, passes and checkpoints.
#[test]
fn divided_pictures_have_the_same_bytes() {
    let room = room_below_glass();
    let options = path(16, 36, 3, Guiding::On);
    let whole = picture_of(&room, &options, 1);
    let off = picture_of(&room, &path(16, 36, 3, Guiding::Off), 2);
    assert!(bits(&whole) != bits(&off), "the guide is on");
    same_bytes_divided(&room, &options, &whole, &off);
    let rows = picture_of(&room, &RenderOptions { rows: Some([32, 36]), ..options.clone() }, 2);
    assert!(bits(&whole)[32 * 16..] == bits(&rows)[..], "the last rows");
    let crop = picture_of(&room, &RenderOptions { crop: Some([5, 10, 14, 30]), ..options.clone() }, 2);
    for y in 10..30 {
        let row = y * 16 + 5..y * 16 + 14;
        assert!(bits(&whole)[row.clone()] == bits(&crop)[row], "row {y} of a crop");
    }
}

/// Where `auto` begins does not depend on passes.
#[test]
fn auto_has_the_same_bytes_pass_by_pass() {
    let room = room_below_glass();
    let from = path(70, 45, 1, Guiding::Auto).guided_from().expect("it is asked for");
    let options = path(70, 45, from + 2, Guiding::Auto);
    let frame = render(&room.0, &room.1, &options, &pool(1), &Silent).expect("sound");
    let guide = frame.stats.guide.expect("there was a pilot");
    assert!(guide.is_on && guide.moment < 0.7, "it pays: {guide}");
    let part = RenderOptions { guiding: Guiding::Off, crop: Some([0, 0, 70, 8]), ..options.clone() };
    let off = picture_of(&room, &part, 2);
    assert!(bits(&frame.picture)[..70 * 8] != bits(&off)[..70 * 8], "the guide is on");
    let mut passes = Accumulation::new(options).expect("sound");
    for samples in [from - 1, 2, 1] {
        passes.pass(&room.0, &room.1, samples, &pool(3), &Silent);
    }
    assert!(passes.is_complete() && bits(&frame.picture) == bits(&passes.picture()), "in three passes");
}

#[test]
fn auto_begins_late_and_only_where_it_pays() {
    let room = room_below_glass();
    let from = path(24, 18, 1, Guiding::Auto).guided_from().expect("it is asked for");
    let [auto, off] = [Guiding::Auto, Guiding::Off].map(|guiding| path(24, 18, from, guiding));
    let frame = render(&room.0, &room.1, &auto, &pool(1), &Silent).expect("sound");
    assert!(frame.stats.guide.is_none(), "no pilot for few samples");
    assert!(bits(&frame.picture) == bits(&picture_of(&room, &off, 2)), "and the same bits");

    // A floor under a sky, and one under a lamp: light samples find all of their light.
    let [mut under_sky, mut under_lamp] = [(); 2].map(|()| floor(0.5, 5.0));
    under_sky.add_light(environment([0.2, 0.3, 0.5]));
    let lamp = emitter(&mut under_lamp, [6.0, 5.0, 4.0]);
    put_mesh(&mut under_lamp, quad([-1.0, -1.0, 2.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], lamp));
    for scene in [under_sky, under_lamp] {
        let open = (world_of(&scene, false), camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0));
        let [auto, off] = [Guiding::Auto, Guiding::Off].map(|guiding| path(24, 18, from + 1, guiding));
        let frame = render(&open.0, &open.1, &auto, &pool(1), &Silent).expect("sound");
        let guide = frame.stats.guide.expect("there was a pilot");
        assert!(!guide.is_on, "it does not pay: {guide}");
        assert!(bits(&frame.picture) == bits(&picture_of(&open, &off, 2)), "the bits of unguided paths");
    }
}

/// In a box that shines evenly lobes cannot be bettered, which the first rounds tell.
#[test]
fn pilots_that_will_not_pay_are_short() {
    let mut scene = Scene::new();
    let shining = scene.add_material(Material { emission: [0.1; 3], ..Material::matte("", [0.9; 3]) });
    cube(&mut scene, shining);
    let of = (world_of(&scene, true), camera([0.1, 0.2, 0.3], [1.0, 0.4, -0.2], 60.0));
    let samples = path(75, 60, 1, Guiding::Auto).guided_from().expect("it is asked for");
    assert_eq!(samples, 32, "those of the pilot, too");
    let options = RenderOptions { max_depth: 6, ..path(75, 60, samples + 1, Guiding::Auto) };
    let frame = render(&of.0, &of.1, &options, &pool(2), &Silent).expect("sound");
    let guide = frame.stats.guide.expect("there was a pilot");
    assert!(!guide.is_on && guide.vertices >= 20_000, "enough to tell: {guide}");
    assert!(guide.vertices <= 4 * 75 * 60 * 6, "four of 32 samples at most: {guide}");
}

/// Long paths in a white box would store five million vertices.
#[test]
fn the_budget_holds() {
    let mut scene = Scene::new();
    let shining = scene.add_material(Material { emission: [0.1; 3], ..Material::matte("", [0.999; 3]) });
    cube(&mut scene, shining);
    let of = (world_of(&scene, true), camera([0.1, 0.2, 0.3], [1.0, 0.4, -0.2], 60.0));
    let options = RenderOptions { max_depth: 40, ..path(40, 30, 1, Guiding::On) };
    let frame = render(&of.0, &of.1, &options, &pool(1), &Silent).expect("sound");
    let guide = frame.stats.guide.expect("it was asked for");
    assert!(guide.vertices > 1 << 20, "more than a few: {guide}");
    assert!(guide.vertices <= 1 << 21 && guide.bytes <= 20 << 20, "no more than are allowed: {guide}");
}
