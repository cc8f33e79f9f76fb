// SPDX-License-Identifier: GPL-3.0-or-later
//! How much is left of this thread's stack: plugins call `trace`, which calls plugins, and how much they take for
//! themselves is theirs to say. Pthread_getattr_np(3).
//! Tests: bindings/openrt/tests/plugins.rs (`deep_shaders_are_stopped`).

/// The stack that must remain for tracing: a callback's arrays, and the deepest chain of built-in shaders
/// (1,024 bounces of about 2.5 KiB).
const RESERVE: usize = 5 << 20;

/// Whether the remaining stack suffices for tracing. If it is unknown, it does.
pub(crate) fn is_enough() -> bool {
    let here = 0_u8;
    let here = (&raw const here).addr();
    let lowest = LOWEST.with(|lowest| *lowest);
    // On a stack smaller than that half of it must be left.
    lowest.is_none_or(|[lowest, size]| here.saturating_sub(lowest) >= RESERVE.min(size / 2))
}

thread_local! {
    /// Where this thread's stack ends, which grows downwards, and its size.
    static LOWEST: Option<[usize; 2]> = lowest();
}

#[cfg(any(target_os = "linux", target_os = "android"))]
fn lowest() -> Option<[usize; 2]> {
    let mut attributes = std::mem::MaybeUninit::<libc::pthread_attr_t>::uninit();
    let (mut lowest, mut size) = (std::ptr::null_mut(), 0);
    // SAFETY: the attributes are filled in by the first call, read by the second and freed by the third.
    unsafe {
        if libc::pthread_getattr_np(libc::pthread_self(), attributes.as_mut_ptr()) != 0 {
            return None;
        }
        let failed = libc::pthread_attr_getstack(attributes.as_ptr(), &raw mut lowest, &raw mut size);
        libc::pthread_attr_destroy(attributes.as_mut_ptr());
        (failed == 0).then(|| [lowest.addr(), size])
    }
}

#[cfg(target_os = "macos")]
fn lowest() -> Option<[usize; 2]> {
    // SAFETY: both only read the system's data about this thread.
    let (highest, size) = unsafe {
        let this = libc::pthread_self();
        (libc::pthread_get_stackaddr_np(this), libc::pthread_get_stacksize_np(this))
    };
    highest.addr().checked_sub(size).map(|lowest| [lowest, size])
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_os = "macos")))]
fn lowest() -> Option<[usize; 2]> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deep_calls_leave_too_little() {
        fn deep(levels: usize) -> bool {
            let mut bytes = [0_u8; 1 << 16];
            std::hint::black_box(&mut bytes);
            if levels > 0 && !deep(levels - 1) {
                return false;
            }
            std::hint::black_box(&bytes);
            is_enough()
        }
        // 16 MiB: eight of them leave enough, twelve do not.
        let on_thread = |levels: usize| {
            let thread = std::thread::Builder::new().stack_size(16 << 20);
            thread.spawn(move || deep(levels)).expect("a thread").join().expect("no overflow")
        };
        assert!(on_thread(128), "half of it is left");
        if cfg!(any(target_os = "linux", target_os = "macos")) {
            assert!(!on_thread(192), "a quarter is left");
        }
    }
}
