// SPDX-License-Identifier: GPL-3.0-or-later
//! Gives memory that is free but kept back to the system, so that what is taken next is seen as growth.
//! Malloc_trim(3).

/// Asks the C library's allocator, which is Rust's, where there is such a call.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn trim() {
    unsafe extern "C" {
        fn malloc_trim(pad: usize) -> std::ffi::c_int;
    }
    // SAFETY: the call has no preconditions; what is in use stays where it is.
    unsafe { malloc_trim(0) };
}

/// Nothing to ask.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(crate) fn trim() {}
