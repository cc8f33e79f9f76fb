// SPDX-License-Identifier: GPL-3.0-or-later
//! Pointers of C programs become options: the state machine decides when a null pointer is an error, because other errors
//! come first. Tests: the C programs of tests/c.

use std::ffi::{CStr, c_char};

/// The array at `pointer`, or `None` if it is null.
///
/// # Safety
/// A pointer that is not null points to `N` readable values; they need not be aligned.
#[inline]
pub(crate) unsafe fn array<T: Copy, const N: usize>(pointer: *const T) -> Option<[T; N]> {
    // SAFETY: the caller vouches for N values behind a pointer that is not null.
    (!pointer.is_null()).then(|| unsafe { pointer.cast::<[T; N]>().read_unaligned() })
}

/// The text at `pointer`, or `None` if it is null.
///
/// # Safety
/// A pointer that is not null points to a text that ends with a zero byte and does not change while the result lives.
pub(crate) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: the caller vouches for the text.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// A function that copies values to `pointer`, or `None` if it is null.
///
/// # Safety
/// A pointer that is not null has space for all values that will be written; it need not be aligned.
pub(crate) unsafe fn writer<T: Copy>(pointer: *mut T) -> Option<impl FnMut(&[T])> {
    let write = move |values: &[T]| {
        let bytes = size_of_val(values);
        // SAFETY: the caller vouches for the room, and values of ours do not overlap the program's memory.
        unsafe { values.as_ptr().cast::<u8>().copy_to_nonoverlapping(pointer.cast::<u8>(), bytes) }
    };
    (!pointer.is_null()).then_some(write)
}
