// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt trace SCENE --pixel X,Y`: every arrow of the flow of ARCHITECTURE.md, for one pixel.
//! Tests: `tests/program/interface.rs`.

use gnurt::render::trace_pixel;

use super::frame::{commit, commit_options, frame_options};
use crate::arguments::TraceArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::shaders::{self, Shaders};
use crate::source::Source;
use crate::view::{self, Stage};
use crate::workers::machine;

/// Follows one pixel.
pub(crate) fn run(arguments: &TraceArguments, environment: &Environment, messages: Messages) -> Outcome {
    view::check(&arguments.view)?;
    shaders::check(&arguments.frame, &arguments.view)?;
    let (pixel, resolution) = (arguments.pixel, arguments.frame.resolution);
    if pixel.x >= resolution.width || pixel.y >= resolution.height {
        return Err(Failure::usage(format_args!(
            "--pixel '{},{}': outside the {resolution} picture; columns end at {}, rows at {}",
            pixel.x,
            pixel.y,
            resolution.width - 1,
            resolution.height - 1
        )));
    }
    let source = Source::find(&arguments.scene, &arguments.files, environment)?;
    let (pool, level) = machine(&arguments.machine, environment)?;
    let mut scene = source.load(messages)?;
    let shaders = Shaders::put_into(&mut scene, &arguments.frame, messages)?;
    let view::Chosen { rays, .. } = view::choose(
        &mut scene,
        &shaders.table,
        &arguments.view,
        resolution,
        Stage::of(arguments.frame.integrator, true),
        messages,
    )?;
    let how = commit_options(&arguments.frame, &arguments.trees, level);
    let (world, _) = commit(&scene, &shaders.table, how, &pool, messages)?;
    let options = frame_options(&arguments.frame, level);
    print(trace_pixel(&world, &*rays, &options, pixel.x, pixel.y).map_err(Failure::usage)?)
}
