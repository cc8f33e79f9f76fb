// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of light: parts that divide all paths between them make the picture, in a scene of every kind of surface, light and medium.
//! Oracles: the whole; renderings without what a part leaves out; other expressions for the same paths.

use std::sync::Arc;

use crate::common::*;
use gnurt_image::{ChannelData, Picture};
use gnurt_render::{
    Accumulation, Integrator, LightLayer, RenderError, RenderOptions, SceneCamera, Silent, World, render,
    unknown_labels,
};
use gnurt_scene::detail::DiffuseTransmission;
use gnurt_scene::labels::Shining;
use gnurt_scene::material::{Alpha, Color, Opacity, OpacityChannel, Principled};
use gnurt_scene::medium::{DensityGrid, Extent, Medium};
use gnurt_scene::{Affine, Light, LightId, Material, Scene, Surface};
use gnurt_simd::Level;

fn plastic(color: [f32; 3]) -> Surface {
    Surface::Principled(Box::new(Principled {
        base_color: Color::constant(color),
        metallic: 0.0,
        roughness: 0.3,
        clearcoat: 0.4,
        clearcoat_roughness: 0.1,
        ..Principled::default()
    }))
}

/// A room with plastic, a mirror, rough and smooth glass, a leaf, holes, a shadow catcher, lamps, points, a sun, a sky and fog.
fn room(with_fog: bool, catches: bool) -> (World, SceneCamera) {
    room_of(with_fog, catches, true)
}

