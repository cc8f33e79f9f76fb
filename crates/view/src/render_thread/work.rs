// SPDX-License-Identifier: GPL-3.0-or-later
//! The render thread of the window: coarse pictures while the camera moves, then finer ones, then more
//! samples.
//! Source: after the habits of Cycles and OSPRay. A new view is first displayed at a resolution that keeps
//! the motion smooth, or, with random light samples, whole and made from earlier pictures. At rest the
//! resolution doubles up to the full one, then samples are added up to the limit, and are displayed by steps
//! too small to flicker (`temporal_filter.rs`). Only whole pictures are displayed; stopped ones are not.
//! Frames of a moving camera are finished, so that each is visible; all other work stops as soon as the view
//! changes. Invariant: pixels and samples of a finished picture are those of `gnurt::render::render`.
//! Tests: `super::tests`, and `crates/cli/tests/program/window.rs`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use gnurt::ThreadPool;
use gnurt::denoise;
use gnurt::render::{Progress, RenderOptions};

use super::request::{DisplayFrame, Pending, RenderEvent, RenderRequest, Shared, Tuned, lock};
use crate::error::ViewError;
use crate::eye::{Eye, ViewRequest};
use crate::hud::Readings;
use crate::pace::{Pace, divided};
use crate::shown::Shown;
use crate::stage::{Loader, Stage};

/// Seconds that a frame of a moving camera may take.
const FRAME: f64 = 0.033;
/// Seconds that a pass of a resting one may take before it is shown.
const PASS: f64 = 0.2;
const MOST_SAMPLES: u32 = 16;
/// Time between two steps of the display towards the known colours, if there is no other work.
const FADE: Duration = Duration::from_millis(10);

pub(super) struct Work {
    shared: Arc<Shared>,
    pool: ThreadPool,
    loader: Loader,
    notify: Box<dyn Fn(RenderEvent) + Send>,
    eye: Eye,
    pace: Pace,
    back: DisplayFrame,
    number: u64,
    /// Seconds that a sample of each pixel took in the last pass.
    per_sample: f64,
    denoiser: denoise::Options,
    /// How the noise was taken out last.
    used: Option<denoise::Used>,
    /// Seconds of passes since then, and seconds that it took.
    noisy_seconds: f64,
    clean_seconds: f64,
    /// The time that the world shows, and the cost of the update.
    clip_time: Option<f64>,
    /// The clip that was requested last.
    clip: Option<usize>,
    update_seconds: f64,
}

/// The picture that the eye is making.
#[derive(Clone, Debug, PartialEq)]
struct Present {
    view: u64,
    shown: Shown,
    divisor: u32,
    preview: bool,
    /// Whether previews reuse those before, and are whole.
    remembers: bool,
    /// Whether it has the layers that denoisers read.
    layers: bool,
    /// Whether nothing can be added until something changes.
    done: bool,
    /// Whether all that is known is shown.
    temporal_filter: bool,
}

impl Present {
    /// Where nothing can be seen.
    fn nothing(view: u64, shown: Shown) -> Self {
        Self {
            view,
            shown,
            divisor: 1,
            preview: false,
            remembers: false,
            layers: true,
            done: true,
            temporal_filter: true,
        }
    }
}

/// Stops a pass when another picture is needed.
struct Cancel<'a> {
    shared: &'a Shared,
    view: u64,
    finishes: bool,
}

impl Progress for Cancel<'_> {
    fn should_stop(&self) -> bool {
        let moved_on = !self.finishes && self.shared.view.load(Ordering::Relaxed) != self.view;
        moved_on || self.shared.leaving.load(Ordering::Relaxed)
    }
}

impl Work {
    pub(super) fn new(
        shared: Arc<Shared>,
        pool: ThreadPool,
        loader: Loader,
        notify: Box<dyn Fn(RenderEvent) + Send>,
        options: RenderOptions,
        denoiser: denoise::Options,
    ) -> Self {
        Self {
            shared,
            pool,
            loader,
            notify,
            eye: Eye::new(options),
            pace: Pace::new(FRAME),
            back: DisplayFrame::default(),
            number: 0,
            per_sample: PASS,
            denoiser,
            used: None,
            noisy_seconds: 0.0,
            clean_seconds: 0.0,
            clip_time: None,
            clip: None,
            update_seconds: 0.0,
        }
    }

