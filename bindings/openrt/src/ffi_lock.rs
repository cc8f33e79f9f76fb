// SPDX-License-Identifier: GPL-3.0-or-later
//! A mutex that costs next to nothing while one thread uses it: the first thread that takes it owns it.
//! Source: biased locking after \[KKO02\], with the revocation by a barrier on all CPUs (membarrier(2)) that user-space RCU
//! has \[DMS*12\]. A program submits its vertices by millions of calls from one thread, and two locked
//! instructions per call took a third of their time (docs/decisions/0013-the-lock-of-the-c-api.md). The owner
//! marks that it is inside by a plain store; no other thread is admitted, so no lock is needed. The first
//! other thread ends the ownership for good: it removes the owner, makes all CPUs pass a barrier, waits until
//! the owner is outside, and from then on all threads use an ordinary mutex.
//! Invariant: at most one [`Guard`] lives. A thread that enters twice gets `None`: it would wait for itself.
//! Tests: `tests`, with every mixture of threads.

use std::cell::{Cell, UnsafeCell};
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU64, Ordering, compiler_fence};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A value that one thread at a time may use.
pub(crate) struct Biased<T> {
    /// The owner, which needs no mutex: the number of a thread, [`NOBODY`] yet, or [`NO_MORE`].
    owner: AtomicU64,
    /// The owner while it uses the value, else [`NOBODY`]; only it writes here. It may have lost the ownership meanwhile.
    inside: AtomicU64,
    /// For all others, and for changes of the owner.
    mutex: Mutex<()>,
    /// The thread that holds the mutex to use the value.
    holder: AtomicU64,
    value: UnsafeCell<T>,
}

const NOBODY: u64 = 0;
const NO_MORE: u64 = u64::MAX;

// SAFETY: guards give the value to one thread at a time, see `enter`.
unsafe impl<T: Send> Sync for Biased<T> {}

/// The right to use the value.
pub(crate) struct Guard<'a, T> {
    lock: &'a Biased<T>,
    /// None for the owner.
    held: Option<MutexGuard<'a, ()>>,
}

impl<T> Biased<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self {
            owner: AtomicU64::new(NOBODY),
            inside: AtomicU64::new(NOBODY),
            mutex: Mutex::new(()),
            holder: AtomicU64::new(NOBODY),
            value: UnsafeCell::new(value),
        }
    }

    /// Waits until no other thread uses the value. `None` if this thread does.
    #[inline]
    pub(crate) fn enter(&self) -> Option<Guard<'_, T>> {
        let me = THREAD.get();
        if me != NOBODY && self.owner.load(Ordering::Relaxed) == me {
            if self.inside.load(Ordering::Relaxed) != NOBODY {
                return None;
            }
            self.inside.store(me, Ordering::Relaxed);
            // The CPU must not read the owner before the store is visible; the thread that removes the owner
            // makes all CPUs pass a barrier, so that only the compiler's order matters here.
            compiler_fence(Ordering::SeqCst);
            if self.owner.load(Ordering::Relaxed) == me {
                return Some(Guard { lock: self, held: None });
            }
            self.inside.store(NOBODY, Ordering::Release);
        }
        self.enter_by_mutex()
    }

    #[cold]
    #[inline(never)]
    fn enter_by_mutex(&self) -> Option<Guard<'_, T>> {
        let me = thread_number();
        // This thread holds the mutex; or it came in as the owner, and another thread, which has taken the ownership away, holds
        // the mutex and waits for it.
        if self.holder.load(Ordering::Relaxed) == me || self.inside.load(Ordering::Relaxed) == me {
            return None;
        }
        let held = self.mutex.lock().unwrap_or_else(PoisonError::into_inner);
        match self.owner.load(Ordering::Relaxed) {
            NOBODY if barrier::is_there() => {
                // Inside before the owner is visible: the others see both in this order.
                self.inside.store(me, Ordering::Relaxed);
                self.owner.store(me, Ordering::Release);
                return Some(Guard { lock: self, held: None });
            }
            NOBODY | NO_MORE => {}
            _ => {
                self.owner.store(NO_MORE, Ordering::SeqCst);
                barrier::on_all_threads();
                // Once for the whole process: the owner's work may be a whole frame.
                while self.inside.load(Ordering::Acquire) != NOBODY {
                    std::thread::sleep(Duration::from_micros(50));
                }
            }
        }
        self.owner.store(NO_MORE, Ordering::Relaxed);
        self.holder.store(me, Ordering::Relaxed);
        Some(Guard { lock: self, held: Some(held) })
    }
}

impl<T> Deref for Guard<'_, T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        // SAFETY: this is the only guard. If it holds the mutex, no owner is inside: the thread that removed
        // the owner has waited for that, after a barrier that orders the owner's two accesses in `enter`.
        // Otherwise it is the owner's, which entered as the owner; a thread that removes the owner waits
        // until it is out.
        unsafe { &*self.lock.value.get() }
    }
}

impl<T> DerefMut for Guard<'_, T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut T {
        // SAFETY: as in `deref`.
        unsafe { &mut *self.lock.value.get() }
    }
}

impl<T> Drop for Guard<'_, T> {
    #[inline]
    fn drop(&mut self) {
        if self.held.is_some() {
            // The mutex is released after this.
            self.lock.holder.store(NOBODY, Ordering::Relaxed);
        } else {
            self.lock.inside.store(NOBODY, Ordering::Release);
        }
    }
}

thread_local! {
    /// A number that no other thread of the process has or had; [`NOBODY`] until it is needed.
    static THREAD: Cell<u64> = const { Cell::new(NOBODY) };
}

