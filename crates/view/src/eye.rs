// SPDX-License-Identifier: GPL-3.0-or-later
//! A progressive picture for display: samples, then displayed colours. Memory is reused from picture to
//! picture. Tests: `tests`.

use std::sync::Arc;

use gnurt::ThreadPool;
use gnurt::camera_rays;
use gnurt::denoise;
use gnurt::image::{WorkingSpace, convert_from};
use gnurt::osl::CameraScript;
use gnurt::render::{Accumulation, MotionCost, MotionShare, PictureHistory, Progress, RenderOptions, World};
use gnurt::scene::Camera;
use gnurt::shading::CameraShader;

use crate::error::ViewError;
use crate::exposure::Exposure;
use crate::screen::{self, Part};
use crate::shown::Shown;
use crate::temporal_filter::TemporalFilter;

/// The content and the camera of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ViewRequest {
    pub(crate) camera: Camera,
    pub(crate) shown: Shown,
    /// Columns and rows to render.
    pub(crate) size: [u32; 2],
    /// A preview: one sample in the middle of each pixel.
    pub(crate) preview: bool,
    /// Whether the noise will be taken out of it: that needs layers.
    pub(crate) denoised: bool,
}

/// Virtual lights that a pixel gathers while the camera moves, at most, as far as patterns are wide enough.
const MOST_LIGHTS: u32 = 64;

/// Pixels that previews render where no time was measured.
const SHARE: MotionShare = MotionShare { fresh: 1.0 / 48.0, stride: 2 };

/// Width of the pattern of interleaved pixels while the camera moves.
fn pattern_in_motion(vpls: u32) -> u32 {
    [3, 5, 7].into_iter().find(|n| vpls <= MOST_LIGHTS * n * n).unwrap_or(7)
}

/// A picture in the making.
pub(crate) struct Eye {
    /// Options that are constant from picture to picture.
    options: RenderOptions,
    making: Option<Making>,
    /// State that previews leave to the next one.
    history: PictureHistory,
    /// Pixels that previews render where they reuse earlier ones.
    pub(crate) share: MotionShare,
    pub(crate) colors: Vec<[f32; 4]>,
    /// The space of the light of the world last seen; `colors` are of Rec. 709.
    space: WorkingSpace,
    /// The displayed colours of a picture at rest.
    temporal_filter: TemporalFilter,
}

struct Making {
    camera: Camera,
    accumulation: Accumulation,
    rays: Arc<dyn CameraShader>,
    shown: Shown,
    /// Distance from eye to target.
    reach: f32,
    preview: bool,
    /// Colours without noise, and of how many samples.
    clean: Option<(u32, Vec<[f32; 4]>)>,
}

impl Eye {
    pub(crate) fn new(options: RenderOptions) -> Self {
        Self {
            options,
            making: None,
            history: PictureHistory::default(),
            share: SHARE,
            colors: Vec::new(),
            space: WorkingSpace::default(),
            temporal_filter: TemporalFilter::default(),
        }
    }

    /// Begins a picture; a shader may replace the camera.
    pub(crate) fn begin(
        &mut self,
        view_request: &ViewRequest,
        script: Option<&CameraScript>,
        pool: &ThreadPool,
    ) -> Result<(), ViewError> {
        let [width, height] = view_request.size;
        let options = RenderOptions {
            width,
            height,
            integrator: view_request.shown.integrator(),
            aovs: view_request.shown.needs_layers() || view_request.denoised,
            seen: view_request.denoised,
            pixel_centres: view_request.preview || self.options.pixel_centres,
            spp: if view_request.preview { 1 } else { self.options.spp },
            // For integrators with virtual lights.
            interleave: match self.options.interleave {
                given if view_request.preview => given.max(pattern_in_motion(self.options.vpls)),
                given => given,
            },
            crop: None,
            heatmap: false,
            ..self.options.clone()
        };
        let rays = camera_rays(&view_request.camera, script, view_request.size).ok_or(ViewError::NoView)?;
        self.begin_filter(view_request, pool);
        let accumulation = match self.making.take() {
            Some(mut making) => making.accumulation.restart(options).map(|()| making.accumulation),
            None => Accumulation::new(options),
        };
        let reach = (0..3)
            .map(|k| (view_request.camera.target[k] - view_request.camera.eye[k]).powi(2))
            .sum::<f32>()
            .sqrt();
        self.making = Some(Making {
            camera: view_request.camera.clone(),
            accumulation: accumulation?,
            rays,
            shown: view_request.shown,
            reach,
            preview: view_request.preview,
            clean: None,
        });
        Ok(())
    }

