// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of what mirrors and smooth glass show: by laws of reflection, and light that agrees with that of paths.

use crate::common::*;
use gnurt_image::{ChannelData, Picture};
use gnurt_render::{Accumulation, Integrator, LightLayer, RenderOptions, Silent, render};
use gnurt_scene::material::Color;
use gnurt_scene::{Material, Scene, Surface};

fn seen(width: u32, height: u32, spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, aovs: true, seen: true, ..options(width, height, spp) }
}

fn layer(picture: &Picture, name: &str, channels: [&str; 3]) -> Vec<[f32; 3]> {
    let plane = |channel: &str| match &picture.layer(name).expect(name).channel(channel).expect(channel).data
    {
        ChannelData::F32(values) => values.clone(),
        ChannelData::U32(_) => panic!("{name}.{channel} has ids"),
    };
    let [a, b, c] = channels.map(plane);
    (0..a.len()).map(|i| [a[i], b[i], c[i]]).collect()
}

const RGB: [&str; 3] = ["R", "G", "B"];

/// A mirror on the floor, a red wall behind it, and a sky.
fn hall(reflectance: f32) -> Scene {
    let mut scene = Scene::new();
    let mirror = Surface::Mirror { reflectance: Color::constant([reflectance; 3]) };
    let mirror = scene.add_material(Material::of("mirror", mirror));
    put_mesh(&mut scene, quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], mirror));
    let red = matte(&mut scene, [0.8, 0.2, 0.1]);
    put_mesh(&mut scene, quad([-9.0, 4.0, 0.0], [18.0, 0.0, 0.0], [0.0, 0.0, 2.0], red));
    scene.add_light(environment([0.5, 0.6, 0.7]));
    scene
}

#[test]
fn mirrors_show_albedo_and_normal_of_what_is_in_them() {
    let world = world_of(&hall(0.5), false);
    // Downwards: from height 1, the floor at y = -1.5 shows the wall at a height of 1.8, and at y = 0 one above it.
    let picture = |target: [f32; 3]| {
        let view = camera([0.0, -4.0, 1.0], target, 0.1);
        render(&world, &view, &seen(4, 4, 4), &pool(1), &Silent).expect("sound").picture
    };
    let wall = picture([0.0, -1.2, 0.0]);
    for pixel in layer(&wall, "seen_albedo", RGB) {
        assert!(
            (pixel[0] - 0.4).abs() < 1e-5 && (pixel[1] - 0.1).abs() < 1e-5,
            "half of the wall: {pixel:?}"
        );
    }
    for normal in layer(&wall, "seen_N", ["X", "Y", "Z"]) {
        assert!((normal[1] + 1.0).abs() < 1e-5, "the wall's: {normal:?}");
    }
    assert!((layer(&wall, "albedo", RGB)[0][0] - 0.5).abs() < 1e-5, "first hits keep theirs");
    let sky = picture([0.0, -3.2, 0.0]);
    assert_eq!(layer(&sky, "seen_albedo", RGB)[0], [0.0; 3], "the sky has none");
    for name in ["seen_light", "seen_split"] {
        let light = layer(&sky, name, RGB)[0];
        assert!((light[2] - 0.35).abs() < 1e-5, "{name}: half of the sky: {light:?}");
    }
    for name in ["seen_direct", "seen_direct_variance", "seen_indirect_variance"] {
        assert_eq!(layer(&sky, name, RGB)[0], [0.0; 3], "no other light is there");
    }
}

/// Balls of glass and mirrors below a lamp, before metal.
fn balls(roughness: f32) -> Scene {
    let mut scene = floor(0.6, 4.0);
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [0.9, 1.0, 0.95],
        interior: Default::default(),
    };
    let glass = scene.add_material(Material::of("glass", glass));
    let mirror = Surface::Mirror { reflectance: Color::constant([0.9; 3]) };
    let mirror = scene.add_material(Material::of("mirror", mirror));
    let metal = Surface::Metal { eta: [0.2, 0.9, 1.2], k: [3.9, 2.4, 2.2], roughness };
    let metal = scene.add_material(Material::of("metal", metal));
    put_mesh(&mut scene, quad([-1.5, 1.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.3, 2.5], metal));
    put_mesh(&mut scene, sphere([-0.8, 0.0, 0.7], 0.7, 16, glass));
    put_mesh(&mut scene, sphere([0.8, 0.0, 0.7], 0.7, 16, mirror));
    let lamp = emitter(&mut scene, [20.0, 18.0, 15.0]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 3.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], lamp));
    scene.add_light(environment([0.2, 0.3, 0.5]));
    scene
}

