// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames of an animated scene, one after the other, through the filter over frames: `gnurt render --frames` for Python.
//! A frame comes out when those after it that it borrows light from have been rendered. Frame f has the seed of the
//! request plus f. All have one exposure, that of the clip's first time. Tests: `tests/test_frames.py`.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use gnurt::denoise::film::{Film, REACH};
use gnurt::denoise::{self, Used};
use gnurt::display_rules::meter;
use gnurt::image;
use gnurt::memory::{fitting_reach, picture_bytes};
use gnurt::render::{LightLayer, RenderStats};
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::given::Given;
use crate::picture::{Picture, noise_options};
use crate::rendering::{BuildRequest, Making};
use crate::stage::{Clip, Stage};
use crate::watch::watched;

/// Numbers of frames and their times.
#[derive(Clone, Copy)]
struct Times {
    first: u32,
    step: u32,
    count: usize,
    fps: f64,
}

impl Times {
    fn new(given: &mut Given) -> PyResult<Self> {
        const MOST: u64 = u32::MAX as u64;
        let first = given.whole("first", 0, MOST)?.unwrap_or(0) as u32;
        let step = given.whole("step", 1, MOST)?.unwrap_or(1) as u32;
        let count = given.whole("count", 0, MOST)?.unwrap_or(0) as usize;
        let fps = given.number("fps", 1e-3, 1e6)?.unwrap_or(24.0);
        let last = u64::from(first) + u64::from(step) * (count.max(1) as u64 - 1);
        if last > MOST {
            return Err(PyValueError::new_err(format!("numbers: expected frames up to {MOST}, not {last}")));
        }
        Ok(Self { first, step, count, fps })
    }

    fn number(&self, i: usize) -> u32 {
        self.first + self.step * i as u32
    }

    /// Seconds of a frame; `None` beyond the last one.
    fn at(&self, i: Option<usize>) -> Option<f64> {
        i.filter(|&i| i < self.count).map(|i| f64::from(self.number(i)) / self.fps)
    }
}

/// What belongs to a frame that waits for others.
struct Waiting {
    light_layers: Vec<LightLayer>,
    stats: RenderStats,
    making: Making,
}

/// Frames on their way.
struct Progress {
    stage: Stage,
    request: BuildRequest,
    next: usize,
    film: Option<Film<Waiting>>,
    done: VecDeque<Picture>,
    /// That of all frames, once it is known.
    exposure: Option<f32>,
}

/// The frames of an animated scene.
#[pyclass(module = "gnurt", frozen)]
pub(crate) struct Frames {
    times: Times,
    progress: Mutex<Progress>,
}

impl Frames {
    /// Of a copy of the scene. `times` has first, step, count, fps, animation and denoise_window.
    pub(crate) fn new(
        stage: Stage,
        times: &Bound<'_, PyDict>,
        arguments: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let mut given = Given::new(times);
        let read = Times::new(&mut given)?;
        let clip = given.text("animation")?.map_or(Clip::First, Clip::Named);
        let window = given.whole("denoise_window", 0, 16)?.map(|reach| reach as usize);
        given.end()?;
        if arguments.contains("at")? {
            return Err(PyTypeError::new_err("at: conflicts with frames, whose times are number / fps"));
        }
        if stage.scene().animation().is_none_or(|animation| animation.clips.is_empty()) {
            return Err(PyValueError::new_err("frames: the scene has no animation"));
        }
        let arguments = arguments.copy()?;
        arguments.set_item("at", 0.0)?;
        let mut request = BuildRequest::new(&arguments)?;
        request.view.at = Some((clip, read.at(Some(0)).unwrap_or(0.0)));
        request.view.bounds = stage.bounds(&request.view)?;
        let options = request.options();
        let size = [options.width, options.height];
        let reach = match request.denoiser() {
            None => 0,
            Some(_) => {
                let more = picture_bytes(options, true);
                fitting_reach(size, window.unwrap_or(REACH), more, window.is_some())
                    .map_err(|why| PyMemoryError::new_err(format!("denoise_window: {why}")))?
            }
        };
        let film = request
            .denoiser()
            .filter(|_| reach > 0 && read.count > 1)
            .map(|method| Film::new(noise_options(method, request.crop()), reach, read.count));
        let progress = Progress { stage, request, next: 0, film, done: VecDeque::new(), exposure: None };
        Ok(Self { times: read, progress: Mutex::new(progress) })
    }
}