    /// Samples of each pixel that complete a picture at rest, from the next one on.
    pub(crate) fn aim_at(&mut self, spp: u32) {
        self.options.spp = spp;
    }

    /// The first displayed colours of a picture at rest: those of the same view's preview.
    fn begin_filter(&mut self, view_request: &ViewRequest, pool: &ThreadPool) {
        let is_same = self.making.as_ref().is_some_and(|making| {
            let RenderOptions { width, height, .. } = *making.accumulation.options();
            let is_whole = making.accumulation.samples() > 0;
            is_whole
                && [width, height] == view_request.size
                && (making.shown, &making.camera) == (view_request.shown, &view_request.camera)
        });
        if view_request.preview || !is_same || view_request.shown.needs_layers() {
            self.temporal_filter.forget();
        } else if self.making.as_ref().is_some_and(|making| making.preview) {
            self.catch_up(pool);
            self.temporal_filter.begin(view_request.size[0] as usize, &self.colors);
        }
    }

    /// Whether previews reuse the light of earlier ones.
    pub(crate) fn remembers(
        &self,
        view_request: &ViewRequest,
        script: Option<&CameraScript>,
        world: &World,
    ) -> bool {
        let [width, height] = view_request.size;
        let integrator = view_request.shown.integrator();
        let options =
            RenderOptions { width, height, integrator, crop: None, heatmap: false, ..self.options.clone() };
        !view_request.shown.needs_layers()
            && camera_rays(&view_request.camera, script, view_request.size)
                .is_some_and(|rays| PictureHistory::suits(world, &*rays, &options))
    }

    /// Whether all that is known is shown.
    pub(crate) fn is_filtered(&self) -> bool {
        self.making.as_ref().is_none_or(|making| making.preview || making.shown.needs_layers())
            || self.temporal_filter.is_there()
    }

    /// The last displayed colours, row by row.
    pub(crate) fn shown(&mut self, pool: &ThreadPool) -> &[[f32; 4]] {
        match &self.making {
            Some(making) if !making.preview && !making.shown.needs_layers() => self.temporal_filter.shown(),
            _ => {
                self.catch_up(pool);
                &self.colors
            }
        }
    }

    /// Adds samples; returns false if it was stopped.
    pub(crate) fn pass(
        &mut self,
        world: &World,
        samples: u32,
        pool: &ThreadPool,
        progress: &dyn Progress,
    ) -> bool {
        self.space = world.space();
        let Some(Making { accumulation, rays, preview, .. }) = &mut self.making else { return true };
        if *preview {
            return accumulation.pass_remembering(&mut self.history, self.share, world, rays, pool, progress);
        }
        accumulation.pass(world, &**rays, samples, pool, progress)
    }

    /// The cost of the last preview made from earlier ones.
    pub(crate) fn motion_cost(&self) -> MotionCost {
        self.history.cost()
    }

    /// Samples of each pixel so far.
    pub(crate) fn samples(&self) -> u32 {
        self.making.as_ref().map_or(0, |making| making.accumulation.samples())
    }

    /// Samples of each pixel when it is done.
    pub(crate) fn target_samples(&self) -> u32 {
        self.making.as_ref().map_or(0, |making| making.accumulation.options().spp)
    }

    /// Rays so far.
    pub(crate) fn rays(&self) -> u64 {
        self.making.as_ref().map_or(0, |making| making.accumulation.stats().rays())
    }

    pub(crate) fn is_complete(&self) -> bool {
        self.making.as_ref().is_none_or(|making| making.accumulation.is_complete())
    }

    /// Samples of each pixel that were denoised last; 0 if none was.
    pub(crate) fn clean_samples(&self) -> u32 {
        self.making.as_ref().and_then(|making| making.clean.as_ref()).map_or(0, |(samples, _)| *samples)
    }

