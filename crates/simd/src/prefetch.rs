// SPDX-License-Identifier: GPL-3.0-or-later
//! A hint to the CPU that memory will be read soon. Source: original. Without effect where there is no such hint.

/// Asks for the cache line that `value` begins in.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 CPU has the instruction, and a prefetch of a valid reference reads nothing.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
