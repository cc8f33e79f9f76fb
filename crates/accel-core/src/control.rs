// SPDX-License-Identifier: GPL-3.0-or-later
//! Control of a running build by the program, and its progress. Only large memory is counted: allocations
//! that grow with the number of triangles, when they are made and freed. The memory of a few triangles is not
//! counted.
//! Invariant: if [`Watch::result`] returns no error, the tree is complete. Tests: `tests/control.rs`.

use std::fmt;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

/// Callbacks of a build. All are optional: `()` lets it run without reports. Called from any thread of the
/// build, every few thousand triangles.
pub trait BuildControl: Sync {
    /// Whether the build should continue.
    fn keep_going(&self) -> bool {
        true
    }

    /// The share of the work that is done, 0 to 1: 1 comes last. Calls come one at a time and never go back.
    fn progress(&self, done: f32) {
        let _ = done;
    }

    /// Bytes that the build holds, the growing tree included, whenever that changes a lot. Calls from several threads may
    /// come out of order.
    fn memory(&self, bytes: u64) {
        let _ = bytes;
    }

    /// Most bytes that it may hold; read once. The triangles that are built over do not count.
    fn memory_budget(&self) -> u64 {
        u64::MAX
    }
}

impl BuildControl for () {}

/// Why there is no tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// [`BuildControl::keep_going`] returned false.
    Cancelled,
    /// The next step would have needed more bytes than the budget allows.
    OutOfMemory {
        /// With that step; a build that may go on could need more.
        needed: u64,
        /// The value of [`BuildControl::memory_budget`].
        budget: u64,
    },
    /// Leaves cannot number this many blocks of eight primitives: several objects can hold them.
    TooManyBlocks {
        /// That the tree would have.
        blocks: u64,
        /// That a tree can have.
        most: u64,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cancelled => f.write_str("the build was cancelled"),
            Self::OutOfMemory { needed, budget } => {
                write!(f, "the build needs {needed} bytes of memory or more, and may take {budget}")
            }
            Self::TooManyBlocks { blocks, most } => write!(
                f,
                "the tree would have {blocks} leaf blocks of up to 8 primitives and can have {most}: divide the object"
            ),
        }
    }
}

impl std::error::Error for BuildError {}

/// One build under control.
pub struct Watch<'a> {
    control: &'a dyn BuildControl,
    budget: u64,
    stopped: AtomicBool,
    held: AtomicU64,
    /// The part of it that grows by itself.
    growing: AtomicU64,
    /// The excessive number of bytes; 0 if there was none.
    needed: AtomicU64,
    done: AtomicU64,
    whole: AtomicU64,
    /// The progress reported last.
    reported: Mutex<f32>,
}

impl<'a> Watch<'a> {
    pub fn new(control: &'a dyn BuildControl) -> Self {
        let zero = || AtomicU64::new(0);
        Self {
            control,
            budget: control.memory_budget(),
            stopped: AtomicBool::new(false),
            held: zero(),
            growing: zero(),
            needed: zero(),
            done: zero(),
            whole: zero(),
            reported: Mutex::new(0.0),
        }
    }

    /// Whether to go on. After it returned false, the result will be discarded.
    pub fn go_on(&self) -> bool {
        if self.stopped.load(Relaxed) {
            return false;
        }
        let going = self.control.keep_going();
        if !going {
            self.stopped.store(true, Relaxed);
        }
        going
    }

    /// Counts memory that is about to be taken; whether that may be.
    pub fn take(&self, bytes: usize) -> bool {
        let held = self.held.fetch_add(bytes as u64, Relaxed) + bytes as u64;
        if held > self.budget {
            self.needed.fetch_max(held, Relaxed);
            self.stopped.store(true, Relaxed);
            return false;
        }
        self.control.memory(held);
        true
    }

    /// Counts memory that was given back.
    pub fn give(&self, bytes: usize) {
        let held = self.held.fetch_sub(bytes as u64, Relaxed) - bytes as u64;
        // Rejected memory was counted, but never allocated.
        if !self.stopped.load(Relaxed) {
            self.control.memory(held);
        }
    }

    /// Counts memory of something that grows.
    pub fn grow(&self, bytes: usize) {
        self.growing.fetch_add(bytes as u64, Relaxed);
        self.take(bytes);
    }

    /// All that grew is counted no longer.
    pub fn grown(&self) {
        self.give(self.growing.swap(0, Relaxed) as usize);
    }

    /// Replaces an earlier count by the current one; returns whether the budget allows it.
    pub fn recount(&self, counted: &mut usize, now: usize) -> bool {
        let before = std::mem::replace(counted, now);
        if now >= before {
            return self.take(now - before);
        }
        self.give(before - now);
        true
    }

    /// Adds steps to the total; `finish` reports the last ones.
    pub fn start(&self, whole: usize) {
        self.whole.fetch_add(whole as u64, Relaxed);
    }

    /// Advances by this many steps.
    pub fn advance(&self, steps: usize) {
        self.report_steps(self.done.fetch_add(steps as u64, Relaxed) + steps as u64);
    }

    /// Advances to this part of the total or further: a stage with less work than expected is over.
    pub fn advance_to(&self, done: usize) {
        self.report_steps(self.done.fetch_max(done as u64, Relaxed).max(done as u64));
    }

    fn report_steps(&self, done: u64) {
        let whole = self.whole.load(Relaxed).max(1);
        // The stages before and after the division take time as well.
        self.report(0.05 + 0.8 * (done as f64 / whole as f64).min(1.0) as f32);
    }

    /// All is done.
    pub fn finish(&self) {
        self.report(1.0);
    }

    /// Another reporting thread suffices, and may be called from within its own call.
    fn report(&self, done: f32) {
        if let Ok(mut reported) = self.reported.try_lock()
            && done > *reported
            && !self.stopped.load(Relaxed)
        {
            *reported = done;
            self.control.progress(done);
        }
    }

    /// Whether anything has stopped the build.
    pub fn result(&self) -> Result<(), BuildError> {
        if self.go_on() {
            return Ok(());
        }
        match self.needed.load(Relaxed) {
            0 => Err(BuildError::Cancelled),
            needed => Err(BuildError::OutOfMemory { needed, budget: self.budget }),
        }
    }
}
