// SPDX-License-Identifier: GPL-3.0-or-later
//! Long work in Python: another thread does it, while this one checks for Ctrl-C and reports the progress.
//! Tests: `tests/test_pictures.py::test_ctrl_c`.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use gnurt::render::Progress;
use pyo3::prelude::*;

/// Between two checks.
const PATIENCE: Duration = Duration::from_millis(40);

/// How far the work is, and whether it is to stop.
#[derive(Default)]
pub(crate) struct Watch {
    done: AtomicU64,
    stop: AtomicBool,
}

impl Progress for Watch {
    fn update(&self, done: f64, _samples: u64) {
        self.done.store(done.to_bits(), Ordering::Relaxed);
    }

    fn should_stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Runs the job. `progress` is called with a number from 0 to 1; its exceptions stop the job, as Ctrl-C does.
pub(crate) fn watched<R: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce(&Watch) -> PyResult<R> + Send,
) -> PyResult<R> {
    let watch = Watch::default();
    let (end, ended) = channel::<()>();
    let watch = &watch;
    std::thread::scope(|scope| {
        let worker = scope.spawn(move || {
            // Dropped at the end, also after a panic.
            let _end = end;
            job(watch)
        });
        let mut reported = 0.0;
        let mut failure = None;
        let (mut ended, mut is_over) = (ended, false);
        while !is_over {
            (ended, is_over) = py.detach(move || {
                let is_over = ended.recv_timeout(PATIENCE) != Err(RecvTimeoutError::Timeout);
                (ended, is_over)
            });
            let done = f64::from_bits(watch.done.load(Ordering::Relaxed)).clamp(0.0, 1.0);
            let report = |progress: &Bound<'_, PyAny>| progress.call1((done,)).map(drop);
            let is_news = done > reported;
            reported = reported.max(done);
            let result =
                py.check_signals().and_then(|()| progress.filter(|_| is_news).map_or(Ok(()), report));
            if let (Err(error), None) = (result, &failure) {
                watch.stop.store(true, Ordering::Relaxed);
                failure = Some(error);
            }
        }
        let result = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        failure.map_or(result, Err)
    })
}