    /// Removes the noise from the samples so far; returns the method, unless it was stopped or there is none.
    pub(crate) fn denoise(
        &mut self,
        how: &denoise::Options,
        pool: &ThreadPool,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<denoise::Used>, denoise::Error> {
        let Some(Making { accumulation, clean, .. }) = &mut self.making else { return Ok(None) };
        let mut picture = accumulation.picture();
        let used = denoise::denoise_unless(stop, &mut picture, how, pool)?;
        if used.is_some() {
            *clean = Some((accumulation.samples(), picture.color));
        }
        Ok(used)
    }

    /// Updates a screen of that size from the samples, and `colors` as well, except for previews. `clean`:
    /// the last denoised picture is displayed, if there is one.
    pub(crate) fn develop(
        &mut self,
        exposure: Exposure,
        size: [u32; 2],
        screen: &mut Vec<u32>,
        clean: bool,
        pool: &ThreadPool,
    ) {
        let Some(making) = &self.making else { return };
        let Making { accumulation, shown, reach, preview, .. } = making;
        let RenderOptions { width, height, .. } = *accumulation.options();
        self.colors.resize(width as usize * height as usize, [0.0; 4]);
        let parts = if let Some((samples, clean)) = making.clean.as_ref().filter(|_| clean) {
            self.colors.clone_from(clean);
            convert_from(self.space, &mut self.colors);
            self.temporal_filter.follow(width as usize, &self.colors, *samples);
            Part::all_of(self.temporal_filter.shown(), [width, height])
        } else if shown.needs_layers() {
            shown.colors(&accumulation.picture(), *reach, &mut self.colors);
            if *shown == Shown::Albedo {
                convert_from(self.space, &mut self.colors);
            }
            Part::all_of(&self.colors, [width, height])
        } else if *preview && self.space.to_rec709().is_none() {
            accumulation.film_bands().into_iter().map(Part::Passing).collect()
        } else {
            accumulation.write_colors(&mut self.colors, pool);
            convert_from(self.space, &mut self.colors);
            if *preview {
                Part::all_of(&self.colors, [width, height])
            } else {
                self.temporal_filter.follow(width as usize, &self.colors, accumulation.samples());
                Part::all_of(self.temporal_filter.shown(), [width, height])
            }
        };
        screen::develop(exposure, parts, [width, height], size, screen, Some(pool));
    }

    /// Brings `colors` up to date where [`develop`](Self::develop) has left them behind.
    pub(crate) fn catch_up(&mut self, pool: &ThreadPool) {
        if let Some(Making { accumulation, preview: true, shown, .. }) = &self.making
            && !shown.needs_layers()
        {
            accumulation.write_colors(&mut self.colors, pool);
            convert_from(self.space, &mut self.colors);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::render::{CommitOptions, Integrator, ShaderTable, Silent};

    #[test]
    fn looks_in_passing_are_the_same_pixels() {
        let pool = gnurt::thread_pool(2).expect("two threads");
        let mut scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
        gnurt::defaults::complete(&mut scene, 1.0);
        let mut world = World::new();
        world
            .commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool)
            .expect("a sound scene");
        let (camera, shown) = (scene.cameras()[0].clone(), Shown::Light(Integrator::Eyelight));
        let from = [61, 47];
        let mut eye = Eye::new(RenderOptions::default());
        eye.begin(&ViewRequest { camera, shown, size: from, preview: true, denoised: false }, None, &pool)
            .expect("a view");
        assert!(eye.pass(&world, 1, &pool, &Silent), "nobody stops it");
        for size in [from, [130, 90], [61, 20], [20, 47], [7, 200]] {
            let (mut passing, mut history) = (Vec::new(), Vec::new());
            eye.develop(Exposure::default(), size, &mut passing, false, &pool);
            eye.catch_up(&pool);
            let parts = Part::all_of(&eye.colors, from);
            screen::develop(Exposure::default(), parts, from, size, &mut history, None);
            assert!(passing == history && history.iter().any(|&pixel| pixel != 0), "{size:?}");
        }
    }

    #[test]
    fn patterns_follow_the_number_of_lights() {
        let found = [1, 576, 577, 1024, 1 << 20].map(pattern_in_motion);
        assert_eq!(found, [3, 3, 5, 5, 7], "64 lights for each pixel at most, if that can be");
    }
}