    pub(super) fn run(mut self) {
        let mut present: Option<Present> = None;
        loop {
            let (request, view) = {
                let mut pending = lock(&self.shared.request);
                loop {
                    if self.shared.leaving.load(Ordering::Relaxed) {
                        return;
                    }
                    let idle = present.as_ref().is_some_and(|present| self.is_idle(present, &pending));
                    if !idle || pending.reload || pending.has_edits() {
                        break;
                    }
                    pending = self.shared.bell.wait(pending).unwrap_or_else(PoisonError::into_inner);
                }
                if std::mem::take(&mut pending.reload) {
                    self.shared.view.store(pending.view, Ordering::Relaxed);
                    let file = pending.file.take();
                    drop(pending);
                    if self.reload(file.as_deref()) {
                        present = None;
                    }
                    continue;
                }
                if pending.has_edits() {
                    let (changed, tuned) =
                        (std::mem::take(&mut pending.changed), std::mem::take(&mut pending.tuned));
                    // The picture needed now is another one than before.
                    pending.view += 1;
                    self.shared.view.store(pending.view, Ordering::Relaxed);
                    drop(pending);
                    self.edit(&changed, &tuned);
                    continue;
                }
                (pending.request.clone(), pending.view)
            };
            if request.size.contains(&0) {
                // A window that is folded away shows nothing.
                present = Some(Present::nothing(view, request.shown));
                continue;
            }
            if let Err(why) = self.update(request.clip_time, request.clip) {
                (self.notify)(RenderEvent::Trouble(why));
            }
            let next = match self.next(present.take(), &request, view) {
                Ok(next) => next,
                Err(error) => {
                    (self.notify)(RenderEvent::Trouble(error.to_string()));
                    present = Some(Present::nothing(view, request.shown));
                    continue;
                }
            };
            present = Some(self.trace_view(next, &request));
        }
    }

    /// Brings the world to a time of a clip, if it is at another.
    fn update(&mut self, clip_time: Option<f64>, clip: Option<usize>) -> Result<(), String> {
        if (self.clip_time, self.clip) == (clip_time, clip) {
            return Ok(());
        }
        if let Some(clip) = clip.filter(|_| self.clip != clip) {
            self.on_stage(|stage, _| stage.choose_clip(clip));
        }
        self.clip = clip;
        // A time that cannot be shown is not tried again and again.
        self.clip_time = clip_time;
        let begin = Instant::now();
        self.on_stage(|stage, pool| stage.show(clip_time, pool))?;
        self.update_seconds = begin.elapsed().as_secs_f64();
        Ok(())
    }

    /// Changes the stage.
    fn on_stage<R>(&self, change: impl FnOnce(&mut Stage, &ThreadPool) -> R) -> R {
        loop {
            let mut shared = lock(&self.shared.stage);
            // A query of the cursor holds it briefly.
            if let Some(stage) = Arc::get_mut(&mut shared) {
                return change(stage, &self.pool);
            }
            drop(shared);
            std::thread::yield_now();
        }
    }

    /// Reads shaders again and gives parameters their values.
    fn edit(&self, changed: &[PathBuf], tuned: &[Tuned]) {
        if !changed.is_empty() {
            let read = self.on_stage(|stage, pool| stage.read_again(changed, pool));
            (self.notify)(read.map_or_else(RenderEvent::BadShader, RenderEvent::Shaders));
        }
        for tuned in tuned {
            if let Err(why) = self.on_stage(|stage, pool| stage.tune(tuned, pool)) {
                (self.notify)(RenderEvent::Trouble(why));
            }
        }
    }

