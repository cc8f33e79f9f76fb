// SPDX-License-Identifier: GPL-3.0-or-later
//! The built-in denoiser on rendered pictures: the error against many samples must fall clearly, and directly
//! visible light stays separate.

use gnurt::denoise::{Method, Options, denoise};
use gnurt::image::{ChannelData, Picture, compare};
use gnurt::render::{
    CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};

/// A room with lamps of its own or by default, `spp` samples per pixel.
fn render_scene(name: &str, spp: u32, pool: &gnurt::ThreadPool) -> Picture {
    room_to_depth(name, spp, 5, pool)
}

/// The same with paths of at most so many edges.
fn room_to_depth(name: &str, spp: u32, max_depth: u32, pool: &gnurt::ThreadPool) -> Picture {
    let mut scene = gnurt::load_scene(name).expect("a built-in scene").scene;
    gnurt::defaults::complete(&mut scene, 1.0);
    let mut world = World::new();
    world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), pool).expect("a sound scene");
    let camera = SceneCamera::new(&scene.cameras()[0]).expect("a view");
    let options = RenderOptions {
        width: 64,
        height: 64,
        spp,
        seed: u64::from(spp),
        integrator: Integrator::Path,
        max_depth,
        aovs: true,
        ..RenderOptions::default()
    };
    render(&world, &camera, &options, pool, &Silent).expect("sound options").picture
}

#[test]
fn denoised_pictures_are_nearer_to_the_truth() {
    let pool = gnurt::thread_pool(2).expect("threads");
    let mut truth = render_scene("builtin:cornell", 512, &pool);
    truth.layers.clear();
    let noisy = render_scene("builtin:cornell", 8, &pool);
    let error = |picture: &Picture| compare(picture, &truth).expect("equal sizes").rel_mse;
    let mut clean = noisy.clone();
    let options = Options { method: Method::BuiltIn, ..Options::default() };
    denoise(&mut clean, &options, &pool).expect("the layers are there");
    let (before, after) = (error(&noisy), error(&clean));
    eprintln!("relMSE {before} became {after}");
    // Half of the remaining error is in pixels on the light's edge: eight samples do not determine its
    // coverage.
    assert!(after < before / 3.5, "relMSE {before} became {after}");
    let mean = |picture: &Picture| picture.color.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>();
    let shift = mean(&clean) / mean(&noisy) - 1.0;
    assert!(shift.abs() < 0.01, "the mean moves by {shift}");
}

#[test]
fn emission_is_what_paths_of_one_edge_bring() {
    let pool = gnurt::thread_pool(2).expect("threads");
    for name in ["builtin:cornell", "builtin:spheres"] {
        let whole = room_to_depth(name, 4, 5, &pool);
        let mut direct = room_to_depth(name, 4, 1, &pool);
        let emission = whole.layer("unscattered").expect("path tells");
        for (k, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let ChannelData::F32(values) = &emission.channel(channel).expect("three colours").data else {
                panic!("floats")
            };
            for (i, (found, expected)) in values.iter().zip(&direct.color).enumerate() {
                assert_eq!(*found, expected[k], "{name}: pixel {i}");
            }
        }
        direct.color.retain(|pixel| pixel[0] > 0.0);
        assert!(!direct.color.is_empty(), "{name}: something shines");
    }
}
