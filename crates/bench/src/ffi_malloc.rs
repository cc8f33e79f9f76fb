// SPDX-License-Identifier: GPL-3.0-or-later
//! Returns free but retained memory to the system, so that later allocations show as growth. Malloc_trim(3).

/// Queries the C library's allocator, which is Rust's, where there is such a call.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn trim() {
    unsafe extern "C" {
        fn malloc_trim(pad: usize) -> std::ffi::c_int;
    }
    // SAFETY: the call has no preconditions; memory in use is unaffected.
    unsafe { malloc_trim(0) };
}

/// There is no such call.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(crate) fn trim() {}
