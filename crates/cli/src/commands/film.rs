// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames of a film on their way through the filter over frames: a frame is written when those after it that it borrows
//! light from have been rendered. Memory: the frames of the window; a default window is made smaller until it fits.
//! Tests: `tests/program/film.rs`.

use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::denoise::film::Film;
use gnurt::memory::{fitting_reach, picture_bytes};
use gnurt::render::{Frame, RenderOptions, RenderStats};

use super::frame::{Plan, Ready, Targets, appear, label, render_frame, report, report_faults, save};
use crate::arguments::RenderArguments;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::signals;

/// What belongs to a frame that waits.
struct Waiting {
    targets: Targets,
    heatmap: Option<gnurt::image::Picture>,
    stats: RenderStats,
    options: RenderOptions,
    begin: Instant,
    is_wanted: bool,
}

/// The film of a call of `render --frames`.
pub(super) struct Filtered {
    film: Film<Waiting>,
}

/// Everything that the frames share.
pub(super) struct Shared<'a> {
    pub(super) arguments: &'a RenderArguments,
    pub(super) pool: &'a ThreadPool,
    pub(super) messages: Messages,
}

impl Filtered {
    /// The filter over frames, if these frames are to be filtered together.
    pub(super) fn new(
        arguments: &RenderArguments,
        plan: &Plan,
        options: &RenderOptions,
    ) -> Result<Option<Self>, Failure> {
        let Some(range) = arguments.times.frames.filter(|_| options.piece.is_none()) else { return Ok(None) };
        let Some(filter) = &plan.filter else { return Ok(None) };
        let size = [options.width, options.height];
        let (reach, is_given) = (arguments.times.reach(), arguments.times.is_window_given());
        let reach = fitting_reach(size, reach, picture_bytes(options, true), is_given)
            .map_err(|why| Failure::data(format_args!("--denoise-window {reach}: {why}")))?;
        let count = range.count();
        let is_film = reach > 0 && count > 1;
        Ok(is_film.then(|| Self { film: Film::new(filter.options.clone(), reach, count) }))
    }

    /// Whether frame `i` is needed for a frame that is wanted.
    pub(super) fn is_needed(&self, i: usize, is_wanted: &dyn Fn(usize) -> bool) -> bool {
        self.film.is_needed(i, is_wanted)
    }

    /// Renders frame `i`, and writes those that it completes.
    pub(super) fn add(
        &mut self,
        (i, is_wanted, begin): (usize, bool, Instant),
        plan: &mut Plan,
        ready: &Ready,
        options: &RenderOptions,
        shared: &Shared,
    ) -> Outcome {
        let Shared { arguments, pool, messages } = *shared;
        let Frame { mut picture, heatmap, stats } =
            render_frame(arguments, plan, ready, options, pool, messages)?;
        report_faults(&stats, arguments, ready, messages);
        if signals::is_stopped() {
            return Ok(());
        }
        label(&mut picture, Some(&stats), plan, ready, options);
        let targets = plan.targets.clone();
        let waiting = Waiting { targets, heatmap, stats, options: options.clone(), begin, is_wanted };
        let done = self.film.push(i, picture, waiting, pool).map_err(Failure::data)?;
        done.into_iter().try_for_each(|done| write(done, plan, ready, shared))
    }

    /// Writes the frames that are left.
    pub(super) fn finish(&mut self, plan: &mut Plan, ready: &Ready, shared: &Shared) -> Outcome {
        let done = self.film.finish(shared.pool).map_err(Failure::data)?;
        done.into_iter().try_for_each(|done| write(done, plan, ready, shared))
    }
}

fn write(
    (picture, waiting, used): (gnurt::image::Picture, Waiting, gnurt::denoise::Used),
    plan: &mut Plan,
    ready: &Ready,
    shared: &Shared,
) -> Outcome {
    let Shared { arguments, messages, .. } = *shared;
    let Waiting { targets, heatmap, stats, options, begin, is_wanted } = waiting;
    if !is_wanted {
        return Ok(());
    }
    let mut frame = Frame { picture, heatmap, stats };
    plan.targets = targets;
    plan.filter.iter().for_each(|filter| filter.report(&used, &mut frame.picture, messages));
    appear(&mut frame.picture, (arguments, plan), ready, &options);
    save(&frame, &plan.targets, ready, arguments, &options, messages)?;
    report(arguments, begin, plan, ready, &options, &frame.stats, messages)
}
