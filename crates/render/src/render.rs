// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures from worlds: tiles over a pool, in passes that double.
//! Invariant: the picture depends on world, camera, options and the samples taken, bit for bit; neither
//! on threads nor on passes. Tests: crates/render/tests/determinism.rs.

use std::time::{Duration, Instant};

use gnurt_shading::CameraShader;

use crate::accumulation::{Accumulation, Progress};
use crate::error::RenderError;
use crate::frame::Frame;
use crate::options::RenderOptions;
use crate::world::World;

/// Renders a picture of `world` seen by `camera` on the threads of `pool`.
///
/// # Errors
/// [`RenderError`] if the options leave nothing to render.
pub fn render(
    world: &World,
    camera: &dyn CameraShader,
    options: &RenderOptions,
    pool: &rayon::ThreadPool,
    progress: &dyn Progress,
) -> Result<Frame, RenderError> {
    let accumulation = Accumulation::new(options.clone())?;
    Ok(render_on(accumulation, world, camera, pool, progress, None, &mut |_| {}))
}

/// Continues a picture until it is complete, its time limit is over or `progress` stops it. Every `every`,
/// and at the end, it calls `at_rest` with the unchanging picture so far, which can be saved then.
pub fn render_on(
    mut accumulation: Accumulation,
    world: &World,
    camera: &dyn CameraShader,
    pool: &rayon::ThreadPool,
    progress: &dyn Progress,
    every: Option<Duration>,
    at_rest: &mut dyn FnMut(&Accumulation),
) -> Frame {
    let start = Instant::now();
    // A limit beyond the end of time is none.
    let deadline = accumulation.options().time_limit.and_then(|limit| start.checked_add(limit));
    accumulation.limit = deadline;
    let mut saved = start;
    while !accumulation.is_complete() {
        let save_at = every.and_then(|every| saved.checked_add(every));
        let until = [deadline, save_at].into_iter().flatten().min();
        let samples = next_pass(accumulation.samples());
        let whole = accumulation.pass_with(None, until, world, camera, samples, pool, progress);
        if save_at.is_some_and(|instant| Instant::now() >= instant) {
            at_rest(&accumulation);
            saved = Instant::now();
        }
        let is_over = progress.should_stop() || deadline.is_some_and(|end| Instant::now() >= end);
        if is_over || (!whole && save_at.is_none()) {
            break;
        }
    }
    at_rest(&accumulation);
    accumulation.into_frame(start)
}

/// Samples of the pass after `taken`: 1, 1, 2, 4, 8, 16, 16, ...: the first picture comes soon, later passes keep threads
/// busy.
fn next_pass(taken: u32) -> u32 {
    const MOST: u32 = 16;
    taken.clamp(1, MOST)
}