impl Progress {
    /// The exposure of all frames, measured at the clip's first time unless the light has its own.
    fn meter(&mut self) -> PyResult<f32> {
        if let Some(exposure) = self.exposure {
            return Ok(exposure);
        }
        let pool = self.request.threads.pool()?;
        let start = self.stage.clip_start(&self.request.view)?;
        let shutter = std::mem::take(&mut self.request.view.shutter);
        if let (Some((_, seconds)), Some(start)) = (&mut self.request.view.at, start) {
            *seconds = start;
        }
        let shot = self.stage.shoot(&self.request.view, &pool);
        self.request.view.shutter = shutter;
        let shot = shot?;
        let exposure = match shot.exposure {
            Some(exposure) => exposure,
            None => meter(&shot.world, &*shot.camera, self.request.options(), &pool)
                .map_err(|why| PyValueError::new_err(why.to_string()))?,
        };
        self.exposure = Some(exposure);
        Ok(exposure)
    }

    /// Renders the next frame, and takes in those that it completes.
    fn advance(&mut self, times: &Times, watch: &crate::watch::Watch) -> PyResult<()> {
        let exposure = self.meter()?;
        let (i, pool) = (self.next, self.request.threads.pool()?);
        if let (Some((_, seconds)), Some(now)) = (&mut self.request.view.at, times.at(Some(i))) {
            *seconds = now;
        }
        let around = [times.at(i.checked_sub(1)), times.at(Some(i + 1))];
        let (mut shot, poses) = self.stage.shoot_between(&self.request.view, around, &pool)?;
        shot.exposure = Some(exposure);
        let number = u64::from(times.number(i));
        let rendered = self.request.rendered(&shot, number, &pool, watch, &mut |picture| {
            let [before, after] = &poses.around;
            poses.now.add_motion(picture, before.as_ref(), after.as_ref());
        })?;
        if gnurt::render::Progress::should_stop(watch) {
            return Ok(());
        }
        self.next += 1;
        let (picture, light_layers, stats) = rendered;
        let making = self.request.making(shot, number);
        match &mut self.film {
            None => {
                let finished = self.request.finished(picture, &light_layers, &stats, &making)?;
                self.done.push_back(finished);
            }
            Some(film) => {
                let waiting = Waiting { light_layers, stats, making };
                let mut found = film.push(i, picture, waiting, &pool).map_err(failed)?;
                if self.next == times.count {
                    found.extend(film.finish(&pool).map_err(failed)?);
                }
                self.take(found);
            }
        }
        Ok(())
    }

    fn take(&mut self, found: Vec<(image::Picture, Waiting, Used)>) {
        for (mut picture, Waiting { light_layers, stats, making }, used) in found {
            picture.set_metadata("denoiser", used.name());
            self.done.push_back(self.request.dressed(picture, &light_layers, &stats, &making));
        }
    }
}

fn failed(error: denoise::Error) -> PyErr {
    PyValueError::new_err(format!("denoise: {error}"))
}

#[pymethods]
impl Frames {
    /// The next frame; `None` after the last one.
    #[pyo3(signature = (progress=None))]
    fn next(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Picture>> {
        let times = &self.times;
        loop {
            let found = watched(py, progress, |watch| {
                let mut state = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
                if state.done.is_empty() && state.next < times.count {
                    state.advance(times, watch)?;
                }
                Ok((state.done.pop_front(), state.next == times.count))
            })?;
            match found {
                (None, false) => {}
                (found, _) => return Ok(found),
            }
        }
    }

    /// Messages of shaders that were not reported yet.
    fn progress(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| self.progress.lock().unwrap_or_else(PoisonError::into_inner).stage.progress())
    }
}
