// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt view SCENE`: a window to fly through a scene; with `--headless` or `--display` frames without a window.
//! Tests: `tests/program/viewing.rs`, `tests/program/window.rs`.

use std::path::PathBuf;
use std::sync::Arc;

use gnurt::ThreadPool;
use gnurt::display_rules::{is_noisy, meter};
use gnurt::image::Picture;
use gnurt::render::RenderOptions;
use gnurt::simd::Level;
use gnurt_view::{
    Exposure, FrameTimes, HeadlessOptions, Listener, Rest, Stage, TevImage, ViewError, WindowOptions,
    run_headless, run_window,
};
use serde_json::json;

use super::frame::{commit, commit_options, frame_options};
use crate::arguments::{DisplayOptions, ExposureChoice, LightArguments, StatisticsForm, WindowArguments};
use crate::clips::clip;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::output::Output;
use crate::progress::Watcher;
use crate::shaders::{self, Shaders};
use crate::signals::{self, FirstSignal};
use crate::source::Source;
use crate::view::{self, Chosen};
use crate::workers::machine;

/// Shows a scene in a window.
pub(crate) fn run(arguments: &WindowArguments, environment: &Environment, messages: Messages) -> Outcome {
    let windowless = arguments.headless || arguments.display.is_some();
    view::check(&arguments.view)?;
    shaders::check(&arguments.frame, &arguments.view)?;
    for (name, given) in [
        ("--orbit", arguments.orbit.is_some()),
        ("--output", arguments.output.is_some()),
        ("--rest", arguments.rest.is_some()),
        ("--stats", arguments.stats.is_some()),
    ] {
        if given && !windowless {
            return Err(Failure::usage(format_args!(
                "{name} is for frames without a window; give --headless, too"
            )));
        }
    }
    let output = arguments.output.as_deref().map(Output::named).transpose()?;
    let source = Source::find(&arguments.scene, &arguments.files, environment)?;
    output.iter().try_for_each(Output::check)?;
    let (pool, level) = machine(&arguments.machine, environment)?;
    if windowless {
        let outcome = run_windowless(arguments, &source, output.as_ref(), &pool, level, messages);
        source.warn_lost(messages);
        return outcome;
    }
    signals::listen(FirstSignal::Leaves, messages)?;
    let (stage, chosen) = prepare(&source, arguments, level, &pool, messages)?;
    let render = frame_options(&arguments.frame, level);
    let (show_view, note) = show_view(arguments.light, &stage, &chosen, &render, &pool)?;
    let options = WindowOptions {
        camera: chosen.camera,
        exposure: Exposure { stops: show_view.exposure, tone: show_view.tone },
        title: format!("{} - GNU RT", source.stem()),
        frames: arguments.frames.map(u64::from),
        folder: PathBuf::from("."),
        denoiser: arguments.denoiser.options_or_built_in(None).unwrap_or_default(),
        note,
        is_denoised: arguments.denoiser.options_or_built_in(None).is_some() && is_noisy(render.integrator, 1),
        render,
    };
    let again = (source, arguments.clone());
    let loader = Box::new(move |pool: &ThreadPool| {
        let (source, arguments) = &again;
        let stage = prepare(source, arguments, level, pool, messages).map(|(stage, _)| stage);
        stage.map_err(|failure| failure.message().unwrap_or("it cannot be read").to_owned())
    });
    run_window(options, stage, pool, loader, Arc::new(Speaker { messages })).map_err(Failure::data)
}

/// Curve and exposure of all frames, and the note about them; the exposure is chosen once, from the first
/// view, unless it is given.
fn show_view(
    light: LightArguments,
    stage: &Stage,
    chosen: &Chosen,
    options: &RenderOptions,
    pool: &ThreadPool,
) -> Result<(DisplayOptions, Option<String>), Failure> {
    let light = light.suited(chosen.exposure_of(options.integrator));
    Ok(match light.exposure {
        ExposureChoice::Stops(exposure) => {
            (DisplayOptions { tone: light.tone, exposure, file: light.file }, None)
        }
        ExposureChoice::Auto => {
            light.chosen(meter(&stage.world, &*chosen.rays, options, pool).map_err(Failure::usage)?)
        }
    })
}

/// The scene, committed, and the camera that shows it.
fn prepare(
    source: &Source,
    arguments: &WindowArguments,
    level: Level,
    pool: &ThreadPool,
    messages: Messages,
) -> Result<(Stage, Chosen), Failure> {
    let (mut scene, mut files) = source.load_with_files(messages)?;
    let clip = clip(&scene, arguments.animation.as_deref())?;
    files.extend(arguments.view.surroundings.file().map(PathBuf::from));
    let shaders = Shaders::put_into(&mut scene, &arguments.frame, messages)?;
    let chosen = view::choose(
        &mut scene,
        &shaders.table,
        &arguments.view,
        arguments.frame.resolution,
        view::Stage::of(arguments.frame.integrator, true),
        messages,
    )?;
    files.extend(shaders::other_files(&arguments.frame, &arguments.view));
    let how = commit_options(&arguments.frame, &arguments.trees, level);
    let (world, _) = commit(&scene, &shaders.table, how, pool, messages)?;
    let (scripts, others) = shaders.into_viewed(chosen.shader.as_ref());
    let faults = Box::new(move || others.new_faults());
    Ok((Stage { scene, world, files, clip, how, scripts, faults }, chosen))
}

