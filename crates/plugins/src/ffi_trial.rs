// SPDX-License-Identifier: GPL-3.0-or-later
//! Trying a plugin's `prepare` in a child process, so that one that crashes does not end the program.
//! Why a child and not a signal handler: docs/decisions/0010-plugins-on-trial.md.
//!
//! The child is a copy of the process with only the calling thread. It calls each `prepare` on its copy of
//! the snapshots and writes two bytes to a pipe, one before and one after each; the parent reads them, and a
//! missing second byte identifies the one that crashed. Trying continues after it with the next child.
//! Tests: bindings/openrt/tests/plugins.rs (crashing, aborting and looping plugins).

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

/// The result of one child: how many calls returned, and how the next one ended it.
struct Outcome {
    returned: usize,
    crash: Option<String>,
}

/// Tries calls `first..count` in one child; `None` where there is none to be had.
#[cfg(unix)]
fn try_from(first: usize, count: usize, call: &mut impl FnMut(usize)) -> Option<Outcome> {
    let [read_end, write_end] = pipe()?;
    // SAFETY: the child runs the plugin's function, which may do anything, then leaves without running any of
    // our destructors; the C library keeps its own locks usable over a fork.
    let child = unsafe { libc::fork() };
    if child < 0 {
        close(read_end);
        close(write_end);
        return None;
    }
    if child == 0 {
        run_child(first, count, call, write_end);
    }
    let child = Child::new(child);
    close(write_end);
    let marks = read_marks(read_end, count - first);
    close(read_end);
    let done = marks.len() == 2 * (count - first);
    let late = !done && marks.last() != Some(&END_OF_PIPE) && !child.has_ended();
    if late || done {
        child.kill();
    }
    let end = child.wait();
    let calls = marks.iter().filter(|&&mark| mark == AFTER).count();
    if late {
        // All that is left counts as passed.
        return Some(Outcome { returned: count - first, crash: None });
    }
    let crash = (calls < count - first).then(|| how_it_ended(end));
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
    // SAFETY: it leaves at once; the program's exit handlers do not run.
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

/// A pipe's two ends: to read from and to write to. Programs that the process starts do not get them: they would keep it open.
#[cfg(unix)]
fn pipe() -> Option<[libc::c_int; 2]> {
    let mut ends = [0; 2];
    // In one step, as another thread may start a program at any time.
    #[cfg(any(target_os = "linux", target_os = "android"))]
    // SAFETY: `ends` has room for two descriptors.
    let made = unsafe { libc::pipe2(ends.as_mut_ptr(), libc::O_CLOEXEC) };
    #[cfg(not(any(target_os = "linux", target_os = "android")))]
    // SAFETY: `ends` has room for two descriptors, which are open then.
    let made = unsafe {
        let made = libc::pipe(ends.as_mut_ptr());
        ends.iter().for_each(|&end| {
            libc::fcntl(end, libc::F_SETFD, libc::FD_CLOEXEC);
        });
        made
    };
    (made == 0).then_some(ends)
}

/// A child process. A handler of the program may take its end from us at any time, and the system give its number to another
/// process: where there are descriptors of processes (Linux since 5.4), these name it.
#[cfg(unix)]
struct Child {
    number: libc::pid_t,
    /// Of the process itself.
    descriptor: Option<libc::c_int>,
}

/// How a child ended.
#[cfg(unix)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// By itself.
    Exit,
    /// By a signal.
    Signal(libc::c_int),
    /// A handler of the program has the status.
    Unknown,
}

#[cfg(unix)]
impl Child {
    /// The child that fork has just given.
    fn new(number: libc::pid_t) -> Self {
        Self { number, descriptor: descriptor(number) }
    }

    /// Queries its end, with the flags of waitid; `None` if a handler of the program has taken it.
    fn ask(&self, flags: libc::c_int) -> Option<libc::siginfo_t> {
        #[cfg(target_os = "linux")]
        let by_descriptor = self.descriptor.map(|descriptor| (libc::P_PIDFD, descriptor.cast_unsigned()));
        #[cfg(not(target_os = "linux"))]
        let by_descriptor = None;
        let (kind, name) = by_descriptor.unwrap_or((libc::P_PID, self.number.cast_unsigned()));
        loop {
            let mut info = std::mem::MaybeUninit::<libc::siginfo_t>::zeroed();
            // SAFETY: there is memory for the result.
            if unsafe { libc::waitid(kind, name, info.as_mut_ptr(), libc::WEXITED | flags) } == 0 {
                // SAFETY: zeros are a value, and the call has filled it in.
                return Some(unsafe { info.assume_init() });
            }
            if !interrupted() {
                return None;
            }
        }
    }

    /// Whether it is gone, without waiting.
    fn has_ended(&self) -> bool {
        // SAFETY: the member is one of those that waitid fills in; it is 0 where no child has ended.
        self.ask(libc::WNOHANG | libc::WNOWAIT).is_none_or(|info| unsafe { info.si_pid() } == self.number)
    }

