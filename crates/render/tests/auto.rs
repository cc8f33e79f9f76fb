// SPDX-License-Identifier: GPL-3.0-or-later
//! The integrator that a pilot chooses: the bytes are those of the chosen one however a picture is divided, and there is no
//! pilot where virtual lights would leave something out.

use crate::common::*;
use gnurt_render::{
    Accumulation, Frame, Guiding, Integrator, LightLayer, RenderOptions, SceneCamera, Silent, World, render,
};
use gnurt_scene::detail::Subsurface;
use gnurt_scene::material::{Color, Principled};
use gnurt_scene::medium::Medium;
use gnurt_scene::{Material, Scene, Surface};

fn auto(width: u32, height: u32, spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Auto, max_depth: 8, ..options(width, height, spp) }
}

/// What `auto` renders, if it chooses this one.
fn as_chosen(auto: &RenderOptions, integrator: Integrator) -> RenderOptions {
    RenderOptions { integrator, vpls: 32, guiding: Guiding::Auto, ..auto.clone() }
}

fn frame_of(of: &(World, SceneCamera), options: &RenderOptions) -> Frame {
    render(&of.0, &of.1, options, &pool(2), &Silent).expect("sound options")
}

/// A white room with a lamp that shines at the ceiling from above a shelf: all light was scattered.
fn shelf() -> (World, SceneCamera) {
    let (scene, view) = shelf_scene();
    (world_of(&scene, false), view)
}

fn shelf_scene() -> (Scene, SceneCamera) {
    let mut scene = Scene::new();
    let grey = matte(&mut scene, [0.7, 0.6, 0.5]);
    room(&mut scene, grey);
    put_mesh(&mut scene, quad([-1.0, -1.0, 2.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], grey));
    let lamp = emitter(&mut scene, [40.0, 36.0, 30.0]);
    put_mesh(&mut scene, quad([-0.05, -0.05, 2.2], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], lamp));
    (scene, camera([-2.9, -1.6, 1.6], [0.0, 0.4, 1.0], 70.0))
}

/// A floor under a sky: light samples find all of its light.
fn open() -> Scene {
    let mut scene = floor(0.5, 5.0);
    scene.add_light(environment([0.2, 0.3, 0.5]));
    scene
}

fn seen(scene: &Scene) -> (World, SceneCamera) {
    (world_of(scene, false), camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0))
}

#[test]
fn each_is_chosen_where_it_has_less_noise() {
    for (of, integrator) in
        [(shelf(), Integrator::BidirectionalInstantRadiosity), (seen(&open()), Integrator::Path)]
    {
        let options = auto(40, 30, 2);
        let frame = frame_of(&of, &options);
        let choice = frame.stats.choice.expect("it was asked for");
        assert_eq!(choice.integrator, integrator, "{choice}");
        assert_eq!(choice.virtual_lights, 32, "enough in a small room: {choice}");
        let alone = frame_of(&of, &as_chosen(&options, integrator));
        assert!(bits(&frame.picture) == bits(&alone.picture), "the bits of {integrator} alone");
        assert!(alone.stats.choice.is_none(), "nothing was to choose");
        assert!(frame.stats.rays() > alone.stats.rays(), "rays of the pilot are counted");
        assert_eq!(frame.stats.samples, alone.stats.samples, "its samples are not");
        let [paths, lights] = choice.methods.expect("there was a pilot");
        assert_eq!(lights.product() < paths.product(), integrator != Integrator::Path, "{choice}");
        assert!((paths.mean - lights.mean).abs() < 0.05, "both have the same mean: {choice}");
    }
}

/// Threads, levels, pieces, crops, passes and checkpoints.
#[test]
fn divided_pictures_have_the_same_bytes() {
    let of = shelf();
    let options = auto(24, 36, 3);
    let whole = picture_of(&of, &options, 1);
    let paths = picture_of(&of, &as_chosen(&options, Integrator::Path), 2);
    assert!(bits(&whole) != bits(&paths), "virtual lights were chosen");
    same_bytes_divided(&of, &options, &whole, &paths);
    let crop = RenderOptions { crop: Some([5, 10, 20, 30]), ..options.clone() };
    let frame = frame_of(&of, &crop);
    assert_eq!(
        frame.stats.choice.map(|choice| choice.methods),
        frame_of(&of, &options).stats.choice.map(|choice| choice.methods),
        "the pilot sees the whole picture"
    );
    let alone = as_chosen(&crop, Integrator::BidirectionalInstantRadiosity);
    assert!(bits(&frame.picture) == bits(&picture_of(&of, &alone, 2)), "a crop");
    let mut passes = Accumulation::new(options).expect("sound");
    for samples in [1, 2] {
        passes.pass(&of.0, &of.1, samples, &pool(3), &Silent);
    }
    assert!(passes.is_complete() && bits(&whole) == bits(&passes.picture()), "in two passes");
}

#[test]
fn paths_are_guided_where_it_pays() {
    let of = seen(&open());
    let options = auto(24, 18, 70);
    let frame = frame_of(&of, &options);
    assert!(frame.stats.guide.is_some(), "the guide was asked");
    let alone = frame_of(&of, &as_chosen(&options, Integrator::Path));
    assert!(bits(&frame.picture) == bits(&alone.picture), "as with paths");
}

/// Virtual lights have no noise target, no layers by events and no media.
#[test]
fn no_pilot_where_something_would_be_left_out() {
    let of = shelf();
    let layer = LightLayer::new("events", "C<RD>L").expect("an expression");
    let plain = auto(24, 18, 16);
    for options in [
        RenderOptions { noise: Some(0.5), ..plain.clone() },
        RenderOptions { light_layers: vec![layer], ..plain.clone() },
    ] {
        let choice = frame_of(&of, &options).stats.choice.expect("it was asked for");
        assert_eq!((choice.integrator, choice.methods), (Integrator::Path, None), "{choice}");
    }
    let mut foggy = open();
    foggy.add_medium(Medium { scattering: [0.1; 3], ..Medium::default() });
    let choice = frame_of(&seen(&foggy), &plain).stats.choice.expect("it was asked for");
    assert_eq!((choice.integrator, choice.methods), (Integrator::Path, None), "{choice}");
    let with_pilot = frame_of(&of, &plain).stats.choice.expect("it was asked for");
    assert!(with_pilot.methods.is_some(), "but for these");
}

/// Virtual lights show light below surfaces as diffuse: a pilot of paths that meets some decides.
#[test]
fn light_below_surfaces_is_left_to_paths() {
    let (mut scene, view) = shelf_scene();
    let subsurface = Subsurface { factor: 1.0, radius: [0.3, 0.2, 0.1], anisotropy: 0.0 };
    let skin = Principled {
        base_color: Color::constant([0.8, 0.5, 0.4]),
        metallic: 0.0,
        subsurface,
        ..Principled::default()
    };
    let skin = scene.add_material(Material::of("", Surface::Principled(Box::new(skin))));
    put_mesh(&mut scene, sphere([0.0, 0.4, 0.5], 0.5, 12, skin));
    let choice = frame_of(&(world_of(&scene, false), view), &auto(40, 30, 2)).stats.choice;
    let choice = choice.expect("it was asked for");
    assert_eq!((choice.integrator, choice.methods), (Integrator::Path, None), "{choice}");
}
