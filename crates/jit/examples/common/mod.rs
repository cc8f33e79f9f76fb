// SPDX-License-Identifier: GPL-3.0-or-later
//! Batches of points and the time that they take, for the examples that measure.

use std::time::Instant;

use gnurt_sl::exec::{Point, Points};

/// Points in batches.
pub(crate) fn batches(list: &[Point], lanes: usize) -> Vec<Points> {
    let batch = |list: &[Point]| {
        let mut points = Points { count: list.len(), ..Points::default() };
        list.iter().enumerate().for_each(|(lane, point)| points.set(lane, point));
        points
    };
    list.chunks(lanes).map(batch).collect()
}

/// The least time of some tries, in ns a point.
pub(crate) fn time(count: usize, mut run: impl FnMut()) -> f64 {
    run();
    let tries = (0..15).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64() * 1e9 / count as f64
    });
    tries.fold(f64::INFINITY, f64::min)
}
