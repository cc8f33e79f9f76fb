// SPDX-License-Identifier: GPL-3.0-or-later
//! Progress and cancellation inside of a rendering. Callers implement `Progress` in `accumulation`.

/// Receives the progress of a picture, and may stop it. Called from many threads at once.
pub(crate) trait Watch: Sync {
    /// `done` in [0, 1] of all work, `samples` of the whole picture so far.
    fn update(&self, done: f64, samples: u64);

    /// Whether to finish now.
    fn should_stop(&self) -> bool;
}

/// Ignores progress and never stops.
pub(crate) struct Unwatched;

impl Watch for Unwatched {
    fn update(&self, _done: f64, _samples: u64) {}

    fn should_stop(&self) -> bool {
        false
    }
}
