// SPDX-License-Identifier: GPL-3.0-or-later
//! The thread that renders what the window wants to see: coarse while the camera moves, then finer, then more samples.
//! Source: original, after the habits of Cycles and OSPRay. A new view is first shown at the resolution that keeps the
//! picture moving; when it rests, resolution doubles until it is full, then samples are added until there are enough.
//! Frames of a camera that moves are finished, so that something is seen; all other work is stopped as soon as the view
//! changes. Invariant: pixels and samples of a finished picture are those of `gnurt::render::render`.
//! Proof: `tests`, and `crates/cli/tests/program/window.rs`.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::denoise;
use gnurt::osl::ParameterValue;
use gnurt::render::{Progress, RenderOptions};
use gnurt::scene::Camera;

use crate::error::ViewError;
use crate::exposure::Exposure;
use crate::eye::{Eye, Sight};
use crate::hud::Readings;
use crate::pace::{Pace, divided};
use crate::shown::Shown;
use crate::stage::{Loader, Stage};

/// What the window wants to see.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wish {
    pub(crate) camera: Camera,
    pub(crate) shown: Shown,
    pub(crate) size: [u32; 2],
    pub(crate) exposure: Exposure,
    /// Whether the camera will probably have moved on by the next frame.
    pub(crate) moving: bool,
    pub(crate) paused: bool,
    /// Whether the noise is to be taken out of what rests.
    pub(crate) denoised: bool,
    /// The moment of the clip; `None` = the scene at rest.
    pub(crate) moment: Option<f64>,
}

impl Wish {
    /// Whether the noise is to be taken out of what is shown: other pictures than light have none.
    fn wants_clean(&self) -> bool {
        self.denoised && matches!(self.shown, Shown::Light(_))
    }
}

/// A picture that can be shown.
#[derive(Default)]
pub(crate) struct Front {
    /// Rises with each picture.
    pub(crate) number: u64,
    /// Pixels of the window.
    pub(crate) size: [u32; 2],
    pub(crate) screen: Vec<u32>,
    /// Linear colours of what was rendered, `readings.rendered` pixels; old ones where it is not `whole`.
    pub(crate) colors: Vec<[f32; 4]>,
    pub(crate) exposure: Exposure,
    pub(crate) readings: Readings,
    /// Whether each pixel of the window was rendered with samples that count.
    pub(crate) whole: bool,
    /// Which change of the view it shows.
    pub(crate) view: u64,
}

/// What the window and the thread share.
struct Shared {
    wish: Mutex<Wanted>,
    bell: Condvar,
    /// The wish's `view`, for those who may not wait.
    view: AtomicU64,
    leaving: AtomicBool,
    front: Mutex<Front>,
    stage: Mutex<Arc<Stage>>,
}

struct Wanted {
    wish: Wish,
    /// Rises when another picture is wanted, not only another exposure.
    view: u64,
    reload: bool,
    /// Files of shaders that have changed.
    changed: Vec<PathBuf>,
    /// Values of shaders' parameters, the last one of each.
    tuned: Vec<Tuned>,
}

/// A script's number, its parameter and the value that this is to have.
pub(crate) type Tuned = (usize, String, ParameterValue);

impl Wanted {
    /// Whether shaders are to be changed.
    fn has_edits(&self) -> bool {
        !self.changed.is_empty() || !self.tuned.is_empty()
    }
}

/// What the thread tells the window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum News {
    /// There is another front.
    Picture,
    /// The scene was read again.
    Reloaded(Vec<PathBuf>),
    /// Shaders were read again; what is to be said of it, a line each.
    Shaders(Vec<String>),
    /// A shader could not be read again; the one before stays.
    BadShader(String),
    /// It could not be read or rendered; what was there stays.
    Trouble(String),
    /// How the noise was taken out, whenever that is another way than before.
    Denoised(String),
}

