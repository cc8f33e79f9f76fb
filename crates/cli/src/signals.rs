// SPDX-License-Identifier: GPL-3.0-or-later
//! Ctrl-C and SIGTERM: the first one ends a rendering and saves, the second one leaves at once and saves nothing.
//! See docs/reference/cli.md. State is global because signals are.
//!
//! * Signals within [`ONE_WISH`] are one: `timeout` sends two, to the program and to its group, and so do
//!   some job managers.
//! * During a rendering, the first signal is a request that the renderer reads between tiles.
//! * Before that, while a scene is read or trees are built, there is no picture to save: the work continues
//!   for [`PATIENCE`]. If the picture was begun by then, the result of [`FIRST_LOOK`] is saved; otherwise the
//!   program exits.
//! * Commands without a rendering exit at once.
//!
//! On exit, unfinished files are dropped; the status is 130. Tests: `tests/program/interrupts.rs`.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use crate::failure::{Failure, Outcome};
use crate::messages::Messages;

/// The time after the first signal in which another one belongs to it: shorter than a user waits before a
/// second one.
const ONE_WISH: Duration = Duration::from_millis(200);
/// How long reading and building may go on after the first signal.
const PATIENCE: Duration = Duration::from_millis(1500);
/// How long a picture may grow that was begun after the first signal.
const FIRST_LOOK: Duration = Duration::from_millis(400);
/// Status of a program that a signal ended.
const STOPPED: i32 = 130;

static SIGNALS: AtomicU32 = AtomicU32::new(0);
static FIRST: OnceLock<Instant> = OnceLock::new();
static RENDERING: AtomicBool = AtomicBool::new(false);
static LEAVING: AtomicBool = AtomicBool::new(false);
static WRITING: Mutex<()> = Mutex::new(());

/// The meaning of the first signal to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FirstSignal {
    /// Finish early and save.
    Saves,
    /// Finish early; the frame that is rendered just then is not saved.
    Stops,
    /// Leave.
    Leaves,
}

/// From now on signals are listened to.
pub(crate) fn listen(first: FirstSignal, messages: Messages) -> Outcome {
    let handler = move || {
        let since_first = FIRST.get_or_init(Instant::now).elapsed();
        let earlier = SIGNALS.fetch_add(1, Ordering::SeqCst);
        if first == FirstSignal::Leaves || (earlier > 0 && since_first > ONE_WISH) {
            leave();
        }
        if earlier > 0 {
            return;
        }
        messages.note(match first {
            FirstSignal::Stops => {
                "stopping; the frame that is not done is not written. Press Ctrl-C again to exit at once"
            }
            _ => "stopping; the picture so far is saved. Press Ctrl-C again to exit without saving",
        });
        // The handler's thread must stay free for the second signal.
        let waiter = std::thread::Builder::new().spawn(move || leave_if_nothing_is_begun(messages));
        if waiter.is_err() {
            leave();
        }
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Failure::data(format_args!("cannot listen to signals: {error}")))
}

/// Ends the program as soon as no file is being written.
fn leave() -> ! {
    LEAVING.store(true, Ordering::SeqCst);
    let _never_again = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    std::process::exit(STOPPED)
}

fn leave_if_nothing_is_begun(messages: Messages) {
    std::thread::sleep(PATIENCE);
    if !RENDERING.load(Ordering::SeqCst) {
        messages.error("stopped before there was a picture; nothing was written");
        leave();
    }
}

/// Writes files by `write`, which checks [`is_leaving`] before it makes them visible. A program that must
/// leave waits for it, so that nothing half written stays behind.
pub(crate) fn while_writing<T>(write: impl FnOnce() -> T) -> T {
    let written = {
        let _writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
        write()
    };
    while is_leaving() {
        // The handler is about to end the program; nothing may be reported as done.
        std::thread::park();
    }
    written
}

/// Whether the program is about to end without saving.
pub(crate) fn is_leaving() -> bool {
    LEAVING.load(Ordering::SeqCst)
}

/// A rendering that signals can end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rendering {
    /// When it may end at the earliest: later than now only if a signal came before it was begun.
    earliest_end: Instant,
}

impl Rendering {
    /// The picture is begun.
    pub(crate) fn begin() -> Self {
        RENDERING.store(true, Ordering::SeqCst);
        let grace = if is_stopped() { FIRST_LOOK } else { Duration::ZERO };
        Self { earliest_end: Instant::now() + grace }
    }

    /// Whether to finish now.
    pub(crate) fn should_stop(&self) -> bool {
        is_stopped() && Instant::now() >= self.earliest_end
    }
}

/// Whether a signal came.
pub(crate) fn is_stopped() -> bool {
    SIGNALS.load(Ordering::SeqCst) > 0
}