fn thread_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(NOBODY + 1);
    if THREAD.get() == NOBODY {
        THREAD.set(NEXT.fetch_add(1, Ordering::Relaxed));
    }
    THREAD.get()
}

/// A barrier that all threads of the process pass when one requests it: earlier accesses of each are visible
/// to that one, and its earlier accesses to each.
#[cfg(all(target_os = "linux", not(gnurt_plain_lock)))]
mod barrier {
    const REGISTER: libc::c_int = libc::MEMBARRIER_CMD_REGISTER_PRIVATE_EXPEDITED;
    const EXPEDITED: libc::c_int = libc::MEMBARRIER_CMD_PRIVATE_EXPEDITED;

    fn call(command: libc::c_int) -> bool {
        // SAFETY: membarrier takes three numbers and touches no memory of ours.
        unsafe { libc::syscall(libc::SYS_membarrier, command, 0, 0) == 0 }
    }

    /// Whether the system has it: Linux since 4.14, unless a sandbox forbids it.
    pub(super) fn is_there() -> bool {
        call(REGISTER) && call(EXPEDITED)
    }

    pub(super) fn on_all_threads() {
        // A child of fork has to register again.
        if !call(EXPEDITED) && !is_there() {
            // No other instruction orders another CPU's stores; the system has withdrawn the service.
            gnurt_plugins::host::print_line("the system's membarrier does not work any more");
            std::process::abort();
        }
    }
}

/// Elsewhere, and for ThreadSanitizer, which does not support that barrier, all threads use the mutex.
#[cfg(not(all(target_os = "linux", not(gnurt_plain_lock))))]
mod barrier {
    pub(super) fn is_there() -> bool {
        false
    }

    pub(super) fn on_all_threads() {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, AtomicUsize};
    use std::sync::{Arc, mpsc};
    use std::thread;

    #[test]
    fn a_thread_alone_needs_no_mutex() {
        let lock = Biased::new(0);
        for i in 1..=10 {
            let mut guard = lock.enter().expect("nobody is inside");
            *guard += 1;
            assert_eq!(guard.held.is_some(), !barrier::is_there(), "by way {i}");
        }
        assert_eq!(*lock.enter().expect("nobody is inside"), 10);
    }

    #[test]
    fn who_is_inside_is_told_so() {
        let lock = Biased::new(());
        // As the owner; then, as others have come, by the mutex.
        for owns in [true, false] {
            let guard = lock.enter().expect("nobody is inside");
            assert!(lock.enter().is_none(), "it would wait for itself (owner: {owns})");
            drop(guard);
            assert!(lock.enter().is_some(), "outside again (owner: {owns})");
            thread::scope(|scope| {
                scope.spawn(|| assert!(lock.enter().is_some(), "another thread comes in"));
            });
        }
    }

    /// The owner comes again while another thread waits for it to leave.
    #[test]
    fn who_is_inside_is_told_so_while_another_waits() {
        let lock = Arc::new(Biased::new(()));
        if !barrier::is_there() {
            eprintln!("SKIPPED: nobody owns the lock here");
            return;
        }
        let (reported, tells) = mpsc::channel();
        let owner = lock.clone();
        thread::spawn(move || {
            let guard = owner.enter().expect("nobody is inside");
            let other = owner.clone();
            let other = thread::spawn(move || other.enter().is_some());
            while owner.owner.load(Ordering::Relaxed) != NO_MORE {
                thread::yield_now();
            }
            let again = owner.enter().is_some();
            drop(guard);
            let after = owner.enter().is_some();
            let _ = reported.send((again, after, other.join().expect("it does not panic")));
        });
        let wait = Duration::from_secs(20);
        let outcome = tells.recv_timeout(wait).expect("the owner waits for itself");
        assert_eq!(
            outcome,
            (false, true, true),
            "refused inside, let in after; and the other thread came in"
        );
    }

    /// Counts threads that have ended, by a panic too.
    struct Done<'a>(&'a AtomicUsize);

    impl Drop for Done<'_> {
        fn drop(&mut self) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Threads that add 1 in two steps lose no additions, and are never inside together: one that is first
    /// and runs to the end, and others that start in between.
    #[test]
    fn one_thread_at_a_time() {
        const OTHERS: usize = 3;
        const TIMES: usize = 100;
        for round in 0..300 {
            let (lock, within, done) = (Biased::new(0_usize), AtomicBool::new(false), AtomicUsize::new(0));
            let work = || {
                let mut value = lock.enter().expect("this thread is outside");
                assert!(!within.swap(true, Ordering::Relaxed), "alone");
                // Short stays meet a missing barrier, long ones a missing wait.
                (0..round % 8 * 100).for_each(|_| std::hint::spin_loop());
                *value = std::hint::black_box(*value) + 1;
                within.store(false, Ordering::Relaxed);
            };
            let (mut by_first, started) = (0, AtomicBool::new(false));
            thread::scope(|scope| {
                for _ in 0..OTHERS {
                    scope.spawn(|| {
                        while !started.load(Ordering::Relaxed) {
                            std::hint::spin_loop();
                        }
                        let _done = Done(&done);
                        (0..TIMES).for_each(|_| work());
                    });
                }
                while done.load(Ordering::Relaxed) < OTHERS {
                    work();
                    by_first += 1;
                    started.store(by_first > round, Ordering::Relaxed);
                }
            });
            let value = *lock.enter().expect("all are outside");
            assert_eq!(value, by_first + OTHERS * TIMES, "round {round}");
        }
    }
}