    /// Whether there is no work for the request.
    fn is_idle(&self, present: &Present, pending: &Pending) -> bool {
        let clean = present.preview || self.back.readings.denoised == pending.request.requests_denoising();
        let same = present.view == pending.view && self.back.exposure == pending.request.exposure && clean;
        let waits = if present.preview { pending.request.moving } else { pending.request.paused };
        let rests = (present.done || waits) && present.temporal_filter;
        same && rests
    }

    /// The next picture to render: the current one, or a new one.
    fn next(
        &mut self,
        present: Option<Present>,
        request: &RenderRequest,
        view: u64,
    ) -> Result<Present, ViewError> {
        let stage = lock(&self.shared.stage).clone();
        let script = stage.scripts.camera.as_ref();
        let next = match present {
            Some(present)
                if present.view == view && (present.preview || !self.lacks_layers(&present, request)) =>
            {
                if !present.preview || request.moving {
                    return Ok(present);
                }
                // It rests: finer, and at last with samples that count.
                let divisor = present.divisor / 2;
                let was_whole = present.divisor == 1 && self.eye.share.stride == 1;
                self.eye.share.stride = 1;
                Present {
                    divisor: divisor.max(1),
                    // All pixels of one that reuses others are traced before it rests.
                    preview: divisor > 1 || (present.remembers && !was_whole),
                    layers: request.requests_denoising(),
                    ..present
                }
            }
            old => {
                if old.as_ref().is_some_and(|old| old.shown != request.shown) {
                    self.pace.forget();
                }
                // A picture at rest that only lacks layers starts from the displayed one.
                let goes_on = old.is_some_and(|old| old.view == view && !old.preview);
                let remembers = self.eye.remembers(&request.view_request(1), script, &stage.world);
                let divisor = if goes_on {
                    1
                } else if remembers {
                    let (divisor, share) = self.pace.remembering(request.size);
                    self.eye.share = share;
                    divisor
                } else {
                    self.pace.divisor(request.size)
                };
                Present {
                    view,
                    shown: request.shown,
                    divisor,
                    // Reprojected light is displayed at once, and pictures at rest start from it.
                    preview: request.moving || divisor > 1 || (remembers && !goes_on),
                    remembers,
                    layers: request.requests_denoising(),
                    done: false,
                    temporal_filter: true,
                }
            }
        };
        (self.noisy_seconds, self.clean_seconds) = (0.0, 0.0);
        let preview = next.preview;
        let view_request =
            ViewRequest { preview, denoised: next.layers && !preview, ..request.view_request(next.divisor) };
        self.eye.begin(&view_request, script, &self.pool)?;
        Ok(next)
    }

    /// Whether it cannot be denoised, and shall be.
    fn lacks_layers(&self, present: &Present, request: &RenderRequest) -> bool {
        request.requests_denoising() && !present.layers
    }

    /// Adds samples, and displays the result.
    fn trace_view(&mut self, mut present: Present, request: &RenderRequest) -> Present {
        let begin = Instant::now();
        let size = divided(request.size, present.divisor);
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let (rays, taken) = (self.eye.rays(), self.eye.samples());
        let idle = self.eye.is_complete() || (request.paused && taken > 0);
        if !idle {
            let samples = if taken == 0 { 1 } else { self.samples_per_pass() };
            let stage = lock(&self.shared.stage).clone();
            // The first picture of a moving camera is always finished.
            let finishes = request.moving && present.preview;
            let cancel = Cancel { shared: &self.shared, view: present.view, finishes };
            if !self.eye.pass(&stage.world, samples, &self.pool, &cancel) {
                return present;
            }
        } else if !present.temporal_filter {
            std::thread::sleep(FADE);
        }
        let requests_denoising = request.requests_denoising() && !present.preview;
        // The first picture is shown as it is.
        if requests_denoising
            && taken > 0
            && !self.make_clean(&present, request, begin.elapsed().as_secs_f64())
        {
            return present;
        }
        let is_clean = requests_denoising && self.eye.clean_samples() > 0;
        self.eye.develop(request.exposure, request.size, &mut self.back.screen, is_clean, &self.pool);
        let seconds = begin.elapsed().as_secs_f64();
        let new_samples = self.eye.samples() - taken;
        if new_samples > 0 {
            self.per_sample = seconds / f64::from(new_samples);
            if present.remembers && present.preview {
                self.pace.note_remembering(pixels, self.eye.motion_cost());
            } else {
                self.pace.note(pixels * u64::from(new_samples), seconds);
            }
            self.back.readings = Readings {
                seconds,
                rays: self.eye.rays() - rays,
                samples: [self.eye.samples(), self.eye.target_samples()],
                rendered: size,
                denoised: false,
                update_seconds: self.update_seconds,
            };
        }
        self.back.readings.denoised = is_clean;
        self.number += 1;
        (self.back.number, self.back.size, self.back.exposure) =
            (self.number, request.size, request.exposure);
        (self.back.whole, self.back.view) = (!present.preview, present.view);
        std::mem::swap(&mut self.back.colors, &mut self.eye.colors);
        let is_waited_for = requests_denoising && self.eye.clean_samples() < self.eye.samples();
        present.done = !present.preview && self.eye.is_complete() && !is_waited_for;
        present.temporal_filter = self.eye.is_filtered();
        self.publish();
        (self.notify)(RenderEvent::Picture);
        present
    }