fn room_of(with_fog: bool, catches: bool, with_glass: bool) -> (World, SceneCamera) {
    let mut scene = Scene::new();
    let add =
        |scene: &mut Scene, name: &str, surface: Surface| scene.add_material(Material::of(name, surface));
    let floor = match catches {
        true => Surface::ShadowCatcher { albedo: [0.5; 3], radiance: [0.2; 3] },
        false => plastic([0.6, 0.5, 0.3]),
    };
    let floor = add(&mut scene, "floor", floor);
    put_mesh(&mut scene, quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], floor));
    let mirror = add(&mut scene, "mirror", Surface::Mirror { reflectance: Color::constant([0.9; 3]) });
    put_mesh(&mut scene, sphere([-1.5, 0.5, 0.7], 0.7, 12, mirror));
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [0.9, 1.0, 0.9],
        interior: Default::default(),
    };
    let glass = if with_glass { glass } else { Surface::Mirror { reflectance: Color::constant([0.5; 3]) } };
    let glass = add(&mut scene, "glass", glass);
    put_mesh(&mut scene, sphere([0.2, -0.8, 0.6], 0.6, 12, glass));
    let frosted = Surface::RoughDielectric {
        ior: 1.4,
        roughness: 0.4,
        reflectance: [1.0; 3],
        transmittance: [1.0; 3],
        thin: true,
        interior: Default::default(),
    };
    let frosted = add(&mut scene, "frosted", frosted);
    put_mesh(&mut scene, quad([1.0, -1.0, 0.0], [1.5, 0.8, 0.0], [0.0, 0.0, 1.6], frosted));
    let leaf = Surface::Principled(Box::new(Principled {
        metallic: 0.0,
        roughness: 0.2,
        diffuse_transmission: DiffuseTransmission { factor: 0.5, color: [0.2, 0.9, 0.1] },
        ..Principled::default()
    }));
    let leaf = add(&mut scene, "leaf", leaf);
    put_mesh(&mut scene, quad([-0.5, 1.0, 0.2], [1.4, 0.3, 0.0], [0.0, 0.2, 1.5], leaf));
    let net = scene.add_material(Material {
        alpha: Alpha::Blend {
            opacity: Opacity { factor: 0.4, texture: None, channel: OpacityChannel::Alpha },
        },
        ..Material::of("net", plastic([0.9, 0.1, 0.1]))
    });
    put_mesh(&mut scene, quad([-2.5, -1.6, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.2], net));
    let lamp =
        scene.add_material(Material { emission: [9.0, 8.0, 6.0], ..Material::matte("lamp", [0.3; 3]) });
    put_mesh(&mut scene, quad([-1.0, -1.0, 4.0], [0.0, 1.5, 0.0], [1.5, 0.0, 0.0], lamp));
    let other = scene.add_material(Material { emission: [1.0, 3.0, 9.0], ..plastic_material("screen") });
    put_mesh(&mut scene, quad([3.0, 2.0, 0.5], [0.0, -1.5, 0.0], [0.0, 0.0, 1.5], other));
    let unlit = add(&mut scene, "sign", Surface::Unlit { color: Color::constant([0.4, 0.1, 0.5]) });
    put_mesh(&mut scene, quad([-3.5, 2.0, 0.5], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8], unlit));
    let bulb =
        scene.add_light(Light::Point { position: [2.0, -2.0, 2.5], intensity: [3.0, 2.5, 2.0], radius: 0.0 });
    let spot = scene.add_light(Light::Spot {
        position: [-3.0, -2.0, 3.0],
        direction: [1.0, 0.7, -1.0],
        intensity: [6.0; 3],
        inner_angle: 0.3,
        outer_angle: 0.6,
        edge: gnurt_scene::ConeEdge::default(),
        radius: 0.0,
    });
    scene.add_light(Light::Directional {
        direction: [0.3, 0.5, -1.0],
        irradiance: [0.4, 0.4, 0.3],
        angle: 0.0,
    });
    let sky = scene.add_light(environment([0.2, 0.3, 0.5]));
    if with_fog {
        let medium = Medium {
            scattering: [0.05, 0.06, 0.08],
            absorption: [0.02; 3],
            emission: [0.1, 0.0, 0.0],
            extent: Extent::Around { centre: [0.0; 3], radius: 6.0 },
            ..Medium::default()
        };
        scene.add_medium(medium);
        let grid = DensityGrid {
            size: [2, 2, 2],
            density: vec![0.2, 1.0, 0.5, 0.1, 0.9, 0.3, 0.2, 0.7],
            emission: Vec::new(),
            world_from_unit: Affine::translation([-1.0, -1.0, 1.5]) * Affine::scale([2.0; 3]),
        };
        let cloud = Medium {
            scattering: [0.9; 3],
            grid: Some(Arc::new(grid)),
            extent: Extent::Around { centre: [0.0; 3], radius: f32::INFINITY },
            ..Medium::default()
        };
        scene.add_medium(cloud);
    }
    let labels = scene.labels_mut();
    labels.lights.insert(spot, "spot".into());
    labels.light_groups.insert(Shining::Light(bulb), "key".into());
    labels.light_groups.insert(Shining::Light(spot), "key".into());
    labels.light_groups.insert(Shining::Light(sky), "sky".into());
    labels.light_groups.insert(Shining::Material(other), "screens".into());
    let eye = if with_fog { [0.5, -7.5, 2.5] } else { [0.5, -6.0, 2.5] };
    (world_of(&scene, false), camera(eye, [0.0, 0.0, 0.8], 45.0))
}

fn plastic_material(name: &str) -> Material {
    Material::of(name, plastic([0.2; 3]))
}

fn words(words: &[&str]) -> Vec<LightLayer> {
    words.iter().map(|word| LightLayer::of_word(word).expect("a word")).collect()
}

fn by(expressions: &[&str]) -> Vec<LightLayer> {
    let layer = |(i, text): (usize, &&str)| LightLayer::new(format!("e{i}"), *text).expect("sound");
    expressions.iter().enumerate().map(layer).collect()
}

fn layered(light_layers: Vec<LightLayer>, spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, light_layers, ..options(40, 30, spp) }
}

