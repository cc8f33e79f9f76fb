// SPDX-License-Identifier: GPL-3.0-or-later
//! The thread that renders what the window wants to see: coarse while the camera moves, then finer, then more samples.
//! Source: after the habits of Cycles and OSPRay. A new view is first shown at the resolution that keeps the
//! picture moving, or whole, made of the pictures before, where light is found by chance; when it rests, resolution doubles until it is
//! full, then samples are added until there are enough, and are shown by steps too small to flicker (`calm.rs`).
//! A picture is shown when it is whole: what was stopped is not.
//! Frames of a camera that moves are finished, so that something is seen; all other work is stopped as soon as the view
//! changes. Invariant: pixels and samples of a finished picture are those of `gnurt::render::render`.
//! Tests: `super::tests`, and `crates/cli/tests/program/window.rs`.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use gnurt::ThreadPool;
use gnurt::denoise;
use gnurt::render::{Progress, RenderOptions};

use super::wish::{Front, News, Shared, Tuned, Wanted, Wish, lock};
use crate::error::ViewError;
use crate::eye::{Eye, Sight};
use crate::hud::Readings;
use crate::pace::{Pace, divided};
use crate::shown::Shown;
use crate::stage::{Loader, Stage};

/// Seconds that a frame of a moving camera may take.
const FRAME: f64 = 0.033;
/// Seconds that a pass of a resting one may take before it is shown.
const PASS: f64 = 0.2;
const MOST_SAMPLES: u32 = 16;
/// Between two steps of what is shown towards what is known, where nothing else is to be done.
const FADE: Duration = Duration::from_millis(10);

pub(super) struct Work {
    shared: Arc<Shared>,
    pool: ThreadPool,
    loader: Loader,
    tell: Box<dyn Fn(News) + Send>,
    eye: Eye,
    pace: Pace,
    back: Front,
    number: u64,
    /// Seconds that a sample of each pixel took in the last pass.
    per_sample: f64,
    denoiser: denoise::Options,
    /// How the noise was taken out last.
    used: Option<denoise::Used>,
    /// Seconds of passes since then, and seconds that it took.
    noisy_seconds: f64,
    clean_seconds: f64,
    /// What the world shows, and what it cost to bring it there.
    moment: Option<f64>,
    update_seconds: f64,
}

/// What the eye has in the making.
#[derive(Clone, Debug, PartialEq)]
struct Present {
    view: u64,
    shown: Shown,
    divisor: u32,
    fleeting: bool,
    /// Whether looks in passing remember those before, and are whole.
    remembers: bool,
    /// Whether it has the layers that denoisers look at.
    layers: bool,
    /// Whether nothing can be added until something changes.
    done: bool,
    /// Whether all that is known is shown.
    calm: bool,
}

impl Present {
    /// Where nothing can be seen.
    fn nothing(view: u64, shown: Shown) -> Self {
        Self {
            view,
            shown,
            divisor: 1,
            fleeting: false,
            remembers: false,
            layers: true,
            done: true,
            calm: true,
        }
    }
}

