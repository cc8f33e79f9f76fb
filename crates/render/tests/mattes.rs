// SPDX-License-Identifier: GPL-3.0-or-later
//! Cryptomatte: coverage against the opacity of pictures of one thing alone, and against closed forms.

use std::collections::BTreeMap;

use crate::common::*;
use gnurt_image::{ChannelData, Picture};
use gnurt_render::{
    Accumulation, Integrator, MatteKind, Mattes, ReconstructionFilter, RenderOptions, SceneCamera, Silent,
    matte_id, matte_names, render,
};
use gnurt_scene::material::{Alpha, Opacity, OpacityChannel};
use gnurt_scene::{Affine, Camera, Lens, Material, MaterialId, Mesh, Scene};

fn put_named(scene: &mut Scene, name: &str, asset: &str, mesh: Mesh) {
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of(asset, vec![mesh]);
    let id = scene.instantiate(object, Affine::IDENTITY);
    scene.edit_instance(id).name = name.into();
}

/// A floor, a ball and another one in front of it; `only` one of them.
fn scene(only: Option<&str>) -> Scene {
    let mut scene = Scene::new();
    let [grey, red] = [("grey", [0.5; 3]), ("red", [0.8, 0.1, 0.1])]
        .map(|(name, color)| scene.add_material(Material::matte(name, color)));
    let things: [(&str, &str, Mesh); 3] = [
        ("floor", "set", quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], grey)),
        ("far", "ball", sphere([0.0, 1.0, 0.8], 0.8, 16, grey)),
        ("near", "ball", sphere([0.5, -1.0, 0.5], 0.5, 16, red)),
    ];
    for (name, asset, mesh) in things {
        if only.is_none_or(|only| only == name) {
            put_named(&mut scene, name, asset, mesh);
        }
    }
    scene.add_light(environment([1.0; 3]));
    scene
}

fn view(aperture: f32) -> SceneCamera {
    let lens = Lens { aperture, ..Lens::default() };
    let camera = Camera {
        name: String::new(),
        eye: [0.0, -5.0, 3.0],
        target: [0.0, 0.0, 0.5],
        up: [0.0, 0.0, 1.0],
        fov_y: 35.0,
        lens,
        ..Camera::default()
    };
    SceneCamera::new(&camera).expect("a view")
}

fn all(depth: u32) -> Mattes {
    Mattes { kinds: MatteKind::ALL.to_vec(), depth }
}

fn with(mattes: Mattes, spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, aovs: true, mattes, ..options(48, 32, spp) }
}

/// Id and coverage of all ranks of a pixel.
fn ranks(picture: &Picture, kind: MatteKind, i: usize) -> Vec<(u32, f32)> {
    let mut found = Vec::new();
    for layer in picture.layers.iter().filter(|layer| layer.name.starts_with(kind.layer())) {
        let value = |name: &str| match &layer.channel(name).expect("four channels").data {
            ChannelData::F32(values) => values[i],
            ChannelData::U32(_) => panic!("floats"),
        };
        found.push((value("R").to_bits(), value("G")));
        found.push((value("B").to_bits(), value("A")));
    }
    found
}

fn coverage(picture: &Picture, kind: MatteKind, name: &str) -> Vec<f32> {
    let id = matte_id(name);
    let of = |i: usize| {
        ranks(picture, kind, i).iter().filter(|(found, _)| *found == id).map(|(_, share)| share).sum()
    };
    (0..picture.pixel_count()).map(of).collect()
}

#[test]
fn a_matte_is_the_opacity_of_the_thing_alone() {
    for filter in [ReconstructionFilter::Box, ReconstructionFilter::BlackmanHarris] {
        for aperture in [0.0, 0.4] {
            let options = RenderOptions { filter, ..with(all(6), 16) };
            let picture = |scene: &Scene| {
                let world = world_of(scene, false);
                render(&world, &view(aperture), &options, &pool(1), &Silent).expect("sound").picture
            };
            let whole = picture(&scene(None));
            let near = coverage(&whole, MatteKind::Object, "near");
            let alone = picture(&scene(Some("near")));
            for (i, (share, pixel)) in near.iter().zip(&alone.color).enumerate() {
                assert!((share - pixel[3]).abs() < 1e-6, "{filter}, {aperture}, {i}: {share} of {pixel:?}");
            }
            assert_eq!(near, coverage(&whole, MatteKind::Material, "red"), "the only red thing");
            let [far, ball] = [(MatteKind::Object, "far"), (MatteKind::Asset, "ball")]
                .map(|(kind, name)| coverage(&whole, kind, name));
            for i in 0..whole.pixel_count() {
                assert!((near[i] + far[i] - ball[i]).abs() < 1e-6, "both balls are one asset");
                let ranked = ranks(&whole, MatteKind::Object, i);
                assert!(ranked.is_sorted_by(|a, b| a.1 >= b.1), "the largest first: {ranked:?}");
                let sum: f32 = ranked.iter().map(|(_, share)| share).sum();
                assert!((sum - whole.color[i][3]).abs() < 1e-6, "the rest is background: {ranked:?}");
            }
            assert!(near.iter().any(|&x| x > 0.0 && x < 1.0), "edges are soft");
        }
    }
}

