// SPDX-License-Identifier: GPL-3.0-or-later
//! The state that program and frame share while the frame is in flight: cancellation, and completion.
//! Tests: tests/c/frames.c.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use gnurt::render::Progress;

/// Shared by a frame's thread and its waiting threads.
#[derive(Debug, Default)]
pub(crate) struct Flight {
    cancelled: AtomicBool,
    landed: Mutex<bool>,
    landing: Condvar,
}

impl Flight {
    /// Requests the frame to end early.
    pub(crate) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Waits until the frame's thread has nothing more to do.
    pub(crate) fn wait(&self) {
        let mut landed = self.landed.lock().unwrap_or_else(PoisonError::into_inner);
        while !*landed {
            landed = self.landing.wait(landed).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Progress for Flight {
    fn should_stop(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Wakes the waiting threads when dropped, however the thread ends.
pub(crate) struct Landing(pub Arc<Flight>);

impl Drop for Landing {
    fn drop(&mut self) {
        *self.0.landed.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.landing.notify_all();
    }
}
