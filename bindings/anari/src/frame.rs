// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames: one rendering at a time on a thread of its own, its pictures, and the threads that wait for them.
//! A rendering shows the parameters committed when it was started. Pictures that the program maps stay until it unmaps them.
//! Tests: tests/frames.rs.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{JoinHandle, ThreadId};

use crate::object::{Object, lock};
use crate::output::Output;
use crate::picture::Growing;

#[derive(Default)]
struct State {
    /// The thread that renders, until it has called the program's function.
    running: Option<ThreadId>,
    /// Whether the picture is there, though the function may still run.
    has_ended: bool,
    handle: Option<JoinHandle<()>>,
    output: Arc<Output>,
    /// By channel.
    mapped: Vec<(String, Arc<Output>)>,
}

/// A frame's payload.
#[derive(Default)]
pub(crate) struct Frame {
    state: Mutex<State>,
    changed: Condvar,
    pub(crate) stop: Arc<AtomicBool>,
    /// State that grows from frame to frame.
    pub(crate) growing: Mutex<Option<Growing>>,
}

impl Frame {
    /// The frame that an object is.
    pub(crate) fn of(object: &Object) -> Option<&Self> {
        object.payload.downcast_ref()
    }

    /// Waits until nothing renders; at once where the rendering's own thread asks.
    pub(crate) fn wait(&self) {
        let mut state = lock(&self.state);
        let me = std::thread::current().id();
        while state.running.is_some_and(|thread| thread != me) {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let handle = if state.running.is_none() { state.handle.take() } else { None };
        drop(state);
        // Ended already, but for its last instructions.
        if let Some(handle) = handle {
            drop(handle.join());
        }
    }

    /// Whether a picture is there, or nothing was started.
    pub(crate) fn is_ready(&self) -> bool {
        let state = lock(&self.state);
        state.running.is_none() || state.has_ended
    }

    /// Starts `work` on a thread, after the running work has ended; an error in words where the system has no thread.
    pub(crate) fn start(&self, work: impl FnOnce() + Send + 'static) -> Result<(), String> {
        self.wait();
        self.stop.store(false, Ordering::Relaxed);
        let mut state = lock(&self.state);
        if state.running.is_some() {
            return Err("a frame cannot be rendered by its own completion callback".into());
        }
        let builder = std::thread::Builder::new().name("gnurt-frame".into()).stack_size(16 << 20);
        let handle = builder.spawn(work).map_err(|error| format!("no thread: {error}"))?;
        state.running = Some(handle.thread().id());
        state.has_ended = false;
        state.handle = Some(handle);
        Ok(())
    }

    /// Says that the picture is there; `None` leaves the one before.
    pub(crate) fn put(&self, output: Option<Output>) {
        let mut state = lock(&self.state);
        if let Some(output) = output {
            state.output = Arc::new(output);
        }
        state.has_ended = true;
        drop(state);
        self.changed.notify_all();
    }

    /// Says that the rendering's thread is done.
    pub(crate) fn finish(&self) {
        let mut state = lock(&self.state);
        state.running = None;
        state.has_ended = true;
        drop(state);
        self.changed.notify_all();
    }

    /// The last picture.
    pub(crate) fn output(&self) -> Arc<Output> {
        lock(&self.state).output.clone()
    }

    /// The last picture, kept until [`unmap`](Self::unmap).
    pub(crate) fn map(&self, channel: &str) -> Arc<Output> {
        let mut state = lock(&self.state);
        let output = state.output.clone();
        state.mapped.push((channel.to_owned(), output.clone()));
        output
    }

    /// Lets a mapped picture go.
    pub(crate) fn unmap(&self, channel: &str) {
        let mut state = lock(&self.state);
        let index = state.mapped.iter().position(|(name, _)| name == channel);
        let gone = index.map(|index| state.mapped.swap_remove(index));
        drop(state);
        drop(gone);
    }

    /// Stops the rendering.
    pub(crate) fn discard(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