/// Pixels of a layer.
fn light(picture: &Picture, name: &str) -> Vec<[f32; 3]> {
    let layer = picture.layer(name).unwrap_or_else(|| panic!("the layer {name}"));
    let channel = |name: &str| match layer.channel(name).map(|channel| &channel.data) {
        Some(ChannelData::F32(values)) => values.clone(),
        other => panic!("{other:?}"),
    };
    let [r, g, b] = ["R", "G", "B"].map(channel);
    (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect()
}

/// The largest difference between the sum of some layers and `whole`, relative to the whole or absolute.
fn off(picture: &Picture, names: &[String], whole: &[[f32; 3]]) -> f32 {
    let mut sum = vec![[0.0_f32; 3]; whole.len()];
    for name in names {
        for (sum, part) in sum.iter_mut().zip(light(picture, name)) {
            (0..3).for_each(|k| sum[k] += part[k]);
        }
    }
    let pairs = sum.as_flattened().iter().zip(whole.as_flattened());
    pairs.map(|(a, b)| (a - b).abs() / b.abs().max(1.0)).fold(0.0, f32::max)
}

fn whole_of(picture: &Picture) -> Vec<[f32; 3]> {
    picture.color.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

#[test]
fn parts_make_the_whole() {
    let first = ["emission", "environment", "diffuse", "glossy", "transmission", "volume"];
    let rest = ["C[LO]", "C<RD>.*", "C<RG>.*", "C<RS>.*", "CT.*", "CV.*", "CB"];
    let partitions = [
        words(&["emission", "environment", "direct", "indirect"]),
        words(&first),
        by(&rest),
        by(&["C.*L", "C.*O", "C.*B"]),
        by(&["C<..'floor'>.*", "C<..'mirror'>.*", "C([^'floor''mirror'][RTV]*)?[LOB]"]),
        LightLayer::of_groups(&["key", "sky", "screens"]),
        by(&["C.*<[LO].'lamp'>", "C.*<L.'spot'>", "C[RTV]*<[LOB].[^'lamp''spot']>"]),
    ];
    for (with_fog, catches) in [(false, false), (true, false), (false, true)] {
        let (world, camera) = room(with_fog, catches);
        for clamp in [None, Some(0.4)] {
            let plain = RenderOptions { clamp, ..layered(Vec::new(), 6) };
            let pool = pool(1);
            let plain = render(&world, &camera, &plain, &pool, &Silent).expect("sound").picture;
            let whole = whole_of(&plain);
            for (number, layers) in partitions.iter().enumerate() {
                let names: Vec<String> = layers.iter().map(|layer| layer.name.clone()).collect();
                let options = RenderOptions { clamp, ..layered(layers.clone(), 6) };
                let picture = render(&world, &camera, &options, &pool, &Silent).expect("sound").picture;
                assert_eq!(picture.color, plain.color, "layers change no bit of the picture");
                let off = off(&picture, &names, &whole);
                assert!(off < 1e-5, "fog {with_fog}, catcher {catches}, {clamp:?}, {number}: {off}");
                for name in &names {
                    let is_black = light(&picture, name).as_flattened().iter().all(|&x| x == 0.0);
                    let may_be =
                        name.starts_with("volume") || name == "e5" || name.starts_with("e2") || catches;
                    assert!(!is_black || may_be, "{name} of partition {number} is black");
                }
            }
        }
    }
}

/// With virtual lights: the parts make the picture, and are those of paths in the mean.
#[test]
fn parts_by_virtual_lights_make_the_whole() {
    let names = ["emission", "environment", "direct", "indirect"];
    let (world, camera) = room_of(false, false, false);
    let pool = pool(1);
    let sum = |picture: &Picture, name: &str| -> f64 {
        light(picture, name).as_flattened().iter().map(|&x| f64::from(x)).sum()
    };
    let of_paths =
        render(&world, &camera, &layered(words(&names), 128), &pool, &Silent).expect("sound").picture;
    for integrator in Integrator::ALL.into_iter().filter(|integrator| integrator.has_virtual_lights()) {
        let by = |light_layers: Vec<LightLayer>, spp| {
            let options = RenderOptions { integrator, vpls: 128, ..layered(light_layers, spp) };
            render(&world, &camera, &options, &pool, &Silent).expect("sound").picture
        };
        let [plain, few] = [Vec::new(), words(&names)].map(|layers| by(layers, 2));
        assert_eq!(few.color, plain.color, "layers change no bit of the picture");
        let picture = by(words(&names), 16);
        let off = off(&picture, &names.map(String::from), &whole_of(&picture));
        assert!(off < 1e-5, "{integrator}: {off}");
        for name in names {
            let (found, expected) = (sum(&picture, name), sum(&of_paths, name));
            // The mirror's caustics of points and the sun are unknown to paths.
            let most = if name == "indirect" { 0.1 } else { 0.04 };
            assert!((found / expected - 1.0).abs() < most, "{integrator}, {name}: {found}, {expected}");
        }
    }
}

#[test]
fn parts_have_their_own_parts() {
    let (world, camera) = room(true, false);
    let all: Vec<LightLayer> = LightLayer::words().filter_map(LightLayer::of_word).collect();
    let frame = render(&world, &camera, &layered(all, 4), &pool(1), &Silent).expect("sound");
    for word in ["diffuse", "glossy", "transmission", "volume"] {
        let parts = ["direct", "indirect"].map(|part| format!("{word}_{part}"));
        let off = off(&frame.picture, &parts, &light(&frame.picture, word));
        assert!(off < 1e-5, "{word}: {off}");
    }
}

/// Colours equal the scattered share of light from all sides.
#[test]
fn colors_are_those_of_a_furnace() {
    let metal = Principled {
        base_color: Color::constant([0.9, 0.6, 0.2]),
        metallic: 1.0,
        roughness: 0.5,
        ..Principled::default()
    };
    let leaf = Principled {
        metallic: 0.0,
        roughness: 0.4,
        diffuse_transmission: DiffuseTransmission { factor: 0.5, color: [0.2, 0.9, 0.1] },
        ..Principled::default()
    };
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [1.0; 3],
        transmittance: [0.9, 1.0, 0.9],
        interior: Default::default(),
    };
    let frosted = Surface::RoughDielectric {
        ior: 1.4,
        roughness: 0.3,
        reflectance: [1.0; 3],
        transmittance: [0.5, 1.0, 1.0],
        thin: true,
        interior: Default::default(),
    };
    let half = Opacity { factor: 0.4, texture: None, channel: OpacityChannel::Alpha };
    let there_in_part =
        Material { alpha: Alpha::Blend { opacity: half }, ..Material::of("net", plastic([0.9, 0.1, 0.1])) };
    let all = [
        plastic_material("plastic"),
        Material::matte("matte", [0.8, 0.5, 0.1]),
        Material::of("metal", Surface::Principled(Box::new(metal))),
        Material::of("leaf", Surface::Principled(Box::new(leaf))),
        Material::of("glass", glass),
        Material::of("frosted", frosted),
        Material::of("mirror", Surface::Mirror { reflectance: Color::constant([0.9, 0.5, 0.3]) }),
        there_in_part,
    ];
    for material in all {
        let mut scene = Scene::new();
        let name = material.name.clone();
        let material = scene.add_material(material);
        put_mesh(&mut scene, quad([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], material));
        scene.add_light(environment([1.0; 3]));
        let world = world_of(&scene, false);
        let camera = camera([0.0, -2.0, 3.0], [0.0, 0.0, 0.0], 20.0);
        let kinds = ["diffuse", "glossy", "transmission"];
        let mut layers = by(&["C<RD>B", "C<R[GS]>B", "CTB"]);
        layers.extend(kinds.iter().filter_map(|kind| LightLayer::of_word(&format!("{kind}_color"))));
        let options = layered(layers, 64);
        let picture = render(&world, &camera, &options, &pool(1), &Silent).expect("sound").picture;
        for (i, kind) in kinds.iter().enumerate() {
            let mean = |name: &str| {
                let light = light(&picture, name);
                let sum = light.iter().fold([0.0; 3], |sum: [f32; 3], p| [0, 1, 2].map(|k| sum[k] + p[k]));
                sum.map(|x| x / light.len() as f32)
            };
            let (found, expected) = (mean(&format!("{kind}_color")), mean(&format!("e{i}")));
            let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 0.03 * b + 0.003);
            assert!(near, "{kind} of {name}: {found:?} instead of {expected:?}");
        }
    }
}

