// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory hints: large pages from the system for arrays with random access (fewer misses of the address
//! cache), and prefetches by the CPU.
//! Source: madvise(2), without effect where the system has no such pages to give or is not Linux; PREFETCHT0.

/// Arrays below this many bytes are not worth a request.
#[cfg(target_os = "linux")]
const WORTH_IT: usize = 4 << 20;

/// Requests large pages for the whole capacity of `values`. To be called before they are filled: pages that have been
/// written to stay small.
pub fn prefer_huge_pages<T>(values: &Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        use std::ffi::{c_int, c_void};
        unsafe extern "C" {
            fn madvise(address: *mut c_void, length: usize, advice: c_int) -> c_int;
        }
        const MADV_HUGEPAGE: c_int = 14;
        const PAGE: usize = 4096;
        let bytes = values.capacity() * size_of::<T>();
        // Miri knows no advice about pages.
        if bytes < WORTH_IT || cfg!(miri) {
            return;
        }
        let start = (values.as_ptr() as usize).next_multiple_of(PAGE);
        let end = (values.as_ptr() as usize + bytes) / PAGE * PAGE;
        // SAFETY: the range lies in the vector's own allocation, and the advice changes no contents. That it may be
        // refused does not matter.
        unsafe { madvise(start as *mut c_void, end - start, MADV_HUGEPAGE) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = values;
}

/// Prefetches the memory of `values[index]`, which is about to be read. Without effect on others than x86-64 CPUs.
#[inline(always)]
pub fn prefetch<T>(values: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let start = values.as_ptr().wrapping_add(index).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(LINE) {
            // SAFETY: a request reads nothing and faults nowhere, whatever the address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line * LINE)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_stay() {
        // Miri takes a minute for a million values.
        let many = if cfg!(miri) { 5000 } else { 3 << 20 };
        for count in [0, 1000, many] {
            let mut values: Vec<u32> = Vec::with_capacity(count);
            prefer_huge_pages(&values);
            values.extend(0..count as u32);
            prefer_huge_pages(&values);
            assert!(values.iter().enumerate().all(|(i, &x)| i as u32 == x), "{count} values are as written");
        }
    }
}