#[test]
fn what_is_there_in_part_covers_in_part() {
    let mut scene = Scene::new();
    let glass = |scene: &mut Scene, name: &str, factor: f32| -> MaterialId {
        let opacity = Opacity { factor, texture: None, channel: OpacityChannel::Alpha };
        scene.add_material(Material { alpha: Alpha::Blend { opacity }, ..Material::matte(name, [0.5; 3]) })
    };
    for (i, (name, factor)) in [("first", 0.4), ("second", 0.5), ("wall", 1.0)].into_iter().enumerate() {
        let material = glass(&mut scene, name, factor);
        let y = i as f32;
        put_named(&mut scene, name, "", quad([-9.0, y, -9.0], [18.0, 0.0, 0.0], [0.0, 0.0, 18.0], material));
    }
    scene.add_light(environment([1.0; 3]));
    let view = camera([0.0, -3.0, 0.0], [0.0, 0.0, 0.0], 20.0);
    for integrator in [Integrator::Path, Integrator::Whitted, Integrator::InstantRadiosity] {
        let options = RenderOptions { integrator, ..with(all(6), 3) };
        let world = world_of(&scene, false);
        let picture = render(&world, &view, &options, &pool(1), &Silent).expect("sound").picture;
        let mut ranked = ranks(&picture, MatteKind::Material, 700);
        ranked.truncate(3);
        let found: BTreeMap<u32, f32> = ranked.into_iter().collect();
        for (name, share) in [("first", 0.4), ("second", 0.3), ("wall", 0.3)] {
            assert!((found[&matte_id(name)] - share).abs() < 1e-6, "{integrator}: {name}: {found:?}");
        }
    }
}

#[test]
fn mattes_change_nothing_and_have_the_same_bits_however_they_are_made() {
    let world = world_of(&scene(None), false);
    let camera = view(0.2);
    let options = with(all(3), 6);
    let whole = render(&world, &camera, &options, &pool(1), &Silent).expect("sound").picture;
    let plain =
        render(&world, &camera, &with(Mattes::default(), 6), &pool(1), &Silent).expect("sound").picture;
    assert!(whole.color == plain.color, "the picture stays");
    let crypto = whole.layers.iter().filter(|layer| layer.name.starts_with("Crypto")).count();
    assert_eq!(crypto, 6, "two layers of two ranks for each of three kinds");
    let mut begun = Accumulation::new(options.clone()).expect("sound");
    begun.pass(&world, &camera, 2, &pool(1), &Silent);
    let mut resumed = Accumulation::from_bytes(options.clone(), 7, &begun.to_bytes(7)).expect("its own");
    while !resumed.is_complete() {
        resumed.pass(&world, &camera, 1, &pool(1), &Silent);
    }
    let bits = |picture: &Picture| {
        let of_pixel = |i: usize| MatteKind::ALL.map(|kind| ranks(picture, kind, i));
        (0..picture.pixel_count()).map(of_pixel).collect::<Vec<_>>()
    };
    assert!(bits(&resumed.picture()) == bits(&whole), "from a checkpoint");
}

#[test]
fn names_are_found_by_their_ids() {
    let scene = scene(None);
    let ids = ["near", "red", "instance 0"].map(matte_id).into();
    let of = |kind| matte_names(&scene, kind, &ids).into_keys().collect::<Vec<_>>();
    assert_eq!((of(MatteKind::Object), of(MatteKind::Material)), (vec!["near".into()], vec!["red".into()]));
    assert!(of(MatteKind::Asset).is_empty(), "not in the picture");
}
