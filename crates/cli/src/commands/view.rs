// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt view SCENE`: a window to fly through a scene; with `--headless` or `--display` frames without a window.
//! Tests: `tests/program/viewing.rs`, `tests/program/window.rs`.

use std::path::Path;

use gnurt::ThreadPool;
use gnurt::image::{Picture, PictureFormat};
use gnurt::simd::Level;
use gnurt_view::{Exposure, FrameTimes, HeadlessOptions, Rest, TevImage, ViewError, run_headless};
use serde_json::json;

use super::frame::frame_options;
use super::pictures;
use super::stage::{prepare, show_view};
use crate::arguments::{DisplayOptions, ExposureChoice, StatisticsForm, WindowArguments};
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::output::Output;
use crate::progress::Watcher;
use crate::shaders;
use crate::signals::{self, FirstSignal};
use crate::source::Source;
use crate::view;
use crate::workers::machine;

/// Shows a scene in a window.
pub(crate) fn run(arguments: &WindowArguments, environment: &Environment, messages: Messages) -> Outcome {
    if PictureFormat::is_named_any(Path::new(&arguments.scene)) {
        return pictures::run(arguments, environment, messages);
    }
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
    #[cfg(feature = "window")]
    let outcome = super::window::show_window(arguments, source, pool, level, messages);
    #[cfg(not(feature = "window"))]
    let outcome = Err(Failure::usage(
        "this program was compiled without windows. `cargo run --release --features window -- view ...` and \
         `cargo xtask install` compile them; --headless and --display do without",
    ));
    outcome
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
    let mut render = frame_options(&arguments.frame, level);
    render.integrator = render.integrator.without_pilot();
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