#[test]
fn light_of_all_branches_agrees_with_that_of_paths() {
    let world = world_of(&balls(0.0), false);
    let view = camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0);
    let frame = render(&world, &view, &seen(40, 30, 256), &pool(1), &Silent).expect("sound");
    let [light, split] = ["seen_light", "seen_split"].map(|name| layer(&frame.picture, name, RGB));
    let sum = |pixels: &[[f32; 3]]| pixels.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>();
    // By the deviation of the sum of all differences, which are independent.
    let difference = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(a[0] + a[1] + a[2] - b[0] - b[1] - b[2]);
    let differences: Vec<f64> = split.iter().zip(&light).map(difference).collect();
    let deviation = differences.iter().map(|d| d * d).sum::<f64>().sqrt();
    let off = differences.iter().sum::<f64>();
    assert!(off.abs() < 3.5 * deviation && deviation < 0.01 * sum(&light), "means agree: {off}, {deviation}");
    assert!(sum(&light) > 0.1 * 1200.0, "there is some");
    // Limited contributions end the comparison early.
    let clamped = RenderOptions { clamp: Some(2.0), ..seen(40, 30, 64) };
    let frame = render(&world, &view, &clamped, &pool(1), &Silent).expect("sound");
    let [light, split] = ["seen_light", "seen_split"].map(|name| layer(&frame.picture, name, RGB));
    let ratio = sum(&split) / sum(&light);
    assert!((ratio - 1.0).abs() < 0.02, "as far as they are not limited: {ratio}");
}

/// By the light path expression of one scattering behind any number of smooth surfaces, on the same samples.
#[test]
fn direct_light_has_one_scattering_and_variances_are_those_of_samples() {
    let world = world_of(&balls(0.4), false);
    let view = camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0);
    let once = LightLayer::new("once", "C<.S>*<.[DG]>[LBO]").expect("an expression");
    let some = RenderOptions { light_layers: vec![once], ..seen(24, 18, 8) };
    let some = render(&world, &view, &some, &pool(1), &Silent).expect("sound").picture;
    let [direct, once] = ["seen_direct", "once"].map(|name| layer(&some, name, RGB));
    let (mut sum, mut lit) = (0.0, 0);
    for (direct, once) in direct.iter().zip(&once) {
        for k in 0..3 {
            assert!((direct[k] - once[k]).abs() <= 1e-5 * once[k].max(1.0), "{direct:?}, not {once:?}");
            sum += direct[k];
            lit += usize::from(direct[k] > 0.0);
        }
    }
    assert!(sum > 10.0 && lit > 24 * 18, "there is some: {sum} in {lit} colours");
    // Of one picture's samples, beside how much pictures differ.
    let single: Vec<Picture> = (0..32)
        .map(|seed| {
            let options = RenderOptions { seed, ..seen(24, 18, 4) };
            render(&world, &view, &options, &pool(1), &Silent).expect("sound").picture
        })
        .collect();
    for (name, light) in [("seen_direct_variance", 0), ("seen_indirect_variance", 1)] {
        let of = |picture: &Picture| -> Vec<f32> {
            let [direct, light_seen] = ["seen_direct", "seen_light"].map(|name| layer(picture, name, RGB));
            let rest = |p: usize| picture.color[p][1] - direct[p][1] - light_seen[p][1];
            (0..direct.len()).map(|p| if light == 0 { direct[p][1] } else { rest(p) }).collect()
        };
        let values: Vec<Vec<f32>> = single.iter().map(of).collect();
        let (mut expected, mut found) = (0.0, 0.0);
        for p in 0..24 * 18 {
            let mean = values.iter().map(|v| v[p]).sum::<f32>() / 32.0;
            expected += values.iter().map(|v| (v[p] - mean).powi(2)).sum::<f32>() / 31.0;
            found += single.iter().map(|picture| layer(picture, name, RGB)[p][1]).sum::<f32>() / 32.0;
        }
        // Samples of one picture are spread, so that their means differ less than their variance says.
        let ratio = expected / found;
        assert!(ratio > 0.2 && ratio < 1.3 && found > 0.0, "{name}: {ratio}");
    }
}

