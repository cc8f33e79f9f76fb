// SPDX-License-Identifier: GPL-3.0-or-later
//! The thread that renders what the window wants to see, from outside: wishes in, pictures and news out. How it decides what to
//! render: `work.rs`. Tests: `tests`, and `crates/cli/tests/program/window.rs`.

mod wish;
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
pub(crate) use wish::{Front, News, Wish};
use wish::{Shared, Tuned, Wanted, lock};
use work::Work;

/// Renders beside the window; stops when dropped.
pub(crate) struct Looker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What a looker works with.
pub(crate) struct LookerParts {
    pub(crate) stage: Stage,
    pub(crate) options: RenderOptions,
    pub(crate) pool: ThreadPool,
    pub(crate) loader: Loader,
    pub(crate) denoiser: denoise::Options,
    /// Called from the thread.
    pub(crate) tell: Box<dyn Fn(News) + Send>,
}

impl Looker {
    /// Begins to look.
    pub(crate) fn begin(parts: LookerParts, wish: Wish) -> Result<Self, ViewError> {
        let LookerParts { stage, options, pool, loader, denoiser, tell } = parts;
        let shared = Arc::new(Shared {
            wish: Mutex::new(Wanted { wish, view: 1, reload: false, changed: Vec::new(), tuned: Vec::new() }),
            bell: Condvar::new(),
            view: AtomicU64::new(1),
            leaving: AtomicBool::new(false),
            front: Mutex::new(Front::default()),
            stage: Mutex::new(Arc::new(stage)),
        });
        let work = Work::new(shared.clone(), pool, loader, tell, options, denoiser);
        let thread = std::thread::Builder::new().name("gnurt-looker".into()).spawn(move || work.run());
        Ok(Self { shared, thread: Some(thread.map_err(ViewError::Thread)?) })
    }

    /// Wants to see this from now on.
    pub(crate) fn want(&self, wish: &Wish) {
        let mut wanted = lock(&self.shared.wish);
        if wanted.wish == *wish {
            return;
        }
        let old = &wanted.wish;
        let seen = |wish: &Wish| (wish.shown, wish.size, wish.moment);
        if old.camera != wish.camera || seen(old) != seen(wish) {
            wanted.view += 1;
            self.shared.view.store(wanted.view, Ordering::Relaxed);
        }
        wanted.wish.clone_from(wish);
        self.shared.bell.notify_all();
    }

    /// Reads the scene again.
    pub(crate) fn reload(&self) {
        lock(&self.shared.wish).reload = true;
        // Whatever is being rendered is of no interest any more.
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// Reads shaders again that come from these files.
    pub(crate) fn read_again(&self, changed: Vec<PathBuf>) {
        lock(&self.shared.wish).changed.extend(changed);
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// Gives a shader's parameter another value.
    pub(crate) fn tune(&self, tuned: Tuned) {
        let mut wanted = lock(&self.shared.wish);
        wanted.tuned.retain(|(script, name, _)| (script, name) != (&tuned.0, &tuned.1));
        wanted.tuned.push(tuned);
        self.shared.view.store(0, Ordering::Relaxed);
        self.shared.bell.notify_all();
    }

    /// The latest picture. The thread waits while somebody holds it.
    pub(crate) fn front(&self) -> MutexGuard<'_, Front> {
        lock(&self.shared.front)
    }

    /// Whether a picture shows what is wanted now.
    pub(crate) fn is_current(&self, front: &Front) -> bool {
        let wanted = lock(&self.shared.wish);
        let same = front.view == wanted.view && front.exposure == wanted.wish.exposure;
        same && front.readings.denoised == wanted.wish.wants_clean() && !wanted.reload && !wanted.has_edits()
    }

    /// What is looked at.
    pub(crate) fn stage(&self) -> Arc<Stage> {
        lock(&self.shared.stage).clone()
    }
}

impl Drop for Looker {
    fn drop(&mut self) {
        self.shared.leaving.store(true, Ordering::Relaxed);
        drop(lock(&self.shared.wish));
        self.shared.bell.notify_all();
        if let Some(thread) = self.thread.take() {
            // It has told about its panic already.
            let _ = thread.join();
        }
    }
}
