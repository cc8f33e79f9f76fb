// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames without a window: an orbit around the scene, or the same view repeatedly, at full speed. A frame is
//! the same as in a window: samples, tone curve, bytes of the screen.
//! Tests: `crates/cli/tests/program/viewing.rs`.

use std::f64::consts::TAU;
use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::image::Picture;
use gnurt::render::{Progress, RenderOptions};
use gnurt::scene::Camera;

use crate::error::ViewError;
use crate::exposure::Exposure;
use crate::eye::{Eye, ViewRequest};
use crate::flight::Flight;
use crate::shown::Shown;
use crate::stage::Stage;
use crate::temporal_filter::flicker;

/// Samples of a pass, at most.
const MOST_SAMPLES: u32 = 16;

/// Options of frames without a window.
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
    /// How many pictures of the last view follow, to which samples are added as a window does while nothing moves; their time does not
    /// count.
    pub rest: u32,
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
    /// The picture after the last frame, if any.
    pub rest: Option<Rest>,
}

/// How quiet pictures at rest were.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rest {
    /// Pictures after the last frame.
    pub pictures: u32,
    /// Samples of each pixel of the last one.
    pub samples: u32,
    /// Share by which the mean brightness of a block of 8 x 8 pixels changed from one picture to the next, where it changed most. Blocks
    /// darker than a twentieth of the picture count as that bright.
    pub most: f32,
    /// The same of the mean block and picture.
    pub mean: f32,
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
pub struct ShownFrame<'a> {
    eye: &'a mut Eye,
    picture: &'a mut Picture,
    pool: &'a ThreadPool,
    /// Whether nothing moves any more.
    rests: bool,
}

impl ShownFrame<'_> {
    /// The frame in linear light: the mean of its samples, or the window's displayed colours if it is at
    /// rest.
    pub fn picture(&mut self) -> &Picture {
        self.eye.catch_up(self.pool);
        let colors = if self.rests { self.eye.shown(self.pool) } else { &self.eye.colors };
        self.picture.color.clear();
        self.picture.color.extend_from_slice(colors);
        self.picture
    }
}

/// Renders frames; calls `on_frame` with the number of each and the frame itself, after each pass of samples: the
/// time that it takes does not count. Ends early if `progress` requests it.
///
/// # Errors
/// [`ViewError`] if there is nothing to see.
pub fn run_headless(
    options: &HeadlessOptions,
    stage: &Stage,
    pool: &ThreadPool,
    progress: &dyn Progress,
    on_frame: &mut dyn FnMut(u32, &mut ShownFrame) -> Result<(), ViewError>,
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
        // A window, too, displays one sample in motion.
        let preview = spp == 1 && options.orbit != 0.0;
        let view_request = ViewRequest { camera, shown, size, preview, denoised: false };
        eye.begin(&view_request, stage.scripts.camera.as_ref(), pool)?;
        let (mut seconds, mut finished) = (0.0, true);
        while finished && !eye.is_complete() {
            finished = eye.pass(&stage.world, eye.samples().clamp(1, MOST_SAMPLES), pool, progress);
            eye.develop(options.exposure, size, &mut screen, false, pool);
            seconds += begin.elapsed().as_secs_f64();
            on_frame(frame, &mut ShownFrame { eye: &mut eye, picture: &mut picture, pool, rests: false })?;
            begin = Instant::now();
        }
        times.rays += eye.rays();
        times.seconds.push(seconds);
        if !finished {
            break;
        }
        if frame + 1 == options.frames {
            break;
        }
        if options.orbit != 0.0 {
            flight.orbit(options.orbit / 360.0 * TAU / f64::from(options.frames), 0.0);
        }
    }
    if options.rest > 0 && !progress.should_stop() {
        times.rest = Some(rest(options, &mut eye, flight.camera(), stage, pool, progress, on_frame)?);
    }
    Ok(times)
}

/// Stays where the last frame was seen from, as a window does.
fn rest(
    options: &HeadlessOptions,
    eye: &mut Eye,
    camera: Camera,
    stage: &Stage,
    pool: &ThreadPool,
    progress: &dyn Progress,
    on_frame: &mut dyn FnMut(u32, &mut ShownFrame) -> Result<(), ViewError>,
) -> Result<Rest, ViewError> {
    let RenderOptions { width, height, integrator, .. } = options.render;
    let (size, shown) = ([width, height], Shown::Light(integrator));
    let mut picture = Picture { width, height, ..Picture::default() };
    let mut before = eye.shown(pool).to_vec();
    let mut rest = Rest::default();
    // More than there will be.
    eye.aim_at(options.rest.saturating_mul(MOST_SAMPLES));
    let view_request = ViewRequest { camera, shown, size, preview: false, denoised: false };
    eye.begin(&view_request, stage.scripts.camera.as_ref(), pool)?;
    let mut screen = Vec::new();
    while rest.pictures < options.rest
        && eye.pass(&stage.world, eye.samples().clamp(1, MOST_SAMPLES), pool, progress)
    {
        eye.develop(options.exposure, size, &mut screen, false, pool);
        let [most, mean] = flicker(width as usize, &before, eye.shown(pool));
        before.clear();
        before.extend_from_slice(eye.shown(pool));
        (rest.most, rest.mean) = (rest.most.max(most), rest.mean + mean);
        (rest.pictures, rest.samples) = (rest.pictures + 1, eye.samples());
        let mut shown = ShownFrame { eye, picture: &mut picture, pool, rests: true };
        on_frame(options.frames + rest.pictures - 1, &mut shown)?;
    }
    rest.mean /= rest.pictures.max(1) as f32;
    Ok(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_summed_up() {
        let times = FrameTimes { seconds: vec![0.3, 0.1, 0.2], rays: 1, threads: 1, rest: None };
        assert!((times.fps() - 5.0).abs() < 1e-9, "three frames in 0.6 s");
        let found = [0.0, 0.5, 1.0].map(|share| times.percentile(share));
        assert_eq!(found, [0.1, 0.2, 0.3], "shortest, median, longest");
        assert_eq!(FrameTimes::default().percentile(0.5), 0.0, "no frames");
    }
}
