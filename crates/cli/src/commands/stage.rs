// SPDX-License-Identifier: GPL-3.0-or-later
//! A scene for `gnurt view`, committed, with its camera and exposure.

use gnurt::ThreadPool;
use gnurt::display_rules::meter;
use gnurt::render::RenderOptions;
use gnurt::simd::Level;
use gnurt_view::Stage;

use super::frame::{commit, commit_options};
use crate::arguments::{DisplayOptions, ExposureChoice, LightArguments, WindowArguments};
use crate::clips::clip;
use crate::failure::Failure;
use crate::messages::Messages;
use crate::shaders::{self, Shaders};
use crate::source::Source;
use crate::view::{self, Chosen};

/// Curve and exposure of all frames, and the note about them; the exposure is chosen once, from the first
/// view, unless it is given.
pub(super) fn show_view(
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
pub(super) fn prepare(
    source: &Source,
    arguments: &WindowArguments,
    level: Level,
    pool: &ThreadPool,
    messages: Messages,
) -> Result<(Stage, Chosen), Failure> {
    let (mut scene, mut files) = source.load_with_files(messages)?;
    let clip = clip(&scene, arguments.animation.as_deref())?;
    files.extend(arguments.view.surroundings.files());
    let shaders = Shaders::put_into(&mut scene, &arguments.frame, messages)?;
    let chosen = view::choose(
        &mut scene,
        &shaders.table,
        &arguments.view,
        arguments.frame.resolution,
        view::Stage::of(arguments.frame.integrator, true),
        messages,
    )?;
    view::tell_left_out(&scene, arguments.frame.integrator, messages);
    files.extend(shaders::other_files(&arguments.frame, &arguments.view));
    let how = commit_options(&arguments.frame, &arguments.trees, level);
    let (world, _) = commit(&scene, &shaders.table, how, pool, messages)?;
    let (scripts, others) = shaders.into_viewed(chosen.shader.as_ref());
    let faults = Box::new(move || others.new_faults());
    Ok((Stage { scene, world, files, clip, how, scripts, faults }, chosen))
}