fn run_windowless(
    arguments: &WindowArguments,
    source: &Source,
    output: Option<&Output>,
    pool: &ThreadPool,
    level: Level,
    messages: Messages,
) -> Outcome {
    signals::listen(FirstSignal::Saves, messages)?;
    let (stage, chosen) = prepare(source, arguments, level, pool, messages)?;
    output.iter().try_for_each(|output| output.spare(&stage.files))?;
    let resolution = arguments.frame.resolution;
    let size = [resolution.width, resolution.height];
    let address = arguments.display.as_ref();
    let mut tev = address
        .map(|address| TevImage::create(address, &source.name(), size))
        .transpose()
        .map_err(Failure::data)?;
    let frames = arguments.frames.unwrap_or(1);
    let render = frame_options(&arguments.frame, level);
    // Frames that are not saved need no good exposure.
    let is_kept = output.is_some_and(Output::is_for_screens);
    let (show_view, note) = match arguments.light.exposure {
        ExposureChoice::Auto if !is_kept => {
            (DisplayOptions { tone: arguments.light.tone, exposure: 0.0, file: arguments.light.file }, None)
        }
        _ => show_view(arguments.light, &stage, &chosen, &render, pool)?,
    };
    note.iter().for_each(|note| messages.note(note));
    let options = HeadlessOptions {
        render,
        camera: chosen.camera,
        exposure: Exposure { stops: show_view.exposure, tone: show_view.tone },
        frames,
        orbit: arguments.orbit.unwrap_or(if frames > 1 { 360.0 } else { 0.0 }),
        rest: arguments.rest.unwrap_or(0),
    };
    let watcher = Watcher::begin(false);
    let mut last: Option<Picture> = None;
    let times = run_headless(&options, &stage, pool, &watcher, &mut |number, frame| {
        if output.is_some() && (number + 1 == options.frames + options.rest || signals::is_stopped()) {
            last = Some(frame.picture().clone());
        }
        tev.as_mut().map_or(Ok(()), |tev| tev.update(frame.picture()))
    });
    watcher.end();
    stage.all_faults().iter().for_each(|fault| messages.warning(fault));
    let times = times.map_err(|error| match error {
        ViewError::NoView | ViewError::Render(_) => Failure::usage(error),
        _ => Failure::data(error),
    })?;
    if let (Some(output), Some(mut picture)) = (output, last) {
        // On a screen the background is part of the picture.
        picture.make_opaque(None);
        output.write(&picture, show_view)?;
    }
    report(&times, arguments, &options, source, messages)
}

/// How fast it was.
fn report(
    times: &FrameTimes,
    arguments: &WindowArguments,
    options: &HeadlessOptions,
    source: &Source,
    messages: Messages,
) -> Outcome {
    let milliseconds = [0.0, 0.5, 0.95, 1.0].map(|share| times.percentile(share) * 1e3);
    let rays_per_second = times.rays as f64 / times.total().max(1e-9);
    let frames = times.seconds.len();
    let mut text = format!(
        "{frames} frames of {} by {}: {:.2} fps, {:.2} ms (median {:.2}, longest {:.2}), {:.2} million rays per second on {} threads",
        arguments.frame.resolution,
        arguments.frame.integrator,
        times.fps(),
        times.total() * 1e3 / (frames as f64).max(1.0),
        milliseconds[1],
        milliseconds[3],
        rays_per_second * 1e-6,
        times.threads
    );
    if let Some(Rest { pictures, samples, most, mean }) = times.rest {
        text += &format!(
            "; at rest {pictures} pictures up to {samples} samples, blocks change by {:.2} % at most, {:.3} % in the mean",
            most * 100.0,
            mean * 100.0
        );
    }
    match arguments.stats {
        Some(StatisticsForm::Json) => print(json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": source.name(),
            "width": options.render.width,
            "height": options.render.height,
            "integrator": options.render.integrator.name(),
            "spp": options.render.spp,
            "isa": options.render.level.name(),
            "threads": times.threads,
            "frames": frames,
            "orbit_degrees": options.orbit,
            "seconds": times.total(),
            "fps": times.fps(),
            "ms": {
                "mean": times.total() * 1e3 / (frames as f64).max(1.0),
                "min": milliseconds[0],
                "median": milliseconds[1],
                "p95": milliseconds[2],
                "max": milliseconds[3],
            },
            "rays": times.rays,
            "rays_per_second": rays_per_second,
            "rest": times.rest.map(|rest| json!({
                "pictures": rest.pictures,
                "spp": rest.samples,
                "flicker": { "max": rest.most, "mean": rest.mean },
            })),
        })),
        Some(StatisticsForm::Table) => {
            messages.table(text);
            Ok(())
        }
        None => {
            messages.note(text);
            Ok(())
        }
    }
}

/// Prints the window's messages as the program's.
struct Speaker {
    messages: Messages,
}

impl Listener for Speaker {
    fn camera(&self, options: &str) {
        // A closed standard output is ignored.
        let _ = print(options);
    }

    fn note(&self, text: &str) {
        self.messages.note(text);
    }

    fn warning(&self, text: &str) {
        self.messages.warning(text);
    }
}