/// Light of paths with two edges equals a rendering with two edges.
#[test]
fn direct_light_is_that_of_short_paths() {
    // Light of points through smooth glass counts as direct, though its paths are longer.
    for with_fog in [false, true] {
        let (world, camera) = room_of(with_fog, false, false);
        let layers = words(&["emission", "environment", "direct"]);
        let names: Vec<String> = layers.iter().map(|layer| layer.name.clone()).collect();
        let frame = render(&world, &camera, &layered(layers, 8), &pool(1), &Silent).expect("sound");
        let short = RenderOptions { max_depth: 2, ..layered(Vec::new(), 8) };
        let short = render(&world, &camera, &short, &pool(1), &Silent).expect("sound").picture;
        let off = off(&frame.picture, &names, &whole_of(&short));
        assert!(off < 1e-5, "fog {with_fog}: {off}");
    }
}

/// Without its colour, plastic reflects by its glossy lobes alone; the rest is diffuse.
#[test]
fn lobes_are_told_apart_by_colour() {
    let scene = |color| {
        let mut scene = Scene::new();
        let floor = scene.add_material(Material::of("floor", plastic(color)));
        put_mesh(&mut scene, quad([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], floor));
        let lamp = emitter(&mut scene, [3.0, 2.0, 1.0]);
        put_mesh(&mut scene, quad([-2.0, 1.0, 3.0], [0.0, 2.0, 0.0], [4.0, 0.0, 0.0], lamp));
        scene.add_light(environment([0.3, 0.5, 0.9]));
        scene
    };
    let view = camera([0.0, -4.0, 2.5], [0.0, 0.0, 0.0], 30.0);
    let rendered = |color| {
        let options = layered(words(&["diffuse_direct", "glossy_direct"]), 256);
        let world = world_of(&scene(color), false);
        render(&world, &view, &options, &pool(1), &Silent).expect("sound").picture
    };
    let (colored, black) = (rendered([0.9, 0.4, 0.1]), rendered([0.0; 3]));
    let sum = |picture: &Picture, name: &str| {
        let mut sum = [0.0; 3];
        light(picture, name).iter().for_each(|pixel| (0..3).for_each(|k| sum[k] += f64::from(pixel[k])));
        sum
    };
    let (glossy, expected) = (sum(&colored, "glossy_direct"), sum(&black, "glossy_direct"));
    for k in 0..3 {
        assert_close(glossy[k], expected[k], 0.02, "glossy");
        assert_eq!(sum(&black, "diffuse_direct")[k], 0.0, "a black body");
    }
    let [r, g, b] = sum(&colored, "diffuse_direct");
    let [white_r, white_g, white_b] = sum(&rendered([1.0; 3]), "diffuse_direct");
    assert_close(r / white_r, 0.9, 0.03, "red");
    assert_close(g / white_g, 0.4, 0.03, "green");
    assert_close(b / white_b, 0.1, 0.03, "blue");
}