/// Stops a pass when another picture is wanted.
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
        tell: Box<dyn Fn(News) + Send>,
        options: RenderOptions,
        denoiser: denoise::Options,
    ) -> Self {
        Self {
            shared,
            pool,
            loader,
            tell,
            eye: Eye::new(options),
            pace: Pace::new(FRAME),
            back: Front::default(),
            number: 0,
            per_sample: PASS,
            denoiser,
            used: None,
            noisy_seconds: 0.0,
            clean_seconds: 0.0,
            moment: None,
            update_seconds: 0.0,
        }
    }

    pub(super) fn run(mut self) {
        let mut present: Option<Present> = None;
        loop {
            let (wish, view) = {
                let mut wanted = lock(&self.shared.wish);
                loop {
                    if self.shared.leaving.load(Ordering::Relaxed) {
                        return;
                    }
                    let idle = present.as_ref().is_some_and(|present| self.is_idle(present, &wanted));
                    if !idle || wanted.reload || wanted.has_edits() {
                        break;
                    }
                    wanted = self.shared.bell.wait(wanted).unwrap_or_else(PoisonError::into_inner);
                }
                if std::mem::take(&mut wanted.reload) {
                    self.shared.view.store(wanted.view, Ordering::Relaxed);
                    drop(wanted);
                    if self.reload() {
                        present = None;
                    }
                    continue;
                }
                if wanted.has_edits() {
                    let (changed, tuned) =
                        (std::mem::take(&mut wanted.changed), std::mem::take(&mut wanted.tuned));
                    // Whatever is wanted now is another picture than before.
                    wanted.view += 1;
                    self.shared.view.store(wanted.view, Ordering::Relaxed);
                    drop(wanted);
                    self.edit(&changed, &tuned);
                    continue;
                }
                (wanted.wish.clone(), wanted.view)
            };
            if wish.size.contains(&0) {
                // A window that is folded away shows nothing.
                present = Some(Present::nothing(view, wish.shown));
                continue;
            }
            if let Err(why) = self.update(wish.moment) {
                (self.tell)(News::Trouble(why));
            }
            let next = match self.next(present.take(), &wish, view) {
                Ok(next) => next,
                Err(error) => {
                    (self.tell)(News::Trouble(error.to_string()));
                    present = Some(Present::nothing(view, wish.shown));
                    continue;
                }
            };
            present = Some(self.look(next, &wish));
        }
    }

    /// Brings the world to a moment, if it is at another.
    fn update(&mut self, moment: Option<f64>) -> Result<(), String> {
        if self.moment == moment {
            return Ok(());
        }
        // One that cannot be shown is not tried again and again.
        self.moment = moment;
        let begin = Instant::now();
        self.on_stage(|stage, pool| stage.show(moment, pool))?;
        self.update_seconds = begin.elapsed().as_secs_f64();
        Ok(())
    }

    /// Changes what is looked at.
    fn on_stage<R>(&self, change: impl FnOnce(&mut Stage, &ThreadPool) -> R) -> R {
        loop {
            let mut shared = lock(&self.shared.stage);
            // Whoever asks what is under the cursor has it for a moment.
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
            (self.tell)(read.map_or_else(News::BadShader, News::Shaders));
        }
        for tuned in tuned {
            if let Err(why) = self.on_stage(|stage, pool| stage.tune(tuned, pool)) {
                (self.tell)(News::Trouble(why));
            }
        }
    }

    /// Whether there is nothing to do for what is wanted.
    fn is_idle(&self, present: &Present, wanted: &Wanted) -> bool {
        let clean = present.fleeting || self.back.readings.denoised == wanted.wish.wants_clean();
        let same = present.view == wanted.view && self.back.exposure == wanted.wish.exposure && clean;
        let waits = if present.fleeting { wanted.wish.moving } else { wanted.wish.paused };
        let rests = (present.done || waits) && present.calm;
        same && rests
    }

    /// What to render now: what is in the making, or a new picture.
    fn next(&mut self, present: Option<Present>, wish: &Wish, view: u64) -> Result<Present, ViewError> {
        let stage = lock(&self.shared.stage).clone();
        let script = stage.scripts.camera.as_ref();
        let next = match present {
            Some(present)
                if present.view == view && (present.fleeting || !self.lacks_layers(&present, wish)) =>
            {
                if !present.fleeting || wish.moving {
                    return Ok(present);
                }
                // It rests: finer, and at last with samples that count.
                let divisor = present.divisor / 2;
                Present {
                    divisor: divisor.max(1),
                    // One that remembers is whole before it rests.
                    fleeting: divisor > 1 || (present.remembers && present.divisor > 1),
                    layers: wish.wants_clean(),
                    ..present
                }
            }
            old => {
                if old.as_ref().is_some_and(|old| old.shown != wish.shown) {
                    self.pace.forget();
                }
                // What rests and only lacks layers goes on from what is shown.
                let goes_on = old.is_some_and(|old| old.view == view && !old.fleeting);
                let remembers = self.eye.remembers(&wish.sight(1), script, &stage.world);
                let divisor = if goes_on {
                    1
                } else if remembers {
                    let (divisor, fresh) = self.pace.remembering(wish.size);
                    self.eye.fresh = fresh;
                    divisor
                } else {
                    self.pace.divisor(wish.size)
                };
                Present {
                    view,
                    shown: wish.shown,
                    divisor,
                    // What is remembered is seen at once; what rests begins with that.
                    fleeting: wish.moving || divisor > 1 || (remembers && !goes_on),
                    remembers,
                    layers: wish.wants_clean(),
                    done: false,
                    calm: true,
                }
            }
        };
        (self.noisy_seconds, self.clean_seconds) = (0.0, 0.0);
        let fleeting = next.fleeting;
        let sight = Sight { fleeting, denoised: next.layers && !fleeting, ..wish.sight(next.divisor) };
        self.eye.begin(&sight, script, &self.pool)?;
        Ok(next)
    }

    /// Whether it cannot be denoised, and shall be.
    fn lacks_layers(&self, present: &Present, wish: &Wish) -> bool {
        wish.wants_clean() && !present.layers
    }

    /// Adds samples, and shows what came out.
    fn look(&mut self, mut present: Present, wish: &Wish) -> Present {
        let begin = Instant::now();
        let size = divided(wish.size, present.divisor);
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let (rays, taken) = (self.eye.rays(), self.eye.samples());
        let idle = self.eye.is_complete() || (wish.paused && taken > 0);
        if !idle {
            let samples = if taken == 0 { 1 } else { self.samples_per_pass() };
            let stage = lock(&self.shared.stage).clone();
            // The first picture of a moving camera is seen whatever happens.
            let finishes = wish.moving && present.fleeting;
            let cancel = Cancel { shared: &self.shared, view: present.view, finishes };
            if !self.eye.pass(&stage.world, samples, &self.pool, &cancel) {
                return present;
            }
        } else if !present.calm {
            std::thread::sleep(FADE);
        }
        let wants_clean = wish.wants_clean() && !present.fleeting;
        // The first picture is shown as it is.
        if wants_clean && taken > 0 && !self.make_clean(&present, wish, begin.elapsed().as_secs_f64()) {
            return present;
        }
        let is_clean = wants_clean && self.eye.clean_samples() > 0;
        self.eye.develop(wish.exposure, wish.size, &mut self.back.screen, is_clean, &self.pool);
        let seconds = begin.elapsed().as_secs_f64();
        let new_samples = self.eye.samples() - taken;
        if new_samples > 0 {
            self.per_sample = seconds / f64::from(new_samples);
            if present.remembers && present.fleeting {
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
        (self.back.number, self.back.size, self.back.exposure) = (self.number, wish.size, wish.exposure);
        (self.back.whole, self.back.view) = (!present.fleeting, present.view);
        std::mem::swap(&mut self.back.colors, &mut self.eye.colors);
        let is_waited_for = wants_clean && self.eye.clean_samples() < self.eye.samples();
        present.done = !present.fleeting && self.eye.is_complete() && !is_waited_for;
        present.calm = self.eye.is_calm();
        self.publish();
        (self.tell)(News::Picture);
        present
    }

    /// Takes the noise out of the samples so far, if that was not done and it is time to; says whether there is something to
    /// show. `seconds` went into the last pass.
    fn make_clean(&mut self, present: &Present, wish: &Wish, seconds: f64) -> bool {
        self.noisy_seconds += seconds;
        let is_last = self.eye.is_complete() || wish.paused;
        // Half of the time for samples, half for the denoiser.
        let is_due = is_last || self.eye.clean_samples() == 0 || self.noisy_seconds >= self.clean_seconds;
        if !is_due || self.eye.clean_samples() == self.eye.samples() {
            // Another exposure is shown at once.
            return is_last || self.back.exposure != wish.exposure || !self.back.readings.denoised;
        }
        let begin = Instant::now();
        let cancel = Cancel { shared: &self.shared, view: present.view, finishes: false };
        match self.eye.denoise(&self.denoiser, &self.pool, &|| cancel.should_stop()) {
            Ok(Some(used)) => {
                (self.noisy_seconds, self.clean_seconds) = (0.0, begin.elapsed().as_secs_f64());
                if self.used.as_ref() != Some(&used) {
                    (self.tell)(News::Denoised(used.to_string()));
                    self.used = Some(used);
                }
                true
            }
            Ok(None) => false,
            Err(error) => {
                (self.tell)(News::Trouble(error.to_string()));
                false
            }
        }
    }

    /// Gives the back to the window and takes its old front.
    fn publish(&mut self) {
        let mut front = lock(&self.shared.front);
        let (readings, exposure) = (self.back.readings, self.back.exposure);
        std::mem::swap(&mut *front, &mut self.back);
        // What is compared with later is what is shown, not what was shown before.
        (self.back.readings, self.back.exposure) = (readings, exposure);
    }

    /// As many as take about as long as people like to wait for the next picture.
    fn samples_per_pass(&self) -> u32 {
        ((PASS / self.per_sample.max(1e-4)) as u32).clamp(1, MOST_SAMPLES).min(self.eye.samples().max(1))
    }

    /// Reads the scene again; says whether there is a new one.
    fn reload(&mut self) -> bool {
        match (self.loader)(&self.pool) {
            Ok(stage) => {
                let files = stage.files.clone();
                *lock(&self.shared.stage) = Arc::new(stage);
                self.moment = None;
                // What is shown until the next picture is of the old scene.
                let mut wanted = lock(&self.shared.wish);
                wanted.view += 1;
                self.shared.view.store(wanted.view, Ordering::Relaxed);
                drop(wanted);
                self.pace.forget();
                (self.tell)(News::Reloaded(files));
                true
            }
            Err(why) => {
                (self.tell)(News::Trouble(why));
                false
            }
        }
    }
}
