// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames without a window: a turn around the scene, or the same view again and again, as fast as they come.
//! Source: original. A frame is what a window would show: samples, tone curve, bytes of the screen.
//! Proof: `crates/cli/tests/program/viewing.rs`.

use std::f64::consts::TAU;
use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::image::Picture;
use gnurt::render::{Progress, RenderOptions};
use gnurt::scene::Camera;

use crate::error::ViewError;
use crate::exposure::Exposure;
use crate::eye::{Eye, Sight};
use crate::flight::Flight;
use crate::shown::Shown;
use crate::stage::Stage;

/// Samples of a pass, at most.
const MOST_SAMPLES: u32 = 16;

/// What is rendered without a window.
#[derive(Clone, Debug)]
pub struct HeadlessOptions {
    /// Size, samples per frame, seed, integrator, filter, level: as `render` takes them.
    pub render: RenderOptions,
    /// Where it is seen from at first.
    pub camera: Camera,
    /// From light to bytes.
    pub exposure: Exposure,
    /// How many frames, at least 1.
    pub frames: u32,
    /// Degrees that the camera goes around its target over all frames; 0 = it stays.
    pub orbit: f64,
}

/// How long frames took.
#[derive(Clone, Debug, Default)]
pub struct FrameTimes {
    /// Seconds of each frame, in the order of rendering.
    pub seconds: Vec<f64>,
    /// Rays of all frames.
    pub rays: u64,
    /// Threads of the pool.
    pub threads: usize,
}

impl FrameTimes {
    /// Frames per second over all frames.
    #[must_use]
    pub fn fps(&self) -> f64 {
        self.seconds.len() as f64 / self.total().max(1e-9)
    }

    /// Seconds of all frames together.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// Seconds that this share of the frames did not exceed: 0.5 is the median, 1 the longest.
    #[must_use]
    pub fn percentile(&self, share: f64) -> f64 {
        let mut sorted = self.seconds.clone();
        sorted.sort_by(f64::total_cmp);
        let at = (share.clamp(0.0, 1.0) * sorted.len().saturating_sub(1) as f64).round() as usize;
        sorted.get(at).copied().unwrap_or(0.0)
    }
}

/// A frame that is on the screen.
pub struct SeenFrame<'a> {
    eye: &'a mut Eye,
    picture: &'a mut Picture,
    pool: &'a ThreadPool,
}

impl SeenFrame<'_> {
    /// The frame in linear light.
    pub fn picture(&mut self) -> &Picture {
        self.eye.catch_up(self.pool);
        self.picture.color.clone_from(&self.eye.colors);
        self.picture
    }
}

/// Renders frames; calls `seen` with the number of each and the frame itself, after each pass of samples: the
/// time that it takes does not count. Ends early if `progress` says so.
///
/// # Errors
/// [`ViewError`] if there is nothing to see.
pub fn run_headless(
    options: &HeadlessOptions,
    stage: &Stage,
    pool: &ThreadPool,
    progress: &dyn Progress,
    seen: &mut dyn FnMut(u32, &mut SeenFrame) -> Result<(), ViewError>,
) -> Result<FrameTimes, ViewError> {
    let RenderOptions { width, height, spp, integrator, .. } = options.render;
    options.render.region()?;
    let mut flight = Flight::new(&options.camera).ok_or(ViewError::NoView)?;
    let mut eye = Eye::new(options.render.clone());
    let mut screen = Vec::new();
    let mut times = FrameTimes { threads: pool.current_num_threads(), ..FrameTimes::default() };
    let mut picture = Picture { width, height, ..Picture::default() };
    for frame in 0..options.frames {
        let mut begin = Instant::now();
        let (camera, shown, size) = (flight.camera(), Shown::Light(integrator), [width, height]);
        // One sample in motion is what a window shows while the camera moves.
        let fleeting = spp == 1 && options.orbit != 0.0;
        eye.begin(&Sight { camera, shown, size, fleeting, denoised: false }, stage.scripts.camera.as_ref())?;
        let (mut seconds, mut finished) = (0.0, true);
        while finished && !eye.is_complete() {
            finished = eye.pass(&stage.world, eye.samples().clamp(1, MOST_SAMPLES), pool, progress);
            eye.develop(options.exposure, size, &mut screen, false, pool);
            seconds += begin.elapsed().as_secs_f64();
            seen(frame, &mut SeenFrame { eye: &mut eye, picture: &mut picture, pool })?;
            begin = Instant::now();
        }
        times.rays += eye.rays();
        times.seconds.push(seconds);
        if !finished {
            break;
        }
        if options.orbit != 0.0 {
            flight.orbit(options.orbit / 360.0 * TAU / f64::from(options.frames), 0.0);
        }
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_summed_up() {
        let times = FrameTimes { seconds: vec![0.3, 0.1, 0.2], rays: 1, threads: 1 };
        assert!((times.fps() - 5.0).abs() < 1e-9, "three frames in 0.6 s");
        let found = [0.0, 0.5, 1.0].map(|share| times.percentile(share));
        assert_eq!(found, [0.1, 0.2, 0.3], "shortest, median, longest");
        assert_eq!(FrameTimes::default().percentile(0.5), 0.0, "no frames");
    }
}
