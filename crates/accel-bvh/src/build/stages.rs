// SPDX-License-Identifier: GPL-3.0-or-later
//! How a build's work is shared out among its stages, for progress.
//! A step is the time to insert one primitive into a tree. Tests: `tests/control.rs`, and
//! `super::reinsert::tests`.

use super::reinsert::{self, QUICK, THOROUGH};
use gnurt_accel_core::Quality;
use gnurt_accel_core::control::Watch;

/// Nodes of a binary tree over ten primitives, about.
const NODES_PER_TEN: usize = 3;

/// The stages of a build in succession, as progress counts them.
pub(super) struct Stages<'a> {
    watch: &'a Watch<'a>,
    /// Steps that are done when each is over, the last one first.
    ends: Vec<usize>,
}

impl<'a> Stages<'a> {
    /// Over `count` primitives, then over `parts` of them, where that is tried.
    pub(super) fn new(watch: &'a Watch<'a>, quality: Quality, count: usize, parts: usize) -> Self {
        let moving = |count: usize, rounds| reinsert::steps(NODES_PER_TEN * count / 10, rounds);
        let mut steps = vec![count, moving(count, QUICK)];
        if parts > 0 {
            steps.extend([parts, moving(parts, QUICK)]);
        }
        let mut ends: Vec<usize> = steps
            .iter()
            .scan(0, |end, steps| {
                *end += steps;
                Some(*end)
            })
            .collect();
        let all = ends.last().copied().unwrap_or(0);
        let thorough = if quality == Quality::High { moving(count.max(parts), THOROUGH) } else { 0 };
        watch.start(all + thorough);
        ends.reverse();
        Self { watch, ends }
    }

    /// The next one is over.
    pub(super) fn end(&mut self) {
        if let Some(end) = self.ends.pop() {
            self.watch.advance_to(end);
        }
    }
}
