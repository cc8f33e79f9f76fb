// SPDX-License-Identifier: GPL-3.0-or-later
//! The listener for errors, and its running calls: its replacement waits for them.
//! Invariant: after [`Listener::wait`] the function is not called any more, if no new [`Hearing`] is made.
//! Tests: tests/c/debug_threads.c, tests/exceptions.rs.

use std::ffi::CStr;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use super::error::Error;

/// Takes the error and the call with its arguments.
type Function = dyn Fn(Error, &CStr) + Send + Sync;

/// A program's function.
pub(crate) struct Listener {
    function: Box<Function>,
    /// Calls in progress or about to begin.
    hearings: Mutex<usize>,
    ended: Condvar,
}

/// The right to call a listener once: until it is dropped, waits for the listener block.
pub(crate) struct Hearing(Arc<Listener>);

impl Listener {
    pub(crate) fn new(function: impl Fn(Error, &CStr) + Send + Sync + 'static) -> Arc<Self> {
        Arc::new(Self { function: Box::new(function), hearings: Mutex::new(0), ended: Condvar::new() })
    }

    fn hearings(&self) -> MutexGuard<'_, usize> {
        self.hearings.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The right to call it.
    pub(crate) fn hearing(self: &Arc<Self>) -> Hearing {
        *self.hearings() += 1;
        Hearing(self.clone())
    }

    /// Waits until no call of it is in progress.
    pub(crate) fn wait(&self) {
        let mut hearings = self.hearings();
        while *hearings > 0 {
            hearings = self.ended.wait(hearings).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Hearing {
    /// Calls the listener.
    pub(crate) fn notify(&self, error: Error, call: &CStr) {
        (self.0.function)(error, call);
    }
}

impl Drop for Hearing {
    fn drop(&mut self) {
        *self.0.hearings() -= 1;
        self.0.ended.notify_all();
    }
}
