// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures of a camera in motion that remember the light of those before: beside pictures that are rendered from there alone.

use std::sync::Arc;

use crate::common::pool;
use gnurt_image::srgb::luminance;
use gnurt_render::{
    Accumulation, CommitOptions, Integrator, MotionShare, PictureHistory, RenderOptions, SceneCamera,
    ShaderTable, Silent, World, render,
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

    /// The picture of a step: all pixels are traced, and a share of them gets fresh samples.
    fn view(&mut self, options: &RenderOptions, step: u32, fresh: f32) -> Vec<[f32; 4]> {
        self.view_of(options, step, MotionShare { fresh, stride: 1 })
    }

    fn view_of(&mut self, options: &RenderOptions, step: u32, share: MotionShare) -> Vec<[f32; 4]> {
        let rays = SceneCamera::new(&camera(&self.scene, step)).expect("a view");
        let rays: Arc<dyn CameraShader> = Arc::new(rays);
        assert!(PictureHistory::suits(&self.world, &*rays, options), "it remembers");
        let mut measured = Accumulation::new(options.clone()).expect("sound options");
        let whole =
            measured.pass_remembering(&mut self.history, share, &self.world, &rays, &self.pool, &Silent);
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

/// Means of 16 by 12 blocks.
fn blocks(colors: &[[f32; 4]]) -> Vec<f32> {
    // Pictures are SIZE, or a multiple.
    let side = 4 * (colors.len() as u32 / (SIZE[0] * SIZE[1])).isqrt() as usize;
    let [width, height] = [16 * side, 12 * side];
    let mean = |left: usize, top: usize| {
        let pixels = (top..top + side).flat_map(|y| (left..left + side).map(move |x| colors[y * width + x]));
        pixels.map(|[r, g, b, _]| luminance([r, g, b])).sum::<f32>() / (side * side) as f32
    };
    (0..height)
        .step_by(side)
        .flat_map(|y| (0..width).step_by(side).map(move |x| [x, y]))
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
    // As many pixels are traced in both cases.
    for stride in [1, 2] {
        let share = MotionShare { fresh: 0.125, stride };
        let [width, height] = SIZE.map(|side| side * stride);
        let last = 30;
        let by = |integrator| RenderOptions { width, height, ..options(integrator) };
        let expected = Moving::new(2).rendered(&by(Integrator::Path), last);
        for integrator in
            [Integrator::Path, Integrator::BidirectionalInstantRadiosity, Integrator::InstantRadiosity]
        {
            let mut moving = Moving::new(2);
            let found = (0..=last).map(|step| moving.view_of(&by(integrator), step, share)).last();
            let [mean, off] = errors(&found.expect("pictures"), &expected);
            eprintln!("{integrator}, {share:?}: mean {mean}, blocks off by {off}");
            assert!((mean - 1.0).abs() < 0.03 && off < 0.12, "{integrator}, {share:?}: {mean}, {off}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads() {
    for integrator in [Integrator::Path, Integrator::BidirectionalInstantRadiosity] {
        let [one, three] = [1, 3].map(|threads| {
            let mut moving = Moving::new(threads);
            let share = |step: u32| MotionShare { fresh: 0.1, stride: 1 + u32::from(step > 1) };
            let view = |step| moving.view_of(&options(integrator), step, share(step));
            (0..6).map(view).collect::<Vec<_>>()
        });
        assert!(one == three, "{integrator}");
    }
}

/// Surfaces stand where they are traced in all pixels, at rest exactly, from the first picture on; in motion up
/// to single pixels at edges.
#[test]
fn pixels_between_traced_ones_show_the_same_surfaces() {
    let options = RenderOptions { max_depth: 1, ..options(Integrator::Path) };
    let [every, fourth] = [1, 2].map(|stride| MotionShare { fresh: 1.0, stride });
    for (steps, most) in [(&[0][..], 0.0), (&[0; 6], 0.0), (&[0, 1, 2, 3, 4, 5], 0.01)] {
        let [every, fourth] = [every, fourth].map(|share| {
            let mut moving = Moving::new(2);
            steps.iter().map(|&step| moving.view_of(&options, step, share)).last().expect("pictures")
        });
        // Without bounces only lamps show: their edges tell surfaces apart.
        let lit = |colors: &[[f32; 4]]| colors.iter().map(|c| c[0] > 1.0).collect::<Vec<_>>();
        let (every, fourth) = (lit(&every), lit(&fourth));
        let off = every.iter().zip(&fourth).filter(|(a, b)| a != b).count();
        let share = off as f32 / every.len() as f32;
        assert!(every.contains(&true) && share <= most, "steps {steps:?}: {off} pixels differ");
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
