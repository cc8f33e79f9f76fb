// SPDX-License-Identifier: GPL-3.0-or-later
//! The progress of a rendering: a bar on a terminal, silence elsewhere, and the ear for signals.
//! The bar's contents follow pbrt (time passed and to go) and LuxCore (samples per second).

use std::time::{Duration, Instant};

use gnurt::render::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::signals::Rendering;

/// Steps of the bar.
const STEPS: u64 = 1000;
const TEMPLATE: &str = "rendering [{bar:32}] {percent:>3}%  {elapsed} | {eta} to go  {msg}";

/// A rendering as its watcher sees it.
#[derive(Debug)]
pub(crate) struct Watcher {
    bar: ProgressBar,
    begin: Instant,
    rendering: Rendering,
}

impl Watcher {
    /// Begins to watch; a bar is drawn only if it `is_seen`.
    pub(crate) fn begin(is_seen: bool) -> Self {
        let target =
            if is_seen { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
            bar.set_style(style.progress_chars("=> "));
        }
        if is_seen {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        Self { bar, begin: Instant::now(), rendering: Rendering::begin() }
    }

    /// Takes the bar away.
    pub(crate) fn end(self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Watcher {
    fn update(&self, done: f64, samples: u64) {
        if self.bar.is_hidden() {
            return;
        }
        let rate = samples as f64 / self.begin.elapsed().as_secs_f64().max(1e-3);
        self.bar.set_position((done.clamp(0.0, 1.0) * STEPS as f64) as u64);
        self.bar.set_message(format!("{:.2} Msamples/s", rate * 1e-6));
    }

    fn should_stop(&self) -> bool {
        self.rendering.should_stop()
    }
}
