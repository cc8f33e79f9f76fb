// SPDX-License-Identifier: GPL-3.0-or-later
//! Light linking and shadow linking: against pictures without the light, without the thing, and with links to everything.

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Integrator, LightLayer, RenderOptions, SceneCamera, Silent, render};
use gnurt_scene::labels::{LightLinks, Shining};
use gnurt_scene::material::{Color, Principled};
use gnurt_scene::medium::{Extent, Medium};
use gnurt_scene::{Affine, InstanceId, Light, LightId, Material, Mesh, Scene, Surface};
use gnurt_simd::Level;

const FLOOR: InstanceId = InstanceId(0);
const LEFT: InstanceId = InstanceId(1);
const RIGHT: InstanceId = InstanceId(2);

/// The light of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Point,
    Lamp,
    Sky,
}

fn put(scene: &mut Scene, mesh: Mesh, is_there: bool) {
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of("", vec![mesh]);
    let id = scene.instantiate(object, Affine::IDENTITY);
    scene.edit_instance(id).visible = is_there;
}

/// A glossy floor and two balls under one light; the right ball may be away.
fn scene(kind: Kind, with_right: bool) -> (Scene, Shining) {
    let mut scene = Scene::new();
    let plastic = Principled {
        base_color: Color::constant([0.6; 3]),
        metallic: 0.0,
        roughness: 0.25,
        ..Principled::default()
    };
    let floor = scene.add_material(Material::of("floor", Surface::Principled(Box::new(plastic))));
    let red = matte(&mut scene, [0.8, 0.3, 0.2]);
    put(&mut scene, quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], floor), true);
    put(&mut scene, sphere([-1.0, 0.0, 0.7], 0.7, 12, red), true);
    put(&mut scene, sphere([1.0, 0.0, 0.7], 0.7, 12, red), with_right);
    let shining = match kind {
        Kind::Point => {
            let light = Light::Point { position: [0.0, -1.0, 4.0], intensity: [12.0; 3], radius: 0.0 };
            Shining::Light(scene.add_light(light))
        }
        Kind::Sky => Shining::Light(scene.add_light(environment([0.7, 0.8, 1.0]))),
        Kind::Lamp => {
            let lamp = emitter(&mut scene, [6.0, 5.0, 4.0]);
            put(&mut scene, quad([-1.0, -2.0, 4.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], lamp), true);
            Shining::Material(lamp)
        }
    };
    (scene, shining)
}

fn link(
    mut scene: Scene,
    shining: Shining,
    lit: Option<&[InstanceId]>,
    shadows: Option<&[InstanceId]>,
) -> Scene {
    let links = LightLinks { lit: lit.map(<[_]>::to_vec), shadows: shadows.map(<[_]>::to_vec) };
    scene.labels_mut().light_links.insert(shining, links);
    scene
}

fn view() -> SceneCamera {
    camera([0.0, -6.0, 3.5], [0.0, 0.0, 0.4], 35.0)
}

fn seen(scene: &Scene, options: &RenderOptions) -> Picture {
    let options = RenderOptions { aovs: true, ..options.clone() };
    render(&world_of(scene, false), &view(), &options, &pool(1), &Silent).expect("sound").picture
}

fn path(spp: u32, max_depth: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth, ..options(40, 30, spp) }
}

/// Pixels whose samples all hit one instance.
fn pixels_of(scene: &Scene, only: InstanceId) -> Vec<usize> {
    let mattes = gnurt_render::Mattes { kinds: vec![gnurt_render::MatteKind::Object], depth: 2 };
    let picture = seen(scene, &RenderOptions { mattes, ..path(8, 1) });
    let layer = picture.layer("CryptoObject00").expect("mattes");
    let values = |name: &str| match &layer.channel(name).expect("a channel").data {
        gnurt_image::ChannelData::F32(values) => values.clone(),
        gnurt_image::ChannelData::U32(_) => panic!("floats"),
    };
    let id = gnurt_render::matte_id(&format!("instance {}", only.0));
    let (ids, shares) = (values("R"), values("G"));
    (0..ids.len()).filter(|&i| ids[i].to_bits() == id && shares[i] > 0.999).collect()
}

fn sum(picture: &Picture, pixels: &[usize]) -> f64 {
    pixels.iter().map(|&i| picture.color[i][..3].iter().map(|&x| f64::from(x)).sum::<f64>()).sum()
}

