// SPDX-License-Identifier: GPL-3.0-or-later
//! How a caller watches a picture grow and stops it. Source: original.

use crate::accumulation::Accumulation;

/// Told how far the picture is, and asked whether to go on. Called from many threads at once.
pub trait Progress: Sync {
    /// `done` in [0, 1] of all work, `samples` of the whole picture so far. Called after each tile.
    fn update(&self, done: f64, samples: u64) {
        let _ = (done, samples);
    }

    /// Called by one thread between passes, with the picture so far.
    fn passed(&self, picture: &Accumulation) {
        let _ = picture;
    }

    /// Whether to finish now and keep the picture so far. Asked between tiles and within them, many times a second.
    fn should_stop(&self) -> bool {
        false
    }
}

/// Nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {}