    /// Removes the noise from the samples so far, if that was not done and it is due; returns whether there
    /// is a result to show. `seconds` went into the last pass.
    fn make_clean(&mut self, present: &Present, request: &RenderRequest, seconds: f64) -> bool {
        self.noisy_seconds += seconds;
        let is_last = self.eye.is_complete() || request.paused;
        // Half of the time for samples, half for the denoiser.
        let is_due = is_last || self.eye.clean_samples() == 0 || self.noisy_seconds >= self.clean_seconds;
        if !is_due || self.eye.clean_samples() == self.eye.samples() {
            // Another exposure is shown at once.
            return is_last || self.back.exposure != request.exposure || !self.back.readings.denoised;
        }
        let begin = Instant::now();
        let cancel = Cancel { shared: &self.shared, view: present.view, finishes: false };
        match self.eye.denoise(&self.denoiser, &self.pool, &|| cancel.should_stop()) {
            Ok(Some(used)) => {
                (self.noisy_seconds, self.clean_seconds) = (0.0, begin.elapsed().as_secs_f64());
                if self.used.as_ref() != Some(&used) {
                    (self.notify)(RenderEvent::Denoised(used.to_string()));
                    self.used = Some(used);
                }
                true
            }
            Ok(None) => false,
            Err(error) => {
                (self.notify)(RenderEvent::Trouble(error.to_string()));
                false
            }
        }
    }

    /// Gives the back to the window and takes its old front.
    fn publish(&mut self) {
        let mut front = lock(&self.shared.front);
        let (readings, exposure) = (self.back.readings, self.back.exposure);
        std::mem::swap(&mut *front, &mut self.back);
        // Later comparisons use the currently displayed picture.
        (self.back.readings, self.back.exposure) = (readings, exposure);
    }

    /// As many samples as fit into the time between displayed pictures.
    fn samples_per_pass(&self) -> u32 {
        ((PASS / self.per_sample.max(1e-4)) as u32).clamp(1, MOST_SAMPLES).min(self.eye.samples().max(1))
    }

    /// Reads the scene again, or another one; returns whether there is a new one.
    fn reload(&mut self, file: Option<&Path>) -> bool {
        match (self.loader)(file, &self.pool) {
            Ok(stage) => {
                let files = stage.files.clone();
                *lock(&self.shared.stage) = Arc::new(stage);
                (self.clip_time, self.clip) = (None, None);
                // Until the next picture, the display shows the old scene.
                let mut pending = lock(&self.shared.request);
                pending.view += 1;
                self.shared.view.store(pending.view, Ordering::Relaxed);
                drop(pending);
                self.pace.forget();
                (self.notify)(RenderEvent::Reloaded { files, is_other: file.is_some() });
                true
            }
            Err(why) => {
                (self.notify)(RenderEvent::Trouble(why));
                false
            }
        }
    }
}