/// The layer of a group is a picture under its lights alone.
#[test]
fn groups_are_pictures_of_their_lights() {
    let scene = |only: Option<usize>| {
        let mut scene = floor(0.6, 3.0);
        let ball = scene.add_material(Material::of("ball", plastic([0.3, 0.6, 0.8])));
        put_mesh(&mut scene, sphere([0.0, 0.0, 0.8], 0.8, 12, ball));
        let on = |number: usize, x: f32| if only.is_none_or(|only| only == number) { x } else { 0.0 };
        let lamp = emitter(&mut scene, [on(0, 8.0), on(0, 6.0), on(0, 4.0)]);
        put_mesh(&mut scene, quad([-2.0, -2.0, 4.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], lamp));
        scene.add_light(Light::Point { position: [2.0, -1.0, 2.0], intensity: [on(1, 3.0); 3], radius: 0.0 });
        scene.add_light(environment([on(2, 0.2), on(2, 0.3), on(2, 0.5)]));
        let groups = [Shining::Material(lamp), Shining::Light(LightId(0)), Shining::Light(LightId(1))];
        for (shining, name) in groups.into_iter().zip(["lamps", "points", "sky"]) {
            scene.labels_mut().light_groups.insert(shining, name.into());
        }
        scene
    };
    let view = camera([0.5, -5.0, 3.0], [0.0, 0.0, 0.5], 40.0);
    let layers = LightLayer::of_groups(&["lamps", "points", "sky"]);
    let world = world_of(&scene(None), false);
    let all = render(&world, &view, &layered(layers, 256), &pool(1), &Silent).expect("sound").picture;
    for (number, group) in ["lamps", "points", "sky"].into_iter().enumerate() {
        let world = world_of(&scene(Some(number)), false);
        let alone = render(&world, &view, &layered(Vec::new(), 256), &pool(1), &Silent).expect("sound");
        let part = light(&all, &format!("light.{group}"));
        for k in 0..3 {
            let sum = |pixels: &[[f32; 3]]| pixels.iter().map(|pixel| f64::from(pixel[k])).sum::<f64>();
            assert_close(sum(&part), sum(&whole_of(&alone.picture)), 0.02, group);
        }
    }
    assert!(light(&all, "light_rest").as_flattened().iter().all(|&x| x == 0.0), "all have a group");
}