/// Renders beside the window; stops when dropped.
pub(crate) struct Looker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What a looker works with.
pub(crate) struct LookerParts {
    pub(crate) stage: Stage,
    pub(crate) options: RenderOptions,
    pub(crate) pool: ThreadPool,
    pub(crate) loader: Loader,
    pub(crate) denoiser: denoise::Options,
    /// Called from the thread.
    pub(crate) tell: Box<dyn Fn(News) + Send>,
}

/// Seconds that a frame of a moving camera may take.
const FRAME: f64 = 0.033;
/// Seconds that a pass of a resting one may take before it is shown.
const PASS: f64 = 0.2;
const MOST_SAMPLES: u32 = 16;

impl Looker {
    /// Begins to look.
    pub(crate) fn begin(parts: LookerParts, wish: Wish) -> Result<Self, ViewError> {
        let LookerParts { stage, options, pool, loader, denoiser, tell } = parts;
        let shared = Arc::new(Shared {
            wish: Mutex::new(Wanted { wish, view: 1, reload: false, changed: Vec::new(), tuned: Vec::new() }),
            bell: Condvar::new(),
            view: AtomicU64::new(1),
            leaving: AtomicBool::new(false),
            front: Mutex::new(Front::default()),
            stage: Mutex::new(Arc::new(stage)),
        });
        let work = Work {
            shared: shared.clone(),
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
        };
        let thread = std::thread::Builder::new().name("gnurt-looker".into()).spawn(move || work.run());
        Ok(Self { shared, thread: Some(thread.map_err(ViewError::Thread)?) })
    }

    /// Wants to see this from now on.
    pub(crate) fn want(&self, wish: &Wish) {
        let mut wanted = lock(&self.shared.wish);
        if wanted.wish == *wish {
            return;
        }
        let old = &wanted.wish;
        let seen = |wish: &Wish| (wish.shown, wish.size, wish.moment);
        if old.camera != wish.camera || seen(old) != seen(wish) {
            wanted.view += 1;
            self.shared.view.store(wanted.view, Ordering::Relaxed);
        }
        wanted.wish.clone_from(wish);
        self.shared.bell.notify_all();
    }

