// SPDX-License-Identifier: GPL-3.0-or-later
//! The door between C and the safe state machine: the one context behind a mutex, pointers, and context calls.
//! Source: original. Every exported function goes through [`call`]: it takes the lock, makes the context if there is
//! none, notes errors, and lets no panic cross to C. Pointers become options here; the state machine decides when a
//! null pointer is an error, because other errors come first.
//! Proof: the C programs of tests/c; bindings/openrt/tests/symbols.rs (exactly the functions of the header).

use std::ffi::{CStr, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::context::Context;
use crate::error::{Error, Result, Writer};

static CONTEXT: Mutex<Option<Context>> = Mutex::new(None);

fn lock() -> MutexGuard<'static, Option<Context>> {
    // Panics are caught while the lock is held, so it is never poisoned; and if it were, the context is still there.
    CONTEXT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `work` on the context. An error, or a panic, is noted and `on_error` returned.
#[inline]
pub(crate) fn call<T>(on_error: T, work: impl FnOnce(&mut Context) -> Result<T>) -> T {
    let mut guard = lock();
    let context = guard.get_or_insert_with(Context::default);
    let outcome = catch_unwind(AssertUnwindSafe(|| work(context)));
    outcome.unwrap_or_else(|_| Err(internal_error())).unwrap_or_else(|error| {
        context.record(error);
        on_error
    })
}

/// What a panic becomes; its message has been printed by the panic itself.
#[cold]
fn internal_error() -> Error {
    eprintln!("libOpenRT: this is a bug in libOpenRT; the call failed");
    Error::InvalidOperation
}

/// Exports functions that return nothing and take no pointers.
macro_rules! procedures {
    ($($name:ident($($argument:ident: $type:ty),*) => |$context:ident| $work:expr;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($($argument: $type),*) {
            $crate::ffi::call((), |$context| $work);
        }
    )*};
}
pub(crate) use procedures;

/// Exports functions that return an id and take no pointers.
macro_rules! id_functions {
    ($($name:ident($($argument:ident: $type:ty),*) => |$context:ident| $work:expr;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($($argument: $type),*) -> u32 {
            $crate::ffi::call($crate::ids::RT_INVALID, |$context| $work)
        }
    )*};
}
pub(crate) use id_functions;

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

/// What copies values to `pointer`, or `None` if it is null.
///
/// # Safety
/// A pointer that is not null points to room for all values that will be written; it need not be aligned.
pub(crate) unsafe fn writer<T: Copy>(pointer: *mut T) -> Option<impl FnMut(&[T])> {
    let write = move |values: &[T]| {
        let bytes = size_of_val(values);
        // SAFETY: the caller vouches for the room, and values of ours do not overlap the program's memory.
        unsafe { values.as_ptr().cast::<u8>().copy_to_nonoverlapping(pointer.cast::<u8>(), bytes) }
    };
    (!pointer.is_null()).then_some(write)
}

/// `--rt-` arguments, taken out of the program's list.
///
/// # Safety
/// If neither is null, `count` points to the length of the array at `list`, whose entries are texts.
unsafe fn take_arguments(count: *mut c_int, list: *mut *mut c_char) -> Vec<Vec<u8>> {
    if count.is_null() || list.is_null() {
        return Vec::new();
    }
    // SAFETY: `count` is not null, the caller vouches for it.
    let length = usize::try_from(unsafe { *count }).unwrap_or(0);
    // SAFETY: the caller vouches for `length` entries.
    let entries = unsafe { std::slice::from_raw_parts_mut(list, length) };
    let mut taken = Vec::new();
    let mut kept = 0;
    for i in 0..length {
        // SAFETY: the caller vouches for the entries being texts; null ones are passed over.
        let argument = unsafe { text(entries[i]) }.map(CStr::to_bytes).unwrap_or_default();
        if argument.starts_with(b"--rt-") {
            taken.push(argument.to_vec());
        } else {
            entries[kept] = entries[i];
            kept += 1;
        }
    }
    // As in every list of arguments of C, a null pointer follows the last one.
    entries[kept..].fill(std::ptr::null_mut());
    // SAFETY: as above; `kept` is at most the length that was there.
    unsafe { *count = kept as c_int };
    taken
}

/// # Safety
/// As openrt/rt.h says: pointers are null or those of main.
#[unsafe(no_mangle)]
unsafe extern "C" fn rtInit(count: *mut c_int, list: *mut *mut c_char) {
    let mut guard = lock();
    if let Some(context) = guard.as_mut() {
        return context.record(Error::InvalidOperation);
    }
    // SAFETY: the caller vouches for main's arguments.
    let taken = unsafe { take_arguments(count, list) };
    *guard = Some(Context::with_arguments(taken.iter().map(|argument| &argument[..])));
}

#[unsafe(no_mangle)]
extern "C" fn rtExit() {
    let may_leave = call(false, |context| context.exit().map(|()| true));
    if may_leave {
        let context = lock().take();
        // Dropping frees everything; a panic in it must not cross to C, and there is no context left to note it.
        let dropped = catch_unwind(AssertUnwindSafe(|| drop(context)));
        dropped.unwrap_or_else(|_| eprintln!("libOpenRT: this is a bug in libOpenRT; rtExit did not finish"));
    }
}

#[unsafe(no_mangle)]
extern "C" fn rtGetError() -> u32 {
    call(Error::NONE_CODE, |context| Ok(context.take_error()))
}

#[unsafe(no_mangle)]
extern "C" fn rtGetString(name: u32) -> *const u8 {
    call(std::ptr::null(), |context| context.get_string(name).map(|text| text.as_ptr().cast()))
}

/// # Safety
/// As openrt/rt.h says: `values` is null or has room for the value's numbers.
#[unsafe(no_mangle)]
unsafe extern "C" fn rtGetIntegerv(name: u32, values: *mut i32) {
    // SAFETY: the caller vouches for the room.
    let mut write = unsafe { writer(values) };
    call((), |context| context.get_integers(name, write.as_mut().map(|w| w as Writer<'_, i32>)));
}

/// # Safety
/// As openrt/rt.h says: `values` is null or has room for the value's numbers.
#[unsafe(no_mangle)]
unsafe extern "C" fn rtGetFloatv(name: u32, values: *mut f32) {
    // SAFETY: the caller vouches for the room.
    let mut write = unsafe { writer(values) };
    call((), |context| context.get_floats(name, write.as_mut().map(|w| w as Writer<'_, f32>)));
}
