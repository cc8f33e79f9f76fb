// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --band-rows N`: a picture larger than memory. Rows are rendered and written band by band, from above;
//! each band has the pixels of the whole picture. A stop leaves the rest transparent. Tests: `tests/program/bands.rs`.

use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::image::Picture;
use gnurt::render::{Accumulation, Progress, RenderOptions, RenderStats, render_on};

use super::frame::{self, Plan, Ready, appear, label, report, report_faults, suited_light};
use crate::arguments::{ExposureChoice, RenderArguments};
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::progress::Watcher;
use crate::signals;

/// Renders a scene that is ready, and writes the picture: at once, or in bands.
pub(super) fn make(
    arguments: &RenderArguments,
    begin: Instant,
    plan: &Plan,
    ready: &Ready,
    options: &RenderOptions,
    pool: &ThreadPool,
    messages: Messages,
) -> Outcome {
    let Some(rows) = plan.band_rows else {
        return frame::make(arguments, begin, plan, ready, options, pool, messages);
    };
    let output = &plan.targets.picture;
    let light = suited_light(arguments, ready, options);
    let exposure = match light.exposure {
        ExposureChoice::Stops(exposure) => exposure,
        // Only screens have one.
        ExposureChoice::Auto if !output.is_for_screens() => 0.0,
        ExposureChoice::Auto => {
            return Err(Failure::usage(
                "--band-rows: the exposure cannot be chosen from a picture that is never whole; give --exposure EV",
            ));
        }
    };
    let watcher = Watcher::begin(messages.shows_progress());
    let mut all = RenderStats { spp_min: u32::MAX, complete: true, ..RenderStats::default() };
    let mut fault = None;
    let mut make = |[top, end]: [u32; 2]| -> Option<Picture> {
        let options = RenderOptions { rows: Some([top, end]), ..options.clone() };
        let height = f64::from(options.height);
        let progress = BandProgress {
            all: &watcher,
            before: f64::from(top) / height,
            share: f64::from(end - top) / height,
            samples: all.samples,
        };
        let begun = Accumulation::new(options.clone()).map_err(|error| fault = Some(error)).ok()?;
        let rays = ready.motion.as_ref().map_or(&*ready.chosen.rays, |motion| &*motion.rays);
        let mut band = render_on(begun, &ready.world, rays, pool, &progress, None, &mut |_| {});
        all.add(&band.stats);
        all.spp_min = all.spp_min.min(band.stats.spp_min);
        all.spp_max = all.spp_max.max(band.stats.spp_max);
        all.seconds += band.stats.seconds;
        (all.threads, all.complete) = (band.stats.threads, all.complete && band.stats.complete);
        appear(&mut band.picture, (arguments, plan), ready, &options);
        // Its time is not known when the head of the file is written.
        label(&mut band.picture, None, plan, ready, &options);
        Some(band.picture)
    };
    let look = light.stops(exposure);
    let written = output.write_bands([options.width, options.height], rows, look, &mut make);
    watcher.end();
    let is_there = written?;
    if let Some(fault) = fault {
        return Err(Failure::usage(fault));
    }
    report_faults(&all, arguments, ready, messages);
    if is_there {
        messages.detail(format_args!("wrote {} in bands of {rows} rows", output.path().display()));
    }
    report(arguments, begin, plan, ready, options, &all, messages)
}

/// The progress of a band within that of the picture.
struct BandProgress<'a> {
    all: &'a Watcher,
    before: f64,
    share: f64,
    /// Samples of the bands before.
    samples: u64,
}

impl Progress for BandProgress<'_> {
    fn update(&self, done: f64, samples: u64) {
        self.all.update(self.before + done * self.share, self.samples + samples);
    }

    fn should_stop(&self) -> bool {
        self.all.should_stop() || signals::is_stopped()
    }
}
