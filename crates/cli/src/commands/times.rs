// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --at` and `--frames`: times of an animation, or files of a sequence. A frame depends only on
//! the scene, its time and its number, which is added to the seed: noise that stays in place looks like a dirty
//! window. So frame f has the pixels, bit for bit, that `--at` gives under that seed. Default camera, lights and exposure come from data available to every call: the clip's first time and bounds, or
//! the first existing file of a sequence.
//! Tests: `tests/program/animation.rs`.

use std::time::{Duration, Instant};

use gnurt::defaults::{Added, Bounds, Stock, bounds_over};
use gnurt::display_rules::meter;
use gnurt::render::{RenderOptions, World};
use gnurt::scene::Scene;
use gnurt::scene::animation::Exposure;
use gnurt::{FramePose, ThreadPool};

use super::bands::make;
use super::film::{Filtered, Shared};
use super::frame::{Plan, Poses, Ready, Targets, commit_into, commit_options, identify};
use super::light_layers;
use crate::arguments::value::FrameRange;
use crate::arguments::{ExposureChoice, LightArguments, RenderArguments, TimeArguments};
use crate::clips::clip;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::shaders::Shaders;
use crate::signals;
use crate::source::Source;
use crate::view::{self, Chosen, Stage};

/// One rendered frame.
struct Frame {
    number: u32,
    seconds: f64,
    targets: Targets,
    /// Whether it is to be written: others are only borrowed from.
    is_wanted: bool,
}

/// The first scene of a sequence, its view, and its defaults.
struct First {
    scene: Scene,
    shaders: Shaders,
    chosen: Chosen,
    added: Added,
}

/// Everything that frames share.
struct Studio<'a> {
    arguments: &'a RenderArguments,
    options: &'a RenderOptions,
    pool: &'a ThreadPool,
    /// Whether curve and exposure show, or may.
    is_for_screens: bool,
    messages: Messages,
}

