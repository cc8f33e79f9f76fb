// SPDX-License-Identifier: GPL-3.0-or-later
//! Callbacks of the program for notifications, made safe to call; and exceptions of callbacks during a query.
//! Their exceptions end here, except those of error functions, which go on to the program: decision 0017.
//! Invariant: the maker of one guarantees that it may be called, with its pointer, until it is replaced.

use std::cell::Cell;
use std::ffi::{CStr, c_char, c_uint, c_void};

use crate::ffi_catch::{self, Thrown};
use crate::ffi_memory::Pointer;

/// `RTCErrorFunction`.
pub(crate) type ErrorFunction = unsafe extern "C-unwind" fn(*mut c_void, c_uint, *const c_char);
/// `RTCMemoryMonitorFunction`.
pub(crate) type MemoryFunction = unsafe extern "C-unwind" fn(*mut c_void, isize, bool) -> bool;
/// `RTCProgressMonitorFunction`.
pub(crate) type ProgressFunction = unsafe extern "C-unwind" fn(*mut c_void, f64) -> bool;

thread_local! {
    /// Whether a function of the program has thrown an exception in this thread's query.
    static THROWN: Cell<bool> = const { Cell::new(false) };
}

/// Calls the program during a query, which has `stopped` after an exception: nothing is called then, and the
/// result is `None`.
#[inline]
pub(crate) fn call_program<R>(stopped: &Cell<bool>, call: impl FnOnce() -> R) -> Option<R> {
    if stopped.get() {
        return None;
    }
    let stop = |Thrown| {
        stopped.set(true);
        THROWN.set(true);
    };
    ffi_catch::call(call).map_err(stop).ok()
}

/// Whether an exception came that was not taken yet.
pub(crate) fn has_thrown() -> bool {
    THROWN.get()
}

/// Whether exceptions came since the last call of this.
pub(crate) fn take_thrown() -> Result<(), Thrown> {
    if THROWN.take() { Err(Thrown) } else { Ok(()) }
}

/// A function and the pointer that it is called with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Callback<F> {
    function: F,
    user: Pointer,
}

impl<F> Callback<F> {
    /// # Safety
    /// The function may be called with the pointer, from any thread, while this exists.
    pub(crate) unsafe fn new(function: Option<F>, user: *mut c_void) -> Option<Self> {
        function.map(|function| Self { function, user: Pointer(user) })
    }
}

impl Callback<ErrorFunction> {
    /// Its exceptions go on to the program's handler.
    pub(crate) fn call(&self, code: u32, message: &CStr) {
        // SAFETY: guaranteed by the maker of this; the text lives during the call.
        unsafe { (self.function)(self.user.0, code, message.as_ptr()) }
    }
}

impl Callback<MemoryFunction> {
    /// Whether the program allows this many bytes more.
    pub(crate) fn call(&self, bytes: i64, after: bool) -> Result<bool, Thrown> {
        // SAFETY: guaranteed by the maker of this.
        ffi_catch::call(|| unsafe { (self.function)(self.user.0, bytes as isize, after) })
    }
}

impl Callback<ProgressFunction> {
    /// Whether to go on.
    pub(crate) fn call(&self, done: f64) -> Result<bool, Thrown> {
        // SAFETY: guaranteed by the maker of this.
        ffi_catch::call(|| unsafe { (self.function)(self.user.0, done) })
    }
}