#[test]
fn polished_metal_shows_what_a_mirror_shows() {
    let gold = |roughness| Surface::Metal { eta: [0.2, 0.9, 1.2], k: [3.9, 2.4, 2.2], roughness };
    let picture = |surface: Surface| {
        let mut scene = hall(0.5);
        let floor = scene.add_material(Material::of("floor", surface));
        put_mesh(&mut scene, quad([-9.0, -9.0, 0.01], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], floor));
        let view = camera([0.0, -4.0, 1.0], [0.0, -1.2, 0.0], 0.1);
        render(&world_of(&scene, false), &view, &seen(4, 4, 4), &pool(1), &Silent).expect("sound").picture
    };
    let (polished, rough) = (picture(gold(0.0)), picture(gold(0.3)));
    let mirror = picture(Surface::Mirror { reflectance: Color::constant([0.9; 3]) });
    let normal = layer(&polished, "seen_N", ["X", "Y", "Z"])[5];
    assert!((normal[1] + 1.0).abs() < 1e-5, "the wall's: {normal:?}");
    let id =
        |picture: &Picture| match &picture.layer("seen_id").expect("ids").channel("prim").expect("prim").data
        {
            ChannelData::U32(values) => values[5],
            ChannelData::F32(_) => panic!("numbers"),
        };
    let depth = |picture: &Picture| layer(picture, "seen_depth", ["Z"; 3])[5][0];
    assert!(id(&polished) == id(&mirror) && (depth(&polished) / depth(&mirror) - 1.0).abs() < 1e-3);
    assert!(depth(&rough) < 0.7 * depth(&mirror), "rough metal shows itself: {}", depth(&rough));
}

#[test]
fn edges_of_lamps_have_less_noise_than_paths_give_them() {
    let world = world_of(&balls(0.0), false);
    let view = camera([0.5, -6.0, 2.5], [0.0, 0.0, 2.0], 40.0);
    let truth = render(&world, &view, &seen(40, 30, 512), &pool(1), &Silent).expect("sound").picture;
    let few = RenderOptions { seed: 5, ..seen(40, 30, 4) };
    let few = render(&world, &view, &few, &pool(1), &Silent).expect("sound").picture;
    let truth = layer(&truth, "seen_split", RGB);
    let error = |name: &str| -> f32 {
        layer(&few, name, RGB).iter().zip(&truth).map(|(a, b)| (a[1] - b[1]).powi(2)).sum()
    };
    let (paths, rays) = (error("seen_light"), error("seen_split"));
    assert!(rays < 0.25 * paths && paths > 1.0, "{rays} by more rays, {paths} by paths");
}

#[test]
fn layers_change_no_picture_and_survive_a_pause() {
    let world = world_of(&balls(0.0), false);
    let view = camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0);
    for integrator in [Integrator::Path, Integrator::Whitted, Integrator::InstantRadiosity] {
        let options = RenderOptions { integrator, vpls: 64, ..seen(24, 18, 4) };
        let whole = render(&world, &view, &options, &pool(1), &Silent).expect("sound").picture;
        let plain = RenderOptions { seen: false, ..options.clone() };
        let plain = render(&world, &view, &plain, &pool(1), &Silent).expect("sound").picture;
        assert!(whole.color == plain.color, "{integrator}: the same colours");
        assert!(plain.layers.iter().all(|layer| !layer.name.starts_with("seen_")), "only on request");
        let mut first = Accumulation::new(options.clone()).expect("sound");
        first.pass(&world, &view, 2, &pool(1), &Silent);
        let mut rest = Accumulation::from_bytes(options, 7, &first.to_bytes(7)).expect("just written");
        rest.pass(&world, &view, 2, &pool(1), &Silent);
        assert!(rest.picture().layers == whole.layers, "{integrator}: the same layers after a pause");
    }
}
