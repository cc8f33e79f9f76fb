// SPDX-License-Identifier: GPL-3.0-or-later
//! The boundary between C and the safe state machine: the one context behind a mutex, pointers, and context
//! calls. Every exported function goes through [`perform`]: it takes the lock, makes the context if there is
//! none, notes errors, and lets no panic cross to C. A shader that calls the library while the library waits
//! for it gets an error. Functions are `C-unwind`: exceptions of the program's own function pass to the
//! program.
//! Tests: the C programs of tests/c; bindings/openrt/tests/symbols.rs (exactly the functions of the header).

use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, LazyLock};

use gnurt_plugins::host::print_line;

use crate::context::Context;
use crate::ffi_lock::{Biased, Guard};
use crate::ffi_pointers::{text, writer};
use crate::state::error::{Error, Result, Writer};
use crate::state::listener::Listener;
use crate::state::report;

static CONTEXT: Biased<Option<Context>> = Biased::new(None);

/// Runs `work` on the context. An error, or a panic, is noted and reported, with the call as `shown` writes it, and
/// `on_error` returned.
#[inline]
pub(crate) fn perform<T>(
    shown: impl FnOnce() -> String,
    on_error: T,
    work: impl FnOnce(&mut Context) -> Result<T>,
) -> T {
    let Some(mut guard) = CONTEXT.enter() else { return reject(shown, on_error) };
    let context = match &mut *guard {
        Some(context) => context,
        none => none.insert(Context::default()),
    };
    match catch_unwind(AssertUnwindSafe(|| work(context))) {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => fail(guard, error, shown, on_error),
        Err(_) => fail(guard, internal_error(), shown, on_error),
    }
}

/// Reads the context, if there is one, and makes none. From within another call nothing can be seen: `blind`
/// it is.
pub(crate) fn look<T>(blind: T, at: impl FnOnce(Option<&Context>) -> T) -> T {
    CONTEXT.enter().map_or(blind, |guard| at(guard.as_ref()))
}

/// A call from within a call of the same thread: it would wait for itself, and nothing can be noted meanwhile.
#[cold]
fn reject<T>(shown: impl FnOnce() -> String, on_error: T) -> T {
    print_line(format_args!(
        "{} was called by a shader while the library waits for that shader: ignored",
        shown()
    ));
    on_error
}

/// Records an error and reports it after the lock is released, because the listener may call back. An
/// exception that leaves the listener passes to the program: nothing here catches it, and all locks on its
/// path are released.
#[cold]
fn fail<T>(
    mut guard: Guard<'static, Option<Context>>,
    error: Error,
    shown: impl FnOnce() -> String,
    on_error: T,
) -> T {
    let context = guard.get_or_insert_with(Context::default);
    context.record(error);
    // Under the lock: from now on a replacement of the listener waits for it.
    let hearing = if LISTENING.get() { None } else { context.hearing() };
    drop(guard);
    if *PRINTS || hearing.is_some() {
        let call = shown();
        if *PRINTS {
            print_line(report::line(error, &call));
        }
        if let Some(hearing) = hearing {
            let _listening = Listening::begin();
            hearing.notify(error, &CString::new(call).unwrap_or_default());
        }
    }
    on_error
}

/// Whether OPENRT_DEBUG requests errors on the standard error output.
static PRINTS: LazyLock<bool> =
    LazyLock::new(|| std::env::var_os("OPENRT_DEBUG").is_some_and(|value| !value.is_empty() && value != "0"));

thread_local! {
    /// Whether this thread's listener is being called: it is not called for errors of its own calls.
    static LISTENING: Cell<bool> = const { Cell::new(false) };
}

/// While it lives, this thread's listener is being called.
struct Listening;

impl Listening {
    fn begin() -> Self {
        LISTENING.set(true);
        Self
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        LISTENING.set(false);
    }
}

/// Waits until a replaced listener has returned on all threads. A listener that replaces itself, or another
/// one, does not wait: the others may be waiting for it.
fn wait_for(replaced: Option<Arc<Listener>>) {
    if let Some(replaced) = replaced.filter(|_| !LISTENING.get()) {
        replaced.wait();
    }
}

/// The error for a panic, whose message has already been printed.
#[cold]
fn internal_error() -> Error {
    print_line("this is a bug in libOpenRT; the call failed");
    Error::InvalidOperation
}

/// [`perform`] with the name and the arguments of the function that makes it.
macro_rules! call {
    ($name:ident($($argument:expr),*), $on_error:expr, |$context:ident| $work:expr) => {
        $crate::ffi::perform(
            || {
                let arguments: &[String] =
                    &[$($crate::state::report::Shown::text(&$argument, stringify!($argument))),*];
                format!("{}({})", stringify!($name), arguments.join(", "))
            },
            $on_error,
            |$context| $work,
        )
    };
}
pub(crate) use call;

