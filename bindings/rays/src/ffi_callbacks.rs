// SPDX-License-Identifier: GPL-3.0-or-later
//! Functions of the program's that are told what happens, made safe to call. Source: original.
//! Invariant: who makes one vouches that it may be called, with its pointer, until it is replaced.

use std::ffi::{CStr, c_char, c_uint, c_void};

use crate::ffi_memory::Pointer;

/// `RTCErrorFunction`.
pub(crate) type ErrorFunction = unsafe extern "C" fn(*mut c_void, c_uint, *const c_char);
/// `RTCMemoryMonitorFunction`.
pub(crate) type MemoryFunction = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;
/// `RTCProgressMonitorFunction`.
pub(crate) type ProgressFunction = unsafe extern "C" fn(*mut c_void, f64) -> bool;

/// A function and the pointer that it is called with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Callback<F> {
    function: F,
    user: Pointer,
}

impl<F> Callback<F> {
    /// # Safety
    /// The function may be called with the pointer, from any thread, as long as this is kept.
    pub(crate) unsafe fn new(function: Option<F>, user: *mut c_void) -> Option<Self> {
        function.map(|function| Self { function, user: Pointer(user) })
    }
}

impl Callback<ErrorFunction> {
    pub(crate) fn call(&self, code: u32, message: &CStr) {
        // SAFETY: vouched for by who made this; the text lives during the call.
        unsafe { (self.function)(self.user.0, code, message.as_ptr()) }
    }
}

impl Callback<MemoryFunction> {
    /// Whether so many bytes more may be held.
    pub(crate) fn call(&self, bytes: i64, after: bool) -> bool {
        // SAFETY: vouched for by who made this.
        unsafe { (self.function)(self.user.0, bytes as isize, after) }
    }
}

impl Callback<ProgressFunction> {
    /// Whether to go on.
    pub(crate) fn call(&self, done: f64) -> bool {
        // SAFETY: vouched for by who made this.
        unsafe { (self.function)(self.user.0, done) }
    }
}