    /// Reads the scene again.
    pub(crate) fn reload(&self) {
        lock(&self.shared.wish).reload = true;
        // Whatever is being rendered is of no interest any more.
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// Reads shaders again that come from these files.
    pub(crate) fn read_again(&self, changed: Vec<PathBuf>) {
        lock(&self.shared.wish).changed.extend(changed);
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// Gives a shader's parameter another value.
    pub(crate) fn tune(&self, tuned: Tuned) {
        let mut wanted = lock(&self.shared.wish);
        wanted.tuned.retain(|(script, name, _)| (script, name) != (&tuned.0, &tuned.1));
        wanted.tuned.push(tuned);
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// The latest picture. The thread waits while somebody holds it.
    pub(crate) fn front(&self) -> MutexGuard<'_, Front> {
        lock(&self.shared.front)
    }

    /// Whether a picture shows what is wanted now.
    pub(crate) fn is_current(&self, front: &Front) -> bool {
        let wanted = lock(&self.shared.wish);
        let same = front.view == wanted.view && front.exposure == wanted.wish.exposure;
        same && front.readings.denoised == wanted.wish.wants_clean() && !wanted.reload && !wanted.has_edits()
    }

    /// What is looked at.
    pub(crate) fn stage(&self) -> Arc<Stage> {
        lock(&self.shared.stage).clone()
    }
}

impl Drop for Looker {
    fn drop(&mut self) {
        self.shared.leaving.store(true, Ordering::Relaxed);
        drop(lock(&self.shared.wish));
        self.shared.bell.notify_all();
        if let Some(thread) = self.thread.take() {
            // It has told about its panic already.
            let _ = thread.join();
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Work {
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
    /// Whether it has the layers that denoisers look at.
    layers: bool,
    /// Whether nothing can be added until something changes.
    done: bool,
}

impl Present {
    /// Where nothing can be seen.
    fn nothing(view: u64, shown: Shown) -> Self {
        Self { view, shown, divisor: 1, fleeting: false, layers: true, done: true }
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
    fn run(mut self) {
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
        let rests = present.done || waits;
        same && rests
    }

    /// What to render now: what is in the making, or a new picture.
    fn next(&mut self, present: Option<Present>, wish: &Wish, view: u64) -> Result<Present, ViewError> {
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
                    fleeting: divisor > 1,
                    layers: wish.wants_clean(),
                    ..present
                }
            }
            old => {
                if old.is_some_and(|old| old.shown != wish.shown) {
                    self.pace.forget();
                }
                let divisor = self.pace.divisor(wish.size);
                let fleeting = wish.moving || divisor > 1;
                Present {
                    view,
                    shown: wish.shown,
                    divisor,
                    fleeting,
                    layers: wish.wants_clean(),
                    done: false,
                }
            }
        };
        (self.noisy_seconds, self.clean_seconds) = (0.0, 0.0);
        let size = divided(wish.size, next.divisor);
        let sight = Sight {
            camera: wish.camera.clone(),
            shown: wish.shown,
            size,
            fleeting: next.fleeting,
            denoised: next.layers && !next.fleeting,
        };
        let stage = lock(&self.shared.stage).clone();
        self.eye.begin(&sight, stage.scripts.camera.as_ref())?;
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
            self.pace.note(pixels * u64::from(new_samples), seconds);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripts::{ScriptRole, Scripts, StageScript};
    use gnurt::render::{CommitOptions, Integrator, SceneCamera, ShaderTable, Silent, World, render};
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Duration;

    fn load(pool: &ThreadPool) -> Result<Stage, String> {
        let mut scene = gnurt::load_scene("builtin:cornell").map_err(|error| error.to_string())?.scene;
        gnurt::defaults::complete(&mut scene, 1.0);
        let mut world = World::new();
        let report = world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), pool);
        report.map_err(|error| error.to_string())?;
        Ok(Stage {
            scene,
            world,
            files: Vec::new(),
            clip: None,
            how: CommitOptions::default(),
            scripts: Scripts::default(),
            faults: Box::new(Vec::new),
        })
    }

    fn options() -> RenderOptions {
        RenderOptions { spp: 6, seed: 5, ..RenderOptions::default() }
    }

    fn begin(loader: Loader) -> (Looker, Receiver<News>, Wish) {
        begin_with(loader, load)
    }

    fn begin_with(
        loader: Loader,
        first: fn(&ThreadPool) -> Result<Stage, String>,
    ) -> (Looker, Receiver<News>, Wish) {
        let pool = gnurt::thread_pool(2).expect("two threads");
        begin_on(loader, first(&pool).expect("the box is built in"))
    }

    fn begin_on(loader: Loader, stage: Stage) -> (Looker, Receiver<News>, Wish) {
        let pool = gnurt::thread_pool(2).expect("two threads");
        let wish = Wish {
            camera: stage.scene.cameras()[0].clone(),
            shown: Shown::Light(Integrator::Whitted),
            size: [61, 47],
            exposure: Exposure::default(),
            moving: false,
            paused: false,
            denoised: false,
            moment: None,
        };
        let (sender, news) = channel();
        let tell = Box::new(move |what| drop(sender.send(what)));
        let denoiser = denoise::Options { method: denoise::Method::BuiltIn, ..denoise::Options::default() };
        let parts = LookerParts { stage, options: options(), pool, loader, denoiser, tell };
        (Looker::begin(parts, wish.clone()).expect("a thread"), news, wish)
    }

    /// Waits until the front is as it should be.
    #[track_caller]
    fn wait_for(looker: &Looker, what: &str, is_there: impl Fn(&Front) -> bool) {
        let begin = Instant::now();
        while !is_there(&looker.front()) {
            assert!(begin.elapsed() < Duration::from_secs(60), "no {what}: {:?}", looker.front().readings);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn is_finished(front: &Front) -> bool {
        front.whole && front.readings.samples == [6, 6]
    }

    #[test]
    fn what_is_seen_at_last_is_what_render_makes() {
        let (looker, _news, mut wish) = begin(Box::new(load));
        // Restless: views come faster than pictures.
        for step in 0..30 {
            wish.camera.eye[0] += 0.001;
            wish.moving = step % 3 != 0;
            looker.want(&wish);
            std::thread::sleep(Duration::from_millis(1));
        }
        wish.moving = false;
        looker.want(&wish);
        let view = lock(&looker.shared.wish).view;
        wait_for(&looker, "finished picture", |front| is_finished(front) && front.view == view);
        let pool = gnurt::thread_pool(1).expect("a thread");
        let stage = load(&pool).expect("the box");
        let camera = SceneCamera::new(&wish.camera).expect("a view");
        let options = RenderOptions { width: 61, height: 47, ..options() };
        let frame = render(&stage.world, &camera, &options, &pool, &Silent).expect("sound options");
        assert!(looker.front().colors == frame.picture.color, "the same bits");
        wish.exposure.stops = 2.0;
        looker.want(&wish);
        wait_for(&looker, "brighter picture", |front| front.exposure.stops == 2.0);
        assert!(is_finished(&looker.front()), "with the samples that were there");
    }

    #[test]
    fn moving_pictures_are_coarse_and_rest_makes_them_whole() {
        let (looker, _news, mut wish) = begin(Box::new(load));
        wait_for(&looker, "finished picture", is_finished);
        wish.moving = true;
        wish.camera.eye[0] += 0.01;
        looker.want(&wish);
        wait_for(&looker, "passing look", |front| !front.whole && front.view == 2);
        std::thread::sleep(Duration::from_millis(50));
        assert!(!looker.front().whole, "as long as it moves");
        (wish.moving, wish.shown) = (false, Shown::Depth);
        looker.want(&wish);
        wait_for(&looker, "finished picture of depths", |front| is_finished(front) && front.view == 3);
        let [r, g, b, _] = looker.front().colors[30];
        assert!(r == g && g == b && r > 0.0, "grey: {r} {g} {b}");
        (wish.paused, wish.shown) = (true, Shown::Light(Integrator::Normals));
        looker.want(&wish);
        wait_for(&looker, "first look", |front| front.view == 4);
        std::thread::sleep(Duration::from_millis(50));
        assert!(!is_finished(&looker.front()), "no samples are added");
    }

    #[test]
    fn noise_goes_when_asked_for() {
        let (looker, _news, mut wish) = begin(Box::new(load));
        wait_for(&looker, "finished picture", is_finished);
        let noisy = looker.front().colors.clone();
        wish.denoised = true;
        looker.want(&wish);
        wait_for(&looker, "clean picture", |front| is_finished(front) && front.readings.denoised);
        let pool = gnurt::thread_pool(1).expect("a thread");
        let stage = load(&pool).expect("the box");
        let camera = SceneCamera::new(&wish.camera).expect("a view");
        let options = RenderOptions { width: 61, height: 47, aovs: true, ..options() };
        let mut picture =
            render(&stage.world, &camera, &options, &pool, &Silent).expect("sound options").picture;
        let how = denoise::Options { method: denoise::Method::BuiltIn, ..denoise::Options::default() };
        denoise::denoise(&mut picture, &how, &pool).expect("it has all layers");
        assert!(looker.front().colors == picture.color, "as a picture that is denoised after rendering");
        assert!(noisy != picture.color, "another picture");
        wish.exposure.stops = 1.0;
        looker.want(&wish);
        wait_for(&looker, "brighter picture", |front| front.exposure.stops == 1.0 && front.readings.denoised);
        assert!(looker.front().colors == picture.color, "the same light");
        wish.denoised = false;
        looker.want(&wish);
        wait_for(&looker, "noise again", |front| !front.readings.denoised);
        assert!(is_finished(&looker.front()) && looker.front().colors == noisy, "with all samples");
        // A camera that moves is not waited for.
        (wish.denoised, wish.moving) = (true, true);
        wish.camera.eye[0] += 0.01;
        looker.want(&wish);
        wait_for(&looker, "passing look", |front| !front.whole && !front.readings.denoised);
    }

    /// The box with a ball of a triangle that falls from 0 to 1 s.
    fn falling(pool: &ThreadPool) -> Result<Stage, String> {
        use gnurt::scene::animation::{
            Channel, Clip, Interpolation, Local, MovingInstance, Node, Place, Sampler, Target, Trs,
        };
        let mut stage = load(pool)?;
        let instance = stage.scene.instantiate(gnurt::scene::ObjectId(0), gnurt::scene::Affine::IDENTITY);
        let keys =
            Sampler::new([0.0, 1.0].into(), vec![0.0, 0.5, 0.0, 0.0, 0.0, 0.0], 3, Interpolation::Linear);
        let ground = Place::Fixed { world_from_node: gnurt::scene::Affine::IDENTITY, visible: true };
        let node =
            Node { name: "n".into(), parent: ground, rest: Local::Parts(Trs::default()), visible: true };
        let channel = Channel { target: Target::Translation(0), sampler: Arc::new(keys.expect("keys")) };
        let animated = stage.scene.animate(gnurt::scene::Animation {
            clips: vec![Clip { name: "fall".into(), channels: vec![channel] }],
            nodes: vec![node],
            instances: vec![MovingInstance { instance, node: 0, is_placed: true }],
            ..gnurt::scene::Animation::default()
        });
        animated.map_err(|error| error.to_string())?;
        stage.clip = Some(0);
        stage.show(None, pool)?;
        Ok(stage)
    }

    #[test]
    fn moments_are_those_of_the_scene() {
        let pool = gnurt::thread_pool(1).expect("a thread");
        let (looker, news, mut wish) = begin_with(Box::new(falling), falling);
        wait_for(&looker, "finished picture", is_finished);
        // Played: moments come faster than pictures, and are seen all the same.
        wish.moving = true;
        for step in 1..40 {
            wish.moment = Some(f64::from(step) / 80.0);
            looker.want(&wish);
            std::thread::sleep(Duration::from_millis(2));
        }
        wait_for(&looker, "passing look", |front| !front.whole && front.readings.update_seconds > 0.0);
        for moment in [Some(0.25), Some(0.75), None] {
            (wish.moving, wish.moment) = (false, moment);
            looker.want(&wish);
            let view = lock(&looker.shared.wish).view;
            wait_for(&looker, "moment", |front| is_finished(front) && front.view == view);
            let mut stage = falling(&pool).expect("a box");
            stage.show(moment, &pool).expect("it can be shown");
            let camera = SceneCamera::new(&wish.camera).expect("a view");
            let options = RenderOptions { width: 61, height: 47, ..options() };
            let frame = render(&stage.world, &camera, &options, &pool, &Silent).expect("sound options");
            assert!(looker.front().colors == frame.picture.color, "{moment:?}: the same bits");
        }
        assert!(!news.try_iter().any(|news| matches!(news, News::Trouble(_))), "no trouble");
    }

    #[test]
    fn scenes_are_read_again_or_stay() {
        let count = AtomicU64::new(0);
        let (looker, news, _) = begin(Box::new(move |pool| match count.fetch_add(1, Ordering::Relaxed) {
            0 => Err("line 3 is broken".into()),
            _ => load(pool),
        }));
        wait_for(&looker, "finished picture", is_finished);
        let number = looker.front().number;
        let told = |looker: &Looker| {
            looker.reload();
            let mut news = news.iter().filter(|news| *news != News::Picture);
            news.next().expect("it is told")
        };
        assert_eq!(told(&looker), News::Trouble("line 3 is broken".into()), "what is wrong");
        assert_eq!(looker.front().number, number, "the picture stays");
        assert_eq!(told(&looker), News::Reloaded(Vec::new()), "mended");
        wait_for(&looker, "new picture", |front| is_finished(front) && front.number > number);
    }

    /// The box in a script of this text.
    fn painted(text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("paint.osl");
        std::fs::write(&file, text).expect("a file");
        (folder, file)
    }

    #[test]
    fn shaders_are_read_again_by_themselves_or_stay() {
        use gnurt::osl::{Access, Script};
        let (_folder, file) = painted("surface paint (float gain = 1) { Ci = gain * emission (); }");
        let pool = gnurt::thread_pool(2).expect("two threads");
        let mut stage = load(&pool).expect("the box");
        let script = Script::open(&file, &Access::default()).expect("it compiles");
        for id in 0..stage.scene.materials().len() as u32 {
            stage.scene.edit_material(gnurt::scene::MaterialId(id)).surface =
                gnurt::scene::Surface::Shader(0);
        }
        let surface = script.surface().expect("a surface");
        stage.scripts.table.surfaces.push(surface);
        stage.scripts.list.push(StageScript::new(script, ScriptRole::Surface(0)));
        stage.world.commit(&stage.scene, &stage.scripts.table, &stage.how, &pool).expect("a sound scene");
        let stage_files = stage.scripts.files();
        let (looker, news, wish) = begin_on(Box::new(load), stage);
        // Lamps and what lies beside the box show something else.
        let is_all = |value: f32| {
            move |front: &Front| {
                let count = front.colors.iter().filter(|pixel| pixel[1] == value).count();
                is_finished(front) && 2 * count > front.colors.len()
            }
        };
        wait_for(&looker, "first picture", is_all(1.0));
        let world = looker.stage().world.stats();
        let mut watch = crate::watch::Watch::new(stage_files);
        let mut save = |text: &str| {
            std::fs::write(&file, text).expect("a file");
            let begin = Instant::now();
            // As the window looks at files.
            let changed = loop {
                std::thread::sleep(Duration::from_millis(20));
                let changed = watch.changed();
                if !changed.is_empty() {
                    break changed;
                }
            };
            looker.read_again(changed);
            let told = news.iter().find(|news| !matches!(news, News::Picture | News::Denoised(_)));
            (told.expect("it is told"), begin.elapsed())
        };
        let (told, _) = save("surface paint (float gain = 1) { Ci = gainn * emission (); }");
        assert!(
            matches!(&told, News::BadShader(why) if why.contains("paint.osl:1") && why.contains("gainn")),
            "{told:?}"
        );
        wait_for(&looker, "the last good one", is_all(1.0));
        let (told, took) = save("surface paint (float gain = 2) { Ci = gain * emission (); }");
        assert_eq!(told, News::Shaders(vec!["paint.osl was read again".into()]));
        wait_for(&looker, "the new one", is_all(2.0));
        assert_eq!(looker.stage().world.stats(), world, "nothing else was made");
        // 74 ms beside twenty other programs on two cores.
        eprintln!("a saved shader is read after {} ms", took.as_millis());
        assert!(took < Duration::from_millis(1000), "{took:?}");
        for value in [3.0, 0.25] {
            looker.tune((0, "gain".into(), ParameterValue::Floats(vec![value])));
            wait_for(&looker, "the knob's value", is_all(value));
        }
        let (told, _) = save("surface paint (float gain = 2) { Ci = 4 * gain * emission (); }");
        assert!(matches!(told, News::Shaders(_)), "{told:?}");
        wait_for(&looker, "the new one with the knob's value", is_all(1.0));
        looker.tune((0, "gain".into(), ParameterValue::Floats(vec![0.5])));
        wait_for(&looker, "which the knob still turns", is_all(2.0));
        looker.tune((0, "no".into(), ParameterValue::Floats(vec![0.5])));
        assert!(news.iter().any(|news| matches!(news, News::Trouble(_))), "told");
        drop(wish);
    }
}