#[test]
fn layers_have_the_same_bits_however_they_are_made() {
    let (world, camera) = room(true, false);
    let all: Vec<LightLayer> = LightLayer::words().filter_map(LightLayer::of_word).collect();
    let options = RenderOptions { aovs: true, ..layered(all, 5) };
    let whole = render(&world, &camera, &options, &pool(1), &Silent).expect("sound").picture;
    let scalar = RenderOptions { level: Level::Scalar, ..options.clone() };
    let scalar = render(&world, &camera, &scalar, &pool(1), &Silent).expect("sound").picture;
    assert!(whole.layers == scalar.layers, "one by one");
    let mut begun = Accumulation::new(options.clone()).expect("sound");
    begun.pass(&world, &camera, 2, &pool(1), &Silent);
    let bytes = begun.to_bytes(7);
    let mut resumed = Accumulation::from_bytes(options.clone(), 7, &bytes).expect("its own bytes");
    while !resumed.is_complete() {
        resumed.pass(&world, &camera, 1, &pool(1), &Silent);
    }
    assert!(resumed.picture().layers == whole.layers, "from a checkpoint");
    let fewer = RenderOptions { light_layers: words(&["direct"]), ..options };
    assert!(Accumulation::from_bytes(fewer, 7, &bytes).is_err(), "of another picture");
}

#[test]
fn what_cannot_be_divided_is_refused() {
    let with = |integrator, layers| RenderOptions { integrator, ..layered(layers, 1) };
    let all = Integrator::ALL.into_iter();
    for integrator in all.filter(|integrator| integrator.without_pilot() != Integrator::Path) {
        for (layers, is_simple) in [
            (words(&["direct"]), true),
            (words(&["direct", "diffuse"]), false),
            (LightLayer::of_groups(&["key"]), false),
        ] {
            match Accumulation::new(with(integrator, layers)) {
                Ok(_) => assert!(is_simple && integrator.has_virtual_lights(), "{integrator}"),
                Err(error) => {
                    assert!(!(is_simple && integrator.has_virtual_lights()), "{integrator}");
                    assert!(matches!(error, RenderError::LayersOfLight { .. }), "{error}");
                }
            }
        }
    }
    let interleaved = with(Integrator::InstantRadiosity, words(&["direct"]));
    let error = Accumulation::new(RenderOptions { interleave: 3, ..interleaved }).expect_err("blurred");
    assert!(matches!(error, RenderError::InterleavedLayers), "{error}");
    let broken = LightLayer { name: "x".into(), expression: "C<RD".into() };
    let error = Accumulation::new(layered(vec![broken], 1)).expect_err("a fault");
    assert!(error.to_string().contains("character 2"), "{error}");
    let (world, _) = room(false, false);
    let layers = by(&["C.*<L.'kye'>", "C<RD'floor'>.*<L.'@key'>", "C.*<L.'spot'>", "C.*<L.'@spot'>"]);
    assert_eq!(unknown_labels(&world, &layers), Ok(vec!["@spot".into(), "kye".into()]), "slips");
}