/// Exports functions that return nothing and take no pointers.
macro_rules! procedures {
    ($($name:ident($($argument:ident: $type:ty),*) => |$context:ident| $work:expr;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C-unwind" fn $name($($argument: $type),*) {
            $crate::ffi::call!($name($($argument),*), (), |$context| $work);
        }
    )*};
}
pub(crate) use procedures;

/// Exports functions that return an id and take no pointers.
macro_rules! id_functions {
    ($($name:ident($($argument:ident: $type:ty),*) => |$context:ident| $work:expr;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C-unwind" fn $name($($argument: $type),*) -> u32 {
            $crate::ffi::call!($name($($argument),*), $crate::state::ids::RT_INVALID, |$context| $work)
        }
    )*};
}
pub(crate) use id_functions;

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
    let mut retained = 0;
    for i in 0..length {
        // SAFETY: the caller vouches for the entries being texts; null ones are passed over.
        let argument = unsafe { text(entries[i]) }.map(CStr::to_bytes).unwrap_or_default();
        if argument.starts_with(b"--rt-") {
            taken.push(argument.to_vec());
        } else {
            entries[retained] = entries[i];
            retained += 1;
        }
    }
    // As in every list of arguments of C, a null pointer follows the last one.
    entries[retained..].fill(std::ptr::null_mut());
    // SAFETY: as above; `retained` is at most the length that was there.
    unsafe { *count = retained as c_int };
    taken
}

/// # Safety
/// As openrt/rt.h says: pointers are null or those of main.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtInit(count: *mut c_int, list: *mut *mut c_char) {
    let shown = || "rtInit()".to_owned();
    let Some(mut guard) = CONTEXT.enter() else { return reject(shown, ()) };
    if guard.is_some() {
        return fail(guard, Error::InvalidOperation, shown, ());
    }
    // SAFETY: the caller vouches for main's arguments.
    let taken = unsafe { take_arguments(count, list) };
    *guard = Some(Context::with_arguments(taken.iter().map(|argument| &argument[..])));
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtExit() {
    let may_leave = call!(rtExit(), false, |context| context.exit().map(|()| true));
    if may_leave {
        let mut context = CONTEXT.enter().and_then(|mut guard| guard.take());
        let listener = context.as_mut().and_then(|context| context.listener.take());
        // Dropping frees everything; a panic in it must not cross to C, and there is no context left to note it.
        let dropped = catch_unwind(AssertUnwindSafe(|| drop(context)));
        dropped.unwrap_or_else(|_| print_line("this is a bug in libOpenRT; rtExit did not finish"));
        wait_for(listener);
    }
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtGetError() -> u32 {
    call!(rtGetError(), Error::NONE_CODE, |context| context.take_error())
}

/// The parameter of rtDebugCallback. Exceptions may leave it.
type DebugFunction = unsafe extern "C-unwind" fn(u32, *const c_char, *mut c_void);

/// A program's pointer, handed back to it.
struct User(*mut c_void);

// SAFETY: the pointer is never followed; the program allows calls of its function from any of its threads.
unsafe impl Send for User {}
// SAFETY: as above.
unsafe impl Sync for User {}

/// # Safety
/// As openrt/rt.h says: `function` is null or may be called with `user` until the call that replaces it, or rtExit, has
/// returned.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtDebugCallback(function: Option<DebugFunction>, user: *mut c_void) {
    let user = User(user);
    let listener = function.map(|function| {
        Listener::new(move |error: Error, call: &CStr| {
            let User(user) = &user;
            // SAFETY: the caller guarantees that the function accepts these arguments; the text lives until
            // it returns.
            unsafe { function(error.code(), call.as_ptr(), *user) }
        })
    });
    wait_for(call!(rtDebugCallback(), None, |context| context.set_listener(listener)));
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtGetString(name: u32) -> *const u8 {
    call!(rtGetString(name), std::ptr::null(), |context| context
        .get_string(name)
        .map(|text| text.as_ptr().cast()))
}

/// # Safety
/// As openrt/rt.h says: `values` is null or has room for the value's numbers.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtGetIntegerv(name: u32, values: *mut i32) {
    // SAFETY: the caller vouches for the room.
    let mut write = unsafe { writer(values) };
    call!(rtGetIntegerv(name, values), (), |context| context
        .get_integers(name, write.as_mut().map(|w| w as Writer<'_, i32>)));
}

/// # Safety
/// As openrt/rt.h says: `values` is null or has room for the value's numbers.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtGetFloatv(name: u32, values: *mut f32) {
    // SAFETY: the caller vouches for the room.
    let mut write = unsafe { writer(values) };
    call!(rtGetFloatv(name, values), (), |context| context
        .get_floats(name, write.as_mut().map(|w| w as Writer<'_, f32>)));
}
