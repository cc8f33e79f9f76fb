// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures of a camera in motion that remember the light of those before: beside pictures that are rendered from there alone.

use std::sync::Arc;

use crate::common::pool;
use gnurt_image::srgb::luminance;
use gnurt_render::{
    Accumulation, CommitOptions, Integrator, PictureHistory, RenderOptions, SceneCamera, ShaderTable, Silent,
    World, render,
};
use gnurt_scene::{Camera, InstanceId, Scene};
use gnurt_shading::CameraShader;

const SIZE: [u32; 2] = [64, 48];

fn options(integrator: Integrator) -> RenderOptions {
    let [width, height] = SIZE;
    RenderOptions {
        width,
        height,
        integrator,
        vpls: 128,
        spp: 1,
        pixel_centres: true,
        ..RenderOptions::default()
    }
}

/// Around the box by steps.
fn camera(scene: &Scene, step: u32) -> Camera {
    let mut camera = scene.cameras()[0].clone();
    let aside = 0.012 * step as f32;
    let reach = (0..3).map(|k| (camera.target[k] - camera.eye[k]).powi(2)).sum::<f32>().sqrt();
    camera.eye[0] += aside * reach;
    camera
}

struct Moving {
    scene: Scene,
    world: World,
    history: PictureHistory,
    pool: rayon::ThreadPool,
}

impl Moving {
    fn new(threads: usize) -> Self {
        let scene = gnurt_scene::builtin::load("cornell").expect("it is built in");
        let mut moving =
            Self { scene, world: World::new(), history: PictureHistory::default(), pool: pool(threads) };
        moving.commit();
        moving
    }

    fn commit(&mut self) {
        let how = CommitOptions::default();
        self.world.commit(&self.scene, &ShaderTable::default(), &how, &self.pool).expect("a sound scene");
    }

    /// The picture of a step, with fresh samples for a share of the pixels.
    fn view(&mut self, options: &RenderOptions, step: u32, fresh: f32) -> Vec<[f32; 4]> {
        let rays = SceneCamera::new(&camera(&self.scene, step)).expect("a view");
        let rays: Arc<dyn CameraShader> = Arc::new(rays);
        assert!(PictureHistory::suits(&self.world, &*rays, options), "it remembers");
        let mut measured = Accumulation::new(options.clone()).expect("sound options");
        let whole =
            measured.pass_remembering(&mut self.history, fresh, &self.world, &rays, &self.pool, &Silent);
        assert!(whole && measured.is_complete(), "nobody stops it");
        measured.picture().color
    }

    /// The reference picture.
    fn rendered(&self, options: &RenderOptions, step: u32) -> Vec<[f32; 4]> {
        let rays = SceneCamera::new(&camera(&self.scene, step)).expect("a view");
        let options = RenderOptions { spp: 96, integrator: Integrator::Path, ..options.clone() };
        render(&self.world, &rays, &options, &self.pool, &Silent).expect("sound options").picture.color
    }
}

/// Means of blocks of 4 x 4 pixels.
fn blocks(colors: &[[f32; 4]]) -> Vec<f32> {
    let [width, height] = SIZE.map(|x| x as usize);
    let mean = |left: usize, top: usize| {
        let pixels = (top..top + 4).flat_map(|y| (left..left + 4).map(move |x| colors[y * width + x]));
        pixels.map(|[r, g, b, _]| luminance([r, g, b])).sum::<f32>() / 16.0
    };
    (0..height)
        .step_by(4)
        .flat_map(|y| (0..width).step_by(4).map(move |x| [x, y]))
        .map(|[x, y]| mean(x, y))
        .collect()
}

/// The mean, and the mean error of blocks, both relative to the reference; lights count as white.
fn errors(found: &[[f32; 4]], expected: &[[f32; 4]]) -> [f32; 2] {
    let [found, expected] =
        [found, expected].map(|colors| blocks(colors).into_iter().map(|x| x.min(1.0)).collect::<Vec<f32>>());
    let sum = |values: &[f32]| values.iter().sum::<f32>();
    let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).sum::<f32>();
    [sum(&found) / sum(&expected), off / sum(&expected)]
}

#[test]
fn remembered_light_is_that_of_fresh_pictures() {
    for integrator in
        [Integrator::Path, Integrator::BidirectionalInstantRadiosity, Integrator::InstantRadiosity]
    {
        let mut moving = Moving::new(2);
        let options = options(integrator);
        let last = 30;
        let found = (0..=last).map(|step| moving.view(&options, step, 1.0 / 8.0)).last().expect("pictures");
        let [mean, off] = errors(&found, &moving.rendered(&options, last));
        eprintln!("{integrator}: mean {mean}, blocks off by {off}");
        assert!((mean - 1.0).abs() < 0.03 && off < 0.12, "{integrator}: mean {mean}, blocks off by {off}");
    }
}

#[test]
fn pictures_do_not_depend_on_threads() {
    for integrator in [Integrator::Path, Integrator::BidirectionalInstantRadiosity] {
        let [one, three] = [1, 3].map(|threads| {
            let mut moving = Moving::new(threads);
            (0..4).map(|step| moving.view(&options(integrator), step, 0.1)).collect::<Vec<_>>()
        });
        assert!(one == three, "{integrator}");
    }
}

/// A block of the box goes away: where it was the wall is seen, as in a fresh picture, and its shadow goes.
#[test]
fn what_moves_takes_its_light_along() {
    let options = options(Integrator::Path);
    let mut moving = Moving::new(2);
    (0..12).for_each(|_| drop(moving.view(&options, 0, 0.25)));
    let last = InstanceId(moving.scene.instances().len() as u32 - 1);
    let with = moving.rendered(&options, 0);
    moving.scene.edit_instance(last).visible = false;
    moving.commit();
    let found = (0..10).map(|_| moving.view(&options, 0, 0.25)).last().expect("pictures");
    let expected = moving.rendered(&options, 0);
    let [mean, off] = errors(&found, &expected);
    assert!((mean - 1.0).abs() < 0.05 && off < 0.14, "mean {mean}, blocks off by {off}");
    // Little of the changed light remains.
    let [with, found, expected] = [with, found, expected].map(|colors| blocks(&colors));
    let changed = |&i: &usize| (with[i] - expected[i]).abs() > 0.3 * expected[i];
    let far = |from: &[f32]| {
        (0..expected.len()).filter(changed).map(|i| (from[i] - expected[i]).abs()).sum::<f32>()
    };
    eprintln!(
        "{} blocks have changed: {} before, {} now",
        (0..expected.len()).filter(changed).count(),
        far(&with),
        far(&found)
    );
    assert!((0..expected.len()).filter(changed).count() > 9, "it is seen that it goes");
    assert!(far(&found) < 0.35 * far(&with), "{} of {} are left", far(&found), far(&with));
}

#[test]
fn cheap_pictures_remember_nothing() {
    let moving = Moving::new(1);
    let rays = SceneCamera::new(&camera(&moving.scene, 0)).expect("a view");
    for integrator in [Integrator::Eyelight, Integrator::Normals, Integrator::Whitted] {
        assert!(!PictureHistory::suits(&moving.world, &rays, &options(integrator)), "{integrator}");
    }
}
