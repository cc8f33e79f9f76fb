// SPDX-License-Identifier: GPL-3.0-or-later
//! What program and frame tell each other while the frame is in flight: cancel, and that it has landed.
//! Tests: tests/c/frames.c.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use gnurt::render::Progress;

/// Shared by a frame's thread and those who wait for it.
#[derive(Debug, Default)]
pub(crate) struct Flight {
    cancelled: AtomicBool,
    landed: Mutex<bool>,
    landing: Condvar,
}

impl Flight {
    /// Asks the frame to end early.
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

/// Tells those who wait when it is dropped, however the thread ends.
pub(crate) struct Landing(pub Arc<Flight>);

impl Drop for Landing {
    fn drop(&mut self) {
        *self.0.landed.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.landing.notify_all();
    }
}