#[test]
fn a_light_reaches_the_linked_instances_only() {
    for kind in [Kind::Point, Kind::Lamp, Kind::Sky] {
        let (plain, shining) = scene(kind, true);
        let linked = link(plain.clone(), shining, Some(&[FLOOR, LEFT]), None);
        let [all, some] = [&plain, &linked].map(|scene| seen(scene, &path(8, 2)));
        for lit in [FLOOR, LEFT] {
            for i in pixels_of(&plain, lit) {
                assert_eq!(all.color[i], some.color[i], "{kind:?}: pixel {i} of {lit:?} is as before");
            }
        }
        let dark = pixels_of(&plain, RIGHT);
        assert!(dark.len() > 20, "the ball is seen");
        assert!(dark.iter().all(|&i| some.color[i][..3] == [0.0; 3]), "{kind:?}: the right ball is dark");
        // Its light is still reflected by the others.
        let (all, some) = (seen(&plain, &path(64, 6)), seen(&linked, &path(64, 6)));
        let floor = pixels_of(&plain, FLOOR);
        assert!(sum(&some, &floor) < sum(&all, &floor), "{kind:?}: less light comes from the ball");
        assert!(sum(&some, &dark) > 0.0, "{kind:?}: the ball is lit by the floor");
    }
}

#[test]
fn only_linked_instances_cast_shadows() {
    for (kind, tolerance) in [(Kind::Point, 1e-6), (Kind::Lamp, 0.03), (Kind::Sky, 0.03)] {
        let (plain, shining) = scene(kind, true);
        let linked = link(plain.clone(), shining, None, Some(&[FLOOR, LEFT]));
        let alone = scene(kind, false).0;
        let floor = pixels_of(&plain, FLOOR);
        let spp = if kind == Kind::Point { 8 } else { 256 };
        let [with, without] = [&linked, &alone].map(|scene| sum(&seen(scene, &path(spp, 2)), &floor));
        let shadowed = sum(&seen(&plain, &path(spp, 2)), &floor);
        assert_close(with, without, tolerance, &format!("{kind:?}: as without the ball"));
        assert!(shadowed < 0.99 * with, "{kind:?}: it would cast a shadow: {shadowed} and {with}");
    }
}

/// Lights with shadows of their own are left to light samples; the picture's mean stays.
#[test]
fn links_to_everything_change_nothing_on_average() {
    for kind in [Kind::Point, Kind::Lamp, Kind::Sky] {
        for with_fog in [false, true] {
            let (mut plain, shining) = scene(kind, true);
            if with_fog {
                let extent = Extent::Around { centre: [0.0; 3], radius: 5.0 };
                plain.add_medium(Medium { scattering: [0.1; 3], extent, ..Medium::default() });
            }
            let everything: Vec<InstanceId> = (0..plain.instances().len() as u32).map(InstanceId).collect();
            let linked = link(plain.clone(), shining, Some(&everything), Some(&everything));
            let all: Vec<usize> = (0..1200).collect();
            let [a, b] = [&plain, &linked].map(|scene| sum(&seen(scene, &path(128, 5)), &all));
            assert_close(b, a, 0.02, &format!("{kind:?}, fog {with_fog}"));
        }
    }
}

#[test]
fn links_have_the_same_bits_however_they_are_followed() {
    let (mut plain, shining) = scene(Kind::Lamp, true);
    plain.add_light(Light::Point { position: [2.0, -2.0, 3.0], intensity: [4.0; 3], radius: 0.0 });
    let mut linked = link(plain, shining, Some(&[FLOOR, LEFT]), Some(&[LEFT]));
    let links = LightLinks { lit: Some(vec![RIGHT]), shadows: None };
    linked.labels_mut().light_links.insert(Shining::Light(LightId(0)), links);
    let layers = ["direct", "indirect", "emission"].map(|word| LightLayer::of_word(word).expect("a word"));
    let options = RenderOptions { light_layers: layers.to_vec(), ..path(6, 6) };
    let lanes = seen(&linked, &options);
    let single = seen(&linked, &RenderOptions { level: Level::Scalar, ..options });
    assert!(lanes == single, "one by one");
    let plane = |name: &str, c: &str, i: usize| match &lanes
        .layer(name)
        .and_then(|l| l.channel(c))
        .expect("light")
        .data
    {
        gnurt_image::ChannelData::F32(values) => values[i],
        gnurt_image::ChannelData::U32(_) => panic!("light"),
    };
    for (i, pixel) in lanes.color.iter().enumerate() {
        let sum: f32 = ["direct", "indirect", "emission"].iter().map(|name| plane(name, "R", i)).sum();
        assert!(
            (sum - pixel[0]).abs() < 1e-5 * pixel[0].max(1.0),
            "layers make the picture: {sum}, {pixel:?}"
        );
    }
}
