// SPDX-License-Identifier: GPL-3.0-or-later
//! Options of `bench rays`.

use gnurt::simd::Level;

use crate::{Class, Filter};

/// The scenes to measure, and the method.
#[derive(Clone, Debug)]
pub struct Options {
    /// Classes of rays.
    pub classes: Vec<Class>,
    /// Which jobs.
    pub filter: Filter,
    /// Columns and rows of primary rays.
    pub size: u32,
    /// Runs of each job.
    pub rounds: usize,
    /// Rays per batch: the size of a call with more than one ray.
    pub batch: usize,
    /// Threads that trace, each bound to its own core where there are enough.
    pub threads: usize,
    /// Instruction set.
    pub level: Level,
    /// Share of the rays that may be hits for one engine only; ten times as many may be hits elsewhere.
    pub tolerance: f64,
}

impl Default for Options {
    /// All classes, the usual jobs, a million primary rays, five rounds, one thread, the best instructions.
    fn default() -> Self {
        Self {
            classes: Class::ALL.to_vec(),
            filter: Filter::default(),
            size: 1024,
            rounds: 5,
            batch: 4096,
            threads: 1,
            level: Level::best(),
            tolerance: 1e-5,
        }
    }
}