    /// Ends it, if it is still there; whether it was.
    fn kill(&self) -> bool {
        #[cfg(target_os = "linux")]
        if let Some(descriptor) = self.descriptor {
            let none = std::ptr::null::<libc::siginfo_t>();
            // SAFETY: the descriptor is of our child; if that is gone, the call fails.
            return unsafe {
                libc::syscall(libc::SYS_pidfd_send_signal, descriptor, libc::SIGKILL, none, 0) == 0
            };
        }
        // SAFETY: it is our child, and it was not reaped at the check.
        !self.has_ended() && unsafe { libc::kill(self.number, libc::SIGKILL) == 0 }
    }

    /// Waits for its end.
    fn wait(&self) -> End {
        let Some(info) = self.ask(0) else { return End::Unknown };
        match info.si_code {
            libc::CLD_EXITED => End::Exit,
            // SAFETY: the member is one of those that waitid fills in.
            _ => End::Signal(unsafe { info.si_status() }),
        }
    }
}

#[cfg(unix)]
impl Drop for Child {
    fn drop(&mut self) {
        if let Some(descriptor) = self.descriptor {
            close(descriptor);
        }
    }
}

/// A descriptor of an unreaped child, if the system has both calls for it.
#[cfg(target_os = "linux")]
fn descriptor(child: libc::pid_t) -> Option<libc::c_int> {
    // SAFETY: it takes two numbers. It closes the descriptor in programs that the process starts.
    let made = unsafe { libc::syscall(libc::SYS_pidfd_open, child, 0) };
    let descriptor = libc::c_int::try_from(made).ok().filter(|&descriptor| descriptor >= 0)?;
    let flags = libc::WEXITED | libc::WNOHANG | libc::WNOWAIT;
    let mut info = std::mem::MaybeUninit::<libc::siginfo_t>::zeroed();
    // SAFETY: there is memory for the result. Linux 5.3 can make descriptors, but not wait for them.
    let can_wait =
        unsafe { libc::waitid(libc::P_PIDFD, descriptor.cast_unsigned(), info.as_mut_ptr(), flags) } == 0;
    if !can_wait {
        close(descriptor);
    }
    can_wait.then_some(descriptor)
}

#[cfg(all(unix, not(target_os = "linux")))]
fn descriptor(_: libc::pid_t) -> Option<libc::c_int> {
    None
}

#[cfg(unix)]
fn how_it_ended(end: End) -> String {
    match end {
        End::Exit | End::Unknown => "it left the process".to_owned(),
        End::Signal(libc::SIGSEGV) => "it read or wrote invalid memory (SIGSEGV)".to_owned(),
        End::Signal(libc::SIGBUS) => "it read or wrote invalid memory (SIGBUS)".to_owned(),
        End::Signal(libc::SIGABRT) => "it aborted (SIGABRT)".to_owned(),
        End::Signal(libc::SIGFPE) => "it divided by zero (SIGFPE)".to_owned(),
        End::Signal(libc::SIGILL) => "it met an illegal instruction (SIGILL)".to_owned(),
        End::Signal(other) => format!("it was ended by signal {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of a child reaped elsewhere may be another process's: it is not signalled.
    #[test]
    fn a_child_whose_end_was_taken_is_left_alone() {
        for has_descriptor in [true, false] {
            // SAFETY: the child leaves at once, and runs nothing of ours.
            let number = unsafe { libc::fork() };
            assert!(number >= 0, "a child");
            if number == 0 {
                // SAFETY: as above.
                unsafe { libc::_exit(0) };
            }
            let mut child = Child::new(number);
            if !has_descriptor && let Some(descriptor) = child.descriptor.take() {
                close(descriptor);
            }
            // As a handler of the program does.
            // SAFETY: no status is requested.
            let taken = unsafe { libc::waitpid(number, std::ptr::null_mut(), 0) };
            assert_eq!(taken, number, "its end is taken");
            assert!(child.has_ended(), "it is gone");
            assert!(!child.kill(), "nobody is killed");
            assert_eq!(child.wait(), End::Unknown, "nobody is waited for");
        }
    }

    #[test]
    fn crashes_are_found_and_the_others_go_on() {
        let verdicts = try_all(4, |i| match i {
            // SAFETY: it ends the child.
            1 => unsafe { libc::abort() },
            // SAFETY: as above.
            2 => unsafe { libc::_exit(3) },
            _ => {}
        });
        let crashed = |text: &str| Trial::Crashed(text.to_owned());
        let expected = [
            Trial::Returned,
            crashed("it aborted (SIGABRT)"),
            crashed("it left the process"),
            Trial::Returned,
        ];
        assert_eq!(verdicts, expected, "one after the other");
    }
}