/// Renders the requested times.
pub(super) fn run(
    arguments: &RenderArguments,
    mut plan: Plan,
    options: &RenderOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Outcome {
    let targets = plan.targets.clone();
    let mut pending = frames(&arguments.times, &targets).filter(|frame| frame.is_wanted).peekable();
    if pending.peek().is_none() {
        messages.note("all frames are there already");
        return Ok(());
    }
    // The joined picture may be for screens.
    let is_for_screens = targets.picture.is_for_screens() || arguments.piece.is_some();
    let studio = Studio { arguments, options, pool, is_for_screens, messages };
    match plan.source.numbered().cloned() {
        Some(numbered) => {
            let all = plan.source.clone();
            let first = all.at(numbered.first().ok().flatten().unwrap_or(0));
            studio.files(&mut plan, &first, &|number, _| all.at(number), pending)
        }
        None => studio.clip(&mut plan, pending, &targets),
    }
}

/// The frames, each made when it is needed: there may be many.
fn frames<'a>(times: &'a TimeArguments, targets: &'a Targets) -> impl Iterator<Item = Frame> + 'a {
    let range = times.frames.map(FrameRange::numbers);
    let one = times.at.map(|seconds| Frame {
        number: times.frame_at(seconds),
        seconds,
        targets: targets.clone(),
        is_wanted: true,
    });
    let all = range.into_iter().flatten().map(move |number| frame_of(times, number, targets));
    one.into_iter().chain(all)
}

/// A frame of `--frames`.
fn frame_of(times: &TimeArguments, number: u32, targets: &Targets) -> Frame {
    let targets = Targets {
        picture: targets.picture.at(number),
        heatmap: targets.heatmap.as_ref().map(|heatmap| heatmap.at(number)),
    };
    let is_wanted = !times.skip_existing || !is_done(&targets);
    Frame { number, seconds: times.seconds(number), targets, is_wanted }
}

fn is_done(targets: &Targets) -> bool {
    let is_there = |output: &crate::output::Output| output.path().exists();
    is_there(&targets.picture) && targets.heatmap.as_ref().is_none_or(is_there)
}

impl Studio<'_> {
    /// Times of a clip of one scene, which is read once.
    fn clip(&self, plan: &mut Plan, frames: impl Iterator<Item = Frame>, all: &Targets) -> Outcome {
        let begin = Instant::now();
        let (mut scene, files) = plan.source.load_with_files(self.messages)?;
        if let (Some([first, _]), None) = (scene.labels().times, scene.animation()) {
            let all = plan.source.clone();
            return self.files(plan, &all.at_moment(first), &|_, seconds| all.at_moment(seconds), frames);
        }
        let clip = clip(&scene, self.arguments.times.animation.as_deref())?;
        let Some(clip) = clip else {
            return Err(Failure::usage(format_args!(
                "{}: the scene has no animation; leave out --at and --frames",
                plan.source.name()
            )));
        };
        let bounds = bounds_over(&mut scene, clip);
        let shaders = Shaders::put_into(&mut scene, &self.arguments.frame, self.messages)?;
        let chosen = self.choose(&mut scene, &shaders, bounds)?;
        view::tell_left_out(&scene, self.options.integrator, self.messages);
        let mut world = World::new();
        let light = self.light(&scene, &chosen, &shaders, &mut world)?;
        let mut ready = self.ready(world, chosen, shaders, light, begin.elapsed());
        let mut is_reported = false;
        let mut film = Filtered::new(self.arguments, plan, self.options)?;
        let frames: Box<dyn Iterator<Item = Frame>> = match (&film, self.arguments.times.frames) {
            (Some(_), Some(range)) => {
                let times = &self.arguments.times;
                Box::new((0..range.count()).map(move |i| frame_of(times, range.number(i), all)))
            }
            _ => Box::new(frames),
        };
        for frame in frames {
            if !self.is_needed(film.as_ref(), &frame, all) {
                continue;
            }
            frame.targets.spare(files.clone(), self.arguments)?;
            let begin = Instant::now();
            let around = self.around(&mut scene, clip, &frame, &ready)?;
            let closes = self.arguments.times.closes(frame.seconds);
            let exposure = scene.expose(clip, frame.seconds, closes);
            ready.poses = match around {
                Some([before, after]) => Some(Poses { now: self.pose(&scene, &ready)?, before, after }),
                None => None,
            };
            self.warn_held(&exposure, &mut is_reported);
            self.make(plan, &mut ready, (&scene, &exposure), frame, begin, film.as_mut())?;
            if signals::is_stopped() {
                return Ok(());
            }
        }
        match &mut film {
            Some(film) => film.finish(plan, &ready, &self.shared()),
            None => Ok(()),
        }
    }

    fn shared(&self) -> Shared<'_> {
        Shared { arguments: self.arguments, pool: self.pool, messages: self.messages }
    }

    /// Whether a frame is to be written, or one is that borrows from it.
    fn is_needed(&self, film: Option<&Filtered>, frame: &Frame, all: &Targets) -> bool {
        let (Some(film), Some(range)) = (film, self.arguments.times.frames) else { return frame.is_wanted };
        let is_wanted = |i: usize| frame_of(&self.arguments.times, range.number(i), all).is_wanted;
        film.is_needed(range.index(frame.number), &is_wanted)
    }

    /// The frames before and after one of a film with layers, if there are any; leaves the scene at one of them.
    fn around(
        &self,
        scene: &mut Scene,
        clip: usize,
        frame: &Frame,
        ready: &Ready,
    ) -> Result<Option<[Option<FramePose>; 2]>, Failure> {
        let Some(range) = self.arguments.times.frames else { return Ok(None) };
        if !self.options.aovs || self.options.piece.is_some() {
            return Ok(None);
        }
        let i = range.index(frame.number);
        let mut at = |i: Option<usize>| {
            let Some(i) = i.filter(|&i| i < range.count()) else { return Ok(None) };
            scene.pose(clip, self.arguments.times.seconds(range.number(i)));
            self.pose(scene, ready).map(Some)
        };
        Ok(Some([at(i.checked_sub(1))?, at(Some(i + 1))?]))
    }

    fn pose(&self, scene: &Scene, ready: &Ready) -> Result<FramePose, Failure> {
        let (view, resolution) = (&self.arguments.view, self.arguments.frame.resolution);
        let (camera, _) = view::aim(scene, view, ready.chosen.shader.as_ref(), resolution)?;
        Ok(FramePose::of(scene, &camera))
    }

    /// Files of a sequence, each of which may have a clip of its own, or moments that a file is read at. `at`: the source of a number and a
    /// moment.
    fn files(
        &self,
        plan: &mut Plan,
        first: &Source,
        at: &dyn Fn(u32, f64) -> Source,
        frames: impl Iterator<Item = Frame>,
    ) -> Outcome {
        let begin = Instant::now();
        let First { scene, shaders: of_first, chosen, added } = self.first(first)?;
        let mut light = None;
        for frame in frames {
            let begin = Instant::now();
            let source = at(frame.number, frame.seconds);
            let (mut next, files) = source.load_with_files(self.messages)?;
            frame.targets.spare(files, self.arguments)?;
            if let Some(clip) = clip(&next, self.arguments.times.animation.as_deref())? {
                next.pose(clip, frame.seconds);
            }
            let shaders = Shaders::put_into(&mut next, &self.arguments.frame, self.messages)?;
            added.add_to(&mut next);
            let light = match light {
                Some(light) => light,
                None => *light.insert(self.light(&scene, &chosen, &of_first, &mut World::new())?),
            };
            let mut ready = self.ready(World::new(), chosen.clone(), shaders, light, begin.elapsed());
            let exposure = self.exposure(&next, at, &frame, &added)?;
            plan.source = source;
            self.make(plan, &mut ready, (&next, &exposure), frame, begin, None)?;
            if signals::is_stopped() {
                break;
            }
        }
        self.messages.detail(format_args!("the sequence took {:.2} s", begin.elapsed().as_secs_f64()));
        Ok(())
    }

    /// What moves while the shutter is open, of a file that is read at moments.
    fn exposure(
        &self,
        opens: &Scene,
        at: &dyn Fn(u32, f64) -> Source,
        frame: &Frame,
        added: &Added,
    ) -> Result<Exposure, Failure> {
        const PIECES: u32 = 4;
        if !self.arguments.times.is_open() {
            return Ok(Exposure::default());
        }
        let closes = self.arguments.times.closes(frame.seconds);
        let moment = |i: u32| frame.seconds + (closes - frame.seconds) * f64::from(i) / f64::from(PIECES);
        let later = (1..=PIECES).map(|i| {
            let mut scene = at(frame.number, moment(i)).load(self.messages.silent())?;
            added.add_to(&mut scene);
            Ok::<Scene, Failure>(scene)
        });
        let later = later.collect::<Result<Vec<_>, Failure>>()?;
        let times: Vec<&Scene> = std::iter::once(opens).chain(&later).collect();
        let exposure = Exposure::between(&times);
        self.warn_held(&exposure, &mut false);
        Ok(exposure)
    }

    /// Reads the first scene of a sequence.
    fn first(&self, source: &Source) -> Result<First, Failure> {
        // Its warnings are printed when it is rendered.
        let mut scene = source.load(self.messages.silent())?;
        let bounds = clip(&scene, self.arguments.times.animation.as_deref())?
            .and_then(|clip| bounds_over(&mut scene, clip));
        let stock = Stock::of(&scene);
        let shaders = Shaders::put_into(&mut scene, &self.arguments.frame, self.messages.silent())?;
        let chosen = self.choose(&mut scene, &shaders, bounds)?;
        let added = stock.added_to(&scene);
        Ok(First { scene, shaders, chosen, added })
    }

    fn choose(
        &self,
        scene: &mut Scene,
        shaders: &Shaders,
        bounds: Option<Bounds>,
    ) -> Result<Chosen, Failure> {
        let stage = Stage::of(self.options.integrator, self.is_for_screens);
        let resolution = self.arguments.frame.resolution;
        view::choose_around(
            scene,
            &shaders.table,
            bounds,
            &self.arguments.view,
            resolution,
            stage,
            self.messages,
        )
    }

    /// Curve and exposure of all frames: the exposure is measured at the first time, if none is given and it
    /// has an effect.
    fn light(
        &self,
        scene: &Scene,
        chosen: &Chosen,
        shaders: &Shaders,
        world: &mut World,
    ) -> Result<LightArguments, Failure> {
        let light = self.arguments.light.suited(chosen.exposure_of(self.options.integrator));
        if light.exposure != ExposureChoice::Auto || !self.is_for_screens {
            return Ok(light);
        }
        let how = commit_options(&self.arguments.frame, &self.arguments.trees, self.options.level);
        let still = Exposure::default();
        commit_into(world, (scene, &still), &shaders.table, how, self.pool, self.messages)?;
        let measured = meter(world, &*chosen.rays, self.options, self.pool).map_err(Failure::usage)?;
        let (display_rules, note) = light.chosen(measured);
        note.iter().for_each(|note| self.messages.note(note));
        Ok(LightArguments { exposure: ExposureChoice::Stops(display_rules.exposure), ..light })
    }

    fn ready(
        &self,
        world: World,
        chosen: Chosen,
        shaders: Shaders,
        light: LightArguments,
        load_time: Duration,
    ) -> Ready {
        let report = gnurt::render::CommitReport::default();
        Ready {
            world,
            report,
            chosen,
            motion: None,
            poses: None,
            shaders,
            checkpoint: None,
            print: 0,
            load_time,
            list: None,
            named: None,
            light: Some(light),
        }
    }

    /// Warns once about motion that an open shutter does not blur.
    fn warn_held(&self, exposure: &Exposure, is_reported: &mut bool) {
        if exposure.held > 0 && !std::mem::replace(is_reported, true) {
            self.messages.warning(format_args!(
                "{} materials or instances change or come and go while the shutter is open; they stay as they are when it opens",
                exposure.held
            ));
        }
    }

    /// The seed of a frame of `--frames`; a moment of `--at` has the given one.
    fn seed(&self, number: u32) -> u64 {
        let added = self.arguments.times.frames.map_or(0, |_| u64::from(number));
        self.options.seed.wrapping_add(added)
    }

    /// Renders one frame of a scene that shows it.
    fn make(
        &self,
        plan: &mut Plan,
        ready: &mut Ready,
        (scene, exposure): (&Scene, &Exposure),
        frame: Frame,
        begin: Instant,
        film: Option<&mut Filtered>,
    ) -> Outcome {
        let how = commit_options(&self.arguments.frame, &self.arguments.trees, self.options.level);
        let (pool, messages) = (self.pool, self.messages);
        let (view, resolution) = (&self.arguments.view, self.arguments.frame.resolution);
        let shader = ready.chosen.shader.as_ref();
        let aimed = view::aim(scene, view, shader, resolution)?;
        ready.motion = view::motion(scene, exposure, view, shader, resolution)?;
        (ready.chosen.camera, ready.chosen.rays) = aimed;
        let shown = (scene, exposure);
        ready.report = commit_into(&mut ready.world, shown, &ready.shaders.table, how, pool, messages)?;
        let closes = self.arguments.times.closes(frame.seconds);
        let keys = ready.motion.as_ref().map(|motion| &motion.keys);
        let open = (keys, &exposure.instances, &exposure.lights, exposure.meshes.len(), closes);
        let (options, list) = light_layers::complete(self.options, self.arguments, scene, messages);
        ready.list = list;
        light_layers::check(&ready.world, scene, &options)?;
        let options = RenderOptions { seed: self.seed(frame.number), ..options };
        (ready.print, ready.checkpoint) = identify(self.arguments, scene, &ready.chosen, &open, &options);
        ready.named = (!options.mattes.kinds.is_empty()).then(|| scene.clone());
        plan.targets = frame.targets;
        match (film, self.arguments.times.frames) {
            (Some(film), Some(range)) => {
                let which = (range.index(frame.number), frame.is_wanted, begin);
                film.add(which, plan, ready, &options, &self.shared())
            }
            _ => make(self.arguments, begin, plan, ready, &options, pool, messages),
        }
    }
}
