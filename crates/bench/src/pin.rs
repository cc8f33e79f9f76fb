// SPDX-License-Identifier: GPL-3.0-or-later
//! Keeps a thread on one core while it is timed: a thread that moves finds cold caches, and cores may differ.
//! Sched_setaffinity(2). Where the system has no such call, nothing happens.
//! Invariant: a thread is given back the cores that it had. Tests: `tests::one_core_and_back`.

#[cfg(target_os = "linux")]
use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// While it lives, the thread that made it stays on one core.
pub(crate) struct Pinned {
    #[cfg(target_os = "linux")]
    before: Option<CpuSet>,
}

impl Pinned {
    /// Pins the calling thread: the only one of a run to the core that it is on, thread `i` of `n` to the i-th of the cores
    /// that it may use. Threads are not pinned if there are fewer cores than threads.
    #[cfg(target_os = "linux")]
    pub(crate) fn thread(i: usize, n: usize) -> Self {
        let not_pinned = Self { before: None };
        let Ok(before) = sched_getaffinity(None) else { return not_pinned };
        let mut cores = (0..CpuSet::MAX_CPU).filter(|&core| before.is_set(core));
        let core = if n == 1 { Some(sched_getcpu()) } else { cores.nth(i) };
        let Some(core) = core.filter(|_| before.count() as usize >= n) else { return not_pinned };
        let mut only = CpuSet::new();
        only.set(core);
        Self { before: sched_setaffinity(None, &only).ok().map(|()| before) }
    }

    #[cfg(not(target_os = "linux"))]
    pub(crate) fn thread(_: usize, _: usize) -> Self {
        Self {}
    }

    /// Whether the system did it.
    #[cfg(target_os = "linux")]
    pub(crate) fn is_pinned(&self) -> bool {
        self.before.is_some()
    }

    #[cfg(not(target_os = "linux"))]
    pub(crate) fn is_pinned(&self) -> bool {
        false
    }
}

#[cfg(target_os = "linux")]
impl Drop for Pinned {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // It was allowed before; a thread that stays where it is is no harm.
            let _ = sched_setaffinity(None, before);
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn one_core_and_back() {
        let cores = || sched_getaffinity(None).expect("Linux tells").count();
        let before = cores();
        {
            let pinned = Pinned::thread(0, 1);
            assert!(pinned.is_pinned() && cores() == 1, "{} cores while pinned", cores());
        }
        assert_eq!(cores(), before, "all cores are given back");
        let many = Pinned::thread(0, 1 << 20);
        assert!(!many.is_pinned() && cores() == before, "more threads than cores stay free");
    }
}
