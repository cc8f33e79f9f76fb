// SPDX-License-Identifier: GPL-3.0-or-later
//! Seconds that processors spent on us. Clock_gettime(2).
//! Where the system has no such clock, wall time replaces it. Tests:
//! `tests::work_takes_time_and_sleep_does_not`.

#[cfg(unix)]
fn seconds(clock: rustix::time::ClockId) -> f64 {
    let time = rustix::time::clock_gettime(clock);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Seconds of the calling thread.
#[cfg(unix)]
#[must_use]
pub fn thread_seconds() -> f64 {
    seconds(rustix::time::ClockId::ThreadCPUTime)
}

/// Seconds of all threads of this program.
#[cfg(unix)]
#[must_use]
pub fn process_seconds() -> f64 {
    seconds(rustix::time::ClockId::ProcessCPUTime)
}

#[cfg(not(unix))]
fn wall_seconds() -> f64 {
    use std::sync::OnceLock;
    use std::time::Instant;
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// Seconds of the calling thread.
#[cfg(not(unix))]
#[must_use]
pub fn thread_seconds() -> f64 {
    wall_seconds()
}

/// Seconds of all threads of this program.
#[cfg(not(unix))]
#[must_use]
pub fn process_seconds() -> f64 {
    wall_seconds()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    #[test]
    fn work_takes_time_and_sleep_does_not() {
        let before = thread_seconds();
        std::thread::sleep(Duration::from_millis(50));
        let asleep = thread_seconds() - before;
        assert!(asleep < 0.02, "sleeping took {asleep} s of the processor");
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_millis(50) {
            std::hint::spin_loop();
        }
        let awake = thread_seconds() - before;
        assert!(awake > asleep && awake < 0.2, "working took {awake} s");
    }
}
