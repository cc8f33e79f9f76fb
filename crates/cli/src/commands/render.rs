// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render SCENE`: from a scene to a picture, or to the frames of an animation.
//! See docs/reference/cli.md. Tests: `tests/`.

use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::render::RenderOptions;

use super::bands::make;
use super::frame::{Plan, Ready, check, commit, commit_options, identify, options};
use super::{light_layers, times};
use crate::arguments::RenderArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::shaders::Shaders;
use crate::signals::{self, FirstSignal};
use crate::view::{self, Stage};
use crate::workers::machine;

/// Renders.
pub(crate) fn run(arguments: &RenderArguments, environment: &Environment, messages: Messages) -> Outcome {
    let begin = Instant::now();
    let plan = check(arguments, environment)?;
    let is_sequence = arguments.times.frames.is_some();
    signals::listen(if is_sequence { FirstSignal::Stops } else { FirstSignal::Saves }, messages)?;
    let (pool, level) = machine(&arguments.machine, environment)?;
    let options = options(arguments, &plan, level);
    let source = plan.source.clone();
    let outcome = if arguments.times.is_given() {
        times::run(arguments, plan, &options, &pool, messages)
    } else {
        let (ready, options) = prepare(arguments, &plan, &options, &pool, messages)?;
        make(arguments, begin, &plan, &ready, &options, &pool, messages)
    };
    source.warn_lost(messages);
    outcome
}

/// Reads the scene and builds its trees.
fn prepare(
    arguments: &RenderArguments,
    plan: &Plan,
    options: &RenderOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Result<(Ready, RenderOptions), Failure> {
    let begin = Instant::now();
    let (mut scene, files) = plan.source.load_with_files(messages)?;
    plan.targets.spare(files, arguments)?;
    // The joined picture may be for screens.
    let is_for_screens = plan.targets.picture.is_for_screens() || arguments.piece.is_some();
    let (frame, stage) = (&arguments.frame, Stage::of(options.integrator, is_for_screens));
    let shaders = Shaders::put_into(&mut scene, frame, messages)?;
    let chosen =
        view::choose(&mut scene, &shaders.table, &arguments.view, frame.resolution, stage, messages)?;
    view::tell_left_out(&scene, frame.integrator, messages);
    let load_time = begin.elapsed();
    let how = commit_options(frame, &arguments.trees, options.level).for_picture(&scene, options);
    let (world, report) = commit(&scene, &shaders.table, how, pool, messages)?;
    let (options, list) = light_layers::complete(options, arguments, &scene, messages);
    light_layers::check(&world, &scene, &options)?;
    let (print, checkpoint) = identify(arguments, &scene, &chosen, &(), &options);
    let ready = Ready {
        world,
        report,
        chosen,
        motion: None,
        poses: None,
        shaders,
        checkpoint,
        print,
        load_time,
        list,
        named: (!options.mattes.kinds.is_empty()).then(|| scene.clone()),
        light: None,
    };
    Ok((ready, options))
}
