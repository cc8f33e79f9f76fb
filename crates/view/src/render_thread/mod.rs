// SPDX-License-Identifier: GPL-3.0-or-later
//! Interface to the viewer's render thread: requests in, images and events out. Its scheduling: `work.rs`.
//! Tests: `tests`, and `crates/cli/tests/program/window.rs`.

mod request;
mod work;

#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::JoinHandle;

use gnurt::ThreadPool;
use gnurt::denoise;
use gnurt::render::RenderOptions;

use crate::error::ViewError;
use crate::stage::{Loader, Stage};
pub(crate) use request::{DisplayFrame, RenderEvent, RenderRequest};
use request::{Pending, Shared, Tuned, lock};
use work::Work;

/// Renders in parallel with the window; stops when dropped.
pub(crate) struct RenderThread {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// The input of a render thread.
pub(crate) struct RenderThreadParts {
    pub(crate) stage: Stage,
    pub(crate) options: RenderOptions,
    pub(crate) pool: ThreadPool,
    pub(crate) loader: Loader,
    pub(crate) denoiser: denoise::Options,
    /// Called from the thread.
    pub(crate) notify: Box<dyn Fn(RenderEvent) + Send>,
}

impl RenderThread {
    /// Begins to render.
    pub(crate) fn begin(parts: RenderThreadParts, request: RenderRequest) -> Result<Self, ViewError> {
        let RenderThreadParts { stage, options, pool, loader, denoiser, notify } = parts;
        let shared = Arc::new(Shared {
            request: Mutex::new(Pending {
                request,
                view: 1,
                reload: false,
                file: None,
                changed: Vec::new(),
                tuned: Vec::new(),
            }),
            bell: Condvar::new(),
            view: AtomicU64::new(1),
            leaving: AtomicBool::new(false),
            front: Mutex::new(DisplayFrame::default()),
            stage: Mutex::new(Arc::new(stage)),
        });
        let work = Work::new(shared.clone(), pool, loader, notify, options, denoiser);
        let thread = std::thread::Builder::new().name("gnurt-looker".into()).spawn(move || work.run());
        Ok(Self { shared, thread: Some(thread.map_err(ViewError::Thread)?) })
    }

    /// Sets the view to render from now on.
    pub(crate) fn send_request(&self, request: &RenderRequest) {
        let mut pending = lock(&self.shared.request);
        if pending.request == *request {
            return;
        }
        let old = &pending.request;
        let key_of = |request: &RenderRequest| (request.shown, request.size, request.clip_time, request.clip);
        if old.camera != request.camera || key_of(old) != key_of(request) {
            pending.view += 1;
            self.shared.view.store(pending.view, Ordering::Relaxed);
        }
        pending.request.clone_from(request);
        self.shared.bell.notify_all();
    }

    /// Reads the scene again, or another one from a file.
    pub(crate) fn reload(&self, file: Option<PathBuf>) {
        let mut pending = lock(&self.shared.request);
        pending.reload = true;
        pending.file = file.or(pending.file.take());
        drop(pending);
        // The picture in work is not needed any more.
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// Reads shaders again that come from these files.
    pub(crate) fn read_again(&self, changed: Vec<PathBuf>) {
        lock(&self.shared.request).changed.extend(changed);
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// Gives a shader's parameter another value.
    pub(crate) fn tune(&self, tuned: Tuned) {
        let mut pending = lock(&self.shared.request);
        pending.tuned.retain(|(script, name, _)| (script, name) != (&tuned.0, &tuned.1));
        pending.tuned.push(tuned);
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// The latest picture. The thread waits while it is locked.
    pub(crate) fn front(&self) -> MutexGuard<'_, DisplayFrame> {
        lock(&self.shared.front)
    }

    /// Whether a picture satisfies the current request.
    pub(crate) fn is_current(&self, front: &DisplayFrame) -> bool {
        let pending = lock(&self.shared.request);
        let same = front.view == pending.view && front.exposure == pending.request.exposure;
        same && front.readings.denoised == pending.request.requests_denoising()
            && !pending.reload
            && !pending.has_edits()
    }

    /// The current stage.
    pub(crate) fn stage(&self) -> Arc<Stage> {
        lock(&self.shared.stage).clone()
    }
}

impl Drop for RenderThread {
    fn drop(&mut self) {
        self.shared.leaving.store(true, Ordering::Relaxed);
        drop(lock(&self.shared.request));
        self.shared.bell.notify_all();
        if let Some(thread) = self.thread.take() {
            // It has reported its panic already.
            let _ = thread.join();
        }
    }
}
