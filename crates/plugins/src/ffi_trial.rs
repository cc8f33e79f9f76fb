// SPDX-License-Identifier: GPL-3.0-or-later
//! Trying a plugin's `prepare` in a child process, so that one that crashes does not end the program.
//! Source: original; why a child and not a signal handler: docs/decisions/0010-plugins-on-trial.md.
//!
//! The child is a copy of the process with the calling thread alone. It calls each `prepare` on its copy of the snapshots
//! and writes two bytes to a pipe, one before and one after each; the parent reads them, and a missing second byte
//! tells which one crashed. Trying goes on behind it with the next child.
//! Proof: bindings/openrt/tests/plugins.rs (crashing, aborting and looping plugins).

use std::time::{Duration, Instant};

/// Longer trials are ended and count as passed: slow is no crime, and a child may wait for a lock that another thread
/// of the program held when the child was made.
const PATIENCE: Duration = Duration::from_secs(10);

/// How a call went in a child.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Trial {
    /// It returned.
    Returned,
    /// It ended its process; how.
    Crashed(String),
}

/// Tries all calls, in order. `call` runs in child processes only. Where there are no child processes, all pass.
pub(crate) fn try_all(count: usize, mut call: impl FnMut(usize)) -> Vec<Trial> {
    let mut verdicts = Vec::new();
    while verdicts.len() < count {
        match try_from(verdicts.len(), count, &mut call) {
            Some(Outcome { returned, crash }) => {
                verdicts.extend(std::iter::repeat_n(Trial::Returned, returned));
                verdicts.extend(crash.map(Trial::Crashed));
            }
            None => verdicts.resize(count, Trial::Returned),
        }
    }
    verdicts
}

/// What one child did: how many calls returned, and how the next one ended it.
struct Outcome {
    returned: usize,
    crash: Option<String>,
}

/// Tries calls `first..count` in one child; `None` where there is none to be had.
#[cfg(unix)]
fn try_from(first: usize, count: usize, call: &mut impl FnMut(usize)) -> Option<Outcome> {
    let mut ends = [0; 2];
    // SAFETY: `ends` has room for two descriptors.
    if unsafe { libc::pipe(ends.as_mut_ptr()) } != 0 {
        return None;
    }
    let [read_end, write_end] = ends;
    for end in ends {
        // SAFETY: the descriptor is open. Programs that the process starts must not keep the pipe open.
        unsafe { libc::fcntl(end, libc::F_SETFD, libc::FD_CLOEXEC) };
    }
    // SAFETY: the child runs the plugin's function, which may do what it likes, then leaves without running any of our
    // destructors; the C library keeps its own locks usable over a fork.
    let child = unsafe { libc::fork() };
    if child < 0 {
        close(read_end);
        close(write_end);
        return None;
    }
    if child == 0 {
        run_child(first, count, call, write_end);
    }
    close(write_end);
    let marks = read_marks(read_end, count - first);
    close(read_end);
    let done = marks.len() == 2 * (count - first);
    let late = !done && marks.last() != Some(&END_OF_PIPE) && !ended(child);
    let status = reap(child, late || done);
    let calls = marks.iter().filter(|&&mark| mark == AFTER).count();
    if late {
        // All that is left counts as passed.
        return Some(Outcome { returned: count - first, crash: None });
    }
    let crash = (calls < count - first).then(|| how_it_ended(status));
    Some(Outcome { returned: calls, crash })
}

#[cfg(not(unix))]
fn try_from(_first: usize, _count: usize, _call: &mut impl FnMut(usize)) -> Option<Outcome> {
    None
}

const BEFORE: u8 = b'<';
const AFTER: u8 = b'>';
/// The child's end was closed: put behind the marks that came.
const END_OF_PIPE: u8 = b'!';

/// The child: never returns.
#[cfg(unix)]
fn run_child(first: usize, count: usize, call: &mut impl FnMut(usize), pipe: libc::c_int) -> ! {
    // A crash here is expected: it neither calls the program's handlers nor leaves a core file.
    for signal in [libc::SIGSEGV, libc::SIGBUS, libc::SIGILL, libc::SIGFPE, libc::SIGABRT, libc::SIGPIPE] {
        // SAFETY: the default action is a valid one.
        unsafe { libc::signal(signal, libc::SIG_DFL) };
    }
    let none = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: it reads the limits; that it may fail does no harm.
    unsafe { libc::setrlimit(libc::RLIMIT_CORE, &raw const none) };
    let mark = |mark: u8| {
        // SAFETY: one byte is there to be read.
        let _ = unsafe { libc::write(pipe, (&raw const mark).cast(), 1) };
    };
    for i in first..count {
        mark(BEFORE);
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| call(i)));
        if outcome.is_err() {
            break;
        }
        mark(AFTER);
    }
    // SAFETY: it leaves at once; what the program registered for its end does not run.
    unsafe { libc::_exit(0) }
}

