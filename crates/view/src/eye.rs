// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture in the making, as somebody looks at it: samples, then colours of what is shown.
//! Memory is used again from picture to picture. Tests: `tests`.

use std::sync::Arc;

use gnurt::ThreadPool;
use gnurt::camera_rays;
use gnurt::denoise;
use gnurt::osl::CameraScript;
use gnurt::render::{Accumulation, KeptPicture, MotionCost, Progress, RenderOptions, World};
use gnurt::scene::Camera;
use gnurt::shading::CameraShader;

use crate::calm::Calm;
use crate::error::ViewError;
use crate::exposure::Exposure;
use crate::screen::{self, Part};
use crate::shown::Shown;

/// What is looked at, from where.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sight {
    pub(crate) camera: Camera,
    pub(crate) shown: Shown,
    /// Columns and rows to render.
    pub(crate) size: [u32; 2],
    /// A look in passing: one sample in the middle of each pixel.
    pub(crate) fleeting: bool,
    /// Whether the noise will be taken out of it: that needs layers.
    pub(crate) denoised: bool,
}

/// Virtual lights that a pixel gathers while the camera moves, at most, as far as patterns are wide enough.
const MOST_LIGHTS: u32 = 64;

/// Share of the pixels that get a fresh sample of light unless somebody measures time.
pub(crate) const FRESH: f32 = 1.0 / 16.0;

/// Width of the pattern of interleaved pixels while the camera moves.
fn pattern_in_motion(vpls: u32) -> u32 {
    [3, 5, 7].into_iter().find(|n| vpls <= MOST_LIGHTS * n * n).unwrap_or(7)
}

/// A picture in the making.
pub(crate) struct Eye {
    /// What does not change from sight to sight.
    options: RenderOptions,
    making: Option<Making>,
    /// What looks in passing leave to the next one.
    kept: KeptPicture,
    /// Share of the pixels for which looks in passing take a fresh sample of light, where they remember the others.
    pub(crate) fresh: f32,
    pub(crate) colors: Vec<[f32; 4]>,
    /// What is shown of a picture at rest.
    calm: Calm,
}

struct Making {
    camera: Camera,
    accumulation: Accumulation,
    rays: Arc<dyn CameraShader>,
    shown: Shown,
    /// Distance from eye to target.
    reach: f32,
    fleeting: bool,
    /// Colours without noise, and of how many samples.
    clean: Option<(u32, Vec<[f32; 4]>)>,
}

impl Eye {
    pub(crate) fn new(options: RenderOptions) -> Self {
        Self {
            options,
            making: None,
            kept: KeptPicture::default(),
            fresh: FRESH,
            colors: Vec::new(),
            calm: Calm::default(),
        }
    }

    /// Begins a picture; a shader may stand in the camera's place.
    pub(crate) fn begin(
        &mut self,
        sight: &Sight,
        script: Option<&CameraScript>,
        pool: &ThreadPool,
    ) -> Result<(), ViewError> {
        let [width, height] = sight.size;
        let options = RenderOptions {
            width,
            height,
            integrator: sight.shown.integrator(),
            aovs: sight.shown.needs_layers() || sight.denoised,
            pixel_centres: sight.fleeting || self.options.pixel_centres,
            spp: if sight.fleeting { 1 } else { self.options.spp },
            // For integrators with virtual lights.
            interleave: match self.options.interleave {
                given if sight.fleeting => given.max(pattern_in_motion(self.options.vpls)),
                given => given,
            },
            crop: None,
            heatmap: false,
            ..self.options.clone()
        };
        let rays = camera_rays(&sight.camera, script, sight.size).ok_or(ViewError::NoView)?;
        self.begin_calm(sight, pool);
        let accumulation = match self.making.take() {
            Some(mut making) => making.accumulation.restart(options).map(|()| making.accumulation),
            None => Accumulation::new(options),
        };
        let reach =
            (0..3).map(|k| (sight.camera.target[k] - sight.camera.eye[k]).powi(2)).sum::<f32>().sqrt();
        self.making = Some(Making {
            camera: sight.camera.clone(),
            accumulation: accumulation?,
            rays,
            shown: sight.shown,
            reach,
            fleeting: sight.fleeting,
            clean: None,
        });
        Ok(())
    }

    /// Samples of each pixel that complete what rests, from the next picture on.
    pub(crate) fn aim_at(&mut self, spp: u32) {
        self.options.spp = spp;
    }

    /// What is shown at first of a picture at rest: what was shown of the same view in passing.
    fn begin_calm(&mut self, sight: &Sight, pool: &ThreadPool) {
        let is_same = self.making.as_ref().is_some_and(|making| {
            let RenderOptions { width, height, .. } = *making.accumulation.options();
            let is_whole = making.accumulation.samples() > 0;
            is_whole
                && [width, height] == sight.size
                && (making.shown, &making.camera) == (sight.shown, &sight.camera)
        });
        if sight.fleeting || !is_same || sight.shown.needs_layers() {
            self.calm.forget();
        } else if self.making.as_ref().is_some_and(|making| making.fleeting) {
            self.catch_up(pool);
            self.calm.begin(sight.size[0] as usize, &self.colors);
        }
    }