/// The marks of `calls` calls, or those until the child ended or patience did.
#[cfg(unix)]
fn read_marks(pipe: libc::c_int, calls: usize) -> Vec<u8> {
    let (mut marks, start) = (Vec::new(), Instant::now());
    while marks.len() < 2 * calls {
        let rest = PATIENCE.saturating_sub(start.elapsed()).as_millis() as libc::c_int;
        let mut poll = libc::pollfd { fd: pipe, events: libc::POLLIN, revents: 0 };
        // SAFETY: there is one entry.
        let ready = unsafe { libc::poll(&raw mut poll, 1, rest) };
        if ready == 0 || (ready < 0 && !interrupted()) {
            break;
        }
        if ready < 0 {
            continue;
        }
        let mut mark = 0_u8;
        // SAFETY: there is room for one byte.
        let got = unsafe { libc::read(pipe, (&raw mut mark).cast(), 1) };
        match got {
            1 => marks.push(mark),
            0 => {
                marks.push(END_OF_PIPE);
                break;
            }
            _ if interrupted() => {}
            _ => break,
        }
    }
    marks
}

#[cfg(unix)]
fn interrupted() -> bool {
    std::io::Error::last_os_error().kind() == std::io::ErrorKind::Interrupted
}

#[cfg(unix)]
fn close(descriptor: libc::c_int) {
    // SAFETY: it is open, and ours.
    unsafe { libc::close(descriptor) };
}

/// Whether the child is gone, without waiting.
#[cfg(unix)]
fn ended(child: libc::pid_t) -> bool {
    let mut info = std::mem::MaybeUninit::<libc::siginfo_t>::zeroed();
    let flags = libc::WEXITED | libc::WNOHANG | libc::WNOWAIT;
    // SAFETY: there is room for the answer.
    let got = unsafe { libc::waitid(libc::P_PID, child.cast_unsigned(), info.as_mut_ptr(), flags) };
    // SAFETY: zeros are a value, and the call has filled it in if it succeeded.
    got != 0 || unsafe { info.assume_init().si_pid() } == child
}

/// Waits for the child, ends it first if asked to; its status, 0 if a handler of the program took it.
#[cfg(unix)]
fn reap(child: libc::pid_t, kill: bool) -> libc::c_int {
    if kill {
        // SAFETY: it is our child, and nobody has waited for it.
        unsafe { libc::kill(child, libc::SIGKILL) };
    }
    let mut status = 0;
    loop {
        // SAFETY: there is room for the status.
        let got = unsafe { libc::waitpid(child, &raw mut status, 0) };
        if got == child {
            return status;
        }
        if !interrupted() {
            return 0;
        }
    }
}

#[cfg(unix)]
fn how_it_ended(status: libc::c_int) -> String {
    if !libc::WIFSIGNALED(status) {
        return "it left the process".to_owned();
    }
    match libc::WTERMSIG(status) {
        libc::SIGSEGV => "it read or wrote memory that is not there (SIGSEGV)".to_owned(),
        libc::SIGBUS => "it read or wrote memory that is not there (SIGBUS)".to_owned(),
        libc::SIGABRT => "it aborted (SIGABRT)".to_owned(),
        libc::SIGFPE => "it divided by zero (SIGFPE)".to_owned(),
        libc::SIGILL => "it met an illegal instruction (SIGILL)".to_owned(),
        other => format!("it was ended by signal {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crashes_are_found_and_the_others_go_on() {
        let verdicts = try_all(4, |i| match i {
            // SAFETY: it ends the child.
            1 => unsafe { libc::abort() },
            // SAFETY: likewise.
            2 => unsafe { libc::_exit(3) },
            _ => {}
        });
        let crashed = |text: &str| Trial::Crashed(text.to_owned());
        let wanted = [
            Trial::Returned,
            crashed("it aborted (SIGABRT)"),
            crashed("it left the process"),
            Trial::Returned,
        ];
        assert_eq!(verdicts, wanted, "one after the other");
    }
}