    /// Whether looks in passing remember those before.
    pub(crate) fn remembers(&self, sight: &Sight, script: Option<&CameraScript>, world: &World) -> bool {
        let [width, height] = sight.size;
        let integrator = sight.shown.integrator();
        let options =
            RenderOptions { width, height, integrator, crop: None, heatmap: false, ..self.options.clone() };
        !sight.shown.needs_layers()
            && camera_rays(&sight.camera, script, sight.size)
                .is_some_and(|rays| KeptPicture::suits(world, &*rays, &options))
    }

    /// Whether all that is known is shown.
    pub(crate) fn is_calm(&self) -> bool {
        self.making.as_ref().is_none_or(|making| making.fleeting || making.shown.needs_layers())
            || self.calm.is_there()
    }

    /// What was shown last, row by row.
    pub(crate) fn shown(&mut self, pool: &ThreadPool) -> &[[f32; 4]] {
        match &self.making {
            Some(making) if !making.fleeting && !making.shown.needs_layers() => self.calm.shown(),
            _ => {
                self.catch_up(pool);
                &self.colors
            }
        }
    }

    /// Adds samples; says whether nobody stopped it.
    pub(crate) fn pass(
        &mut self,
        world: &World,
        samples: u32,
        pool: &ThreadPool,
        progress: &dyn Progress,
    ) -> bool {
        let Some(Making { accumulation, rays, fleeting, .. }) = &mut self.making else { return true };
        if *fleeting {
            return accumulation.pass_remembering(&mut self.kept, self.fresh, world, rays, pool, progress);
        }
        accumulation.pass(world, &**rays, samples, pool, progress)
    }

    /// What the last look in passing took that was made of those before.
    pub(crate) fn motion_cost(&self) -> MotionCost {
        self.kept.cost()
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

    /// Takes the noise out of the samples so far; says how, unless it was stopped or there is nothing.
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

    /// Brings a screen of that size up to date with the samples, and `colors` as well, but for looks in passing.
    /// `clean`: what was denoised last is shown, if anything was.
    pub(crate) fn develop(
        &mut self,
        exposure: Exposure,
        size: [u32; 2],
        screen: &mut Vec<u32>,
        clean: bool,
        pool: &ThreadPool,
    ) {
        let Some(making) = &self.making else { return };
        let Making { accumulation, shown, reach, fleeting, .. } = making;
        let RenderOptions { width, height, .. } = *accumulation.options();
        self.colors.resize(width as usize * height as usize, [0.0; 4]);
        let parts = if let Some((samples, clean)) = making.clean.as_ref().filter(|_| clean) {
            self.colors.clone_from(clean);
            self.calm.follow(width as usize, &self.colors, *samples);
            Part::all_of(self.calm.shown(), [width, height])
        } else if shown.needs_layers() {
            shown.colors(&accumulation.picture(), *reach, &mut self.colors);
            Part::all_of(&self.colors, [width, height])
        } else if *fleeting {
            accumulation.film_bands().into_iter().map(Part::Passing).collect()
        } else {
            accumulation.write_colors(&mut self.colors, pool);
            self.calm.follow(width as usize, &self.colors, accumulation.samples());
            Part::all_of(self.calm.shown(), [width, height])
        };
        screen::develop(exposure, parts, [width, height], size, screen, Some(pool));
    }

    /// Brings `colors` up to date where [`develop`](Self::develop) has left them behind.
    pub(crate) fn catch_up(&mut self, pool: &ThreadPool) {
        if let Some(Making { accumulation, fleeting: true, shown, .. }) = &self.making
            && !shown.needs_layers()
        {
            accumulation.write_colors(&mut self.colors, pool);
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
        eye.begin(&Sight { camera, shown, size: from, fleeting: true, denoised: false }, None, &pool)
            .expect("a view");
        assert!(eye.pass(&world, 1, &pool, &Silent), "nobody stops it");
        for size in [from, [130, 90], [61, 20], [20, 47], [7, 200]] {
            let (mut passing, mut kept) = (Vec::new(), Vec::new());
            eye.develop(Exposure::default(), size, &mut passing, false, &pool);
            eye.catch_up(&pool);
            let parts = Part::all_of(&eye.colors, from);
            screen::develop(Exposure::default(), parts, from, size, &mut kept, None);
            assert!(passing == kept && kept.iter().any(|&pixel| pixel != 0), "{size:?}");
        }
    }

    #[test]
    fn patterns_follow_the_number_of_lights() {
        let found = [1, 576, 577, 1024, 1 << 20].map(pattern_in_motion);
        assert_eq!(found, [3, 3, 5, 5, 7], "64 lights for each pixel at most, if that can be");
    }
}
