// SPDX-License-Identifier: GPL-3.0-or-later
//! Calls that exceptions may leave: C++'s, or those of another Rust runtime, end here and become a value.
//! Source: the Itanium C++ ABI, "Exception Handling", for personality routines. `catch_unwind` would end the
//! process at a foreign exception. Here a frame of a few instructions has a personality routine of ours,
//! which catches all; between it and the plugin there are only `C-unwind` functions.
//! Invariant: only forced unwinding, which must not be stopped, leaves [`Runtime::call`]. Where: Linux on
//! x86-64 and aarch64. Elsewhere an exception continues and ends the process at the next frame of ours.
//! Tests: `tests`; bindings/openrt/tests/exceptions.rs (C++).

use std::ffi::c_void;

/// An exception left the call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Thrown;

type BeginCatch = unsafe extern "C" fn(*mut c_void) -> *mut c_void;
type EndCatch = unsafe extern "C" fn();

/// The C++ runtime that a library was linked with, which counts the exceptions in progress; none if it has
/// none.
#[derive(Clone, Copy, Default)]
pub(crate) struct Runtime {
    catch: Option<(BeginCatch, EndCatch)>,
}

impl Runtime {
    /// That of a library.
    pub(crate) fn of(library: &libloading::Library) -> Self {
        // SAFETY: the C++ ABI defines the types of the functions of these names. They stay as long as the
        // library.
        let (begin, end) = unsafe {
            let begin = library.get::<BeginCatch>(b"__cxa_begin_catch\0").map(|symbol| *symbol);
            (begin, library.get::<EndCatch>(b"__cxa_end_catch\0").map(|symbol| *symbol))
        };
        Self { catch: begin.ok().zip(end.ok()) }
    }

    /// Calls `work`. An exception that leaves it has ended, and its object is gone, when this returns.
    pub(crate) fn call(self, work: impl FnOnce()) -> Result<(), Thrown> {
        let exception = catcher::call(work);
        if exception.is_null() {
            return Ok(());
        }
        // SAFETY: an exception begins with eight bytes that identify its origin.
        let class = unsafe { exception.cast::<u64>().read_unaligned() }.to_be_bytes();
        match self.catch {
            Some((begin, end)) if class[4..7] == *b"C++" => {
                // SAFETY: it is C++'s, was caught, and is ended in the same manner as by `catch (...) {}`.
                unsafe {
                    begin(exception);
                    end();
                }
            }
            // The runtime of a Rust that is not ours ends the process if its panics are deleted by others: it stays.
            _ if class == *b"MOZ\0RUST" => {}
            // SAFETY: it was caught, and there is no other reference to it.
            _ => unsafe { catcher::delete(exception) },
        }
        Err(Thrown)
    }
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod catcher {
    use std::ffi::{c_int, c_void};

    // `gnurt_plugins_call(function, argument)` calls the function and returns 0; or, where the personality has sent an
    // exception to `gnurt_plugins_landing`, the exception.
    #[cfg(target_arch = "x86_64")]
    std::arch::global_asm!(
        ".pushsection .text.gnurt_plugins_call,\"ax\",@progbits",
        ".globl gnurt_plugins_call",
        ".hidden gnurt_plugins_call",
        ".type gnurt_plugins_call,@function",
        ".globl gnurt_plugins_landing",
        ".hidden gnurt_plugins_landing",
        "gnurt_plugins_call:",
        ".cfi_startproc",
        // Indirect, relative to its own address, four bytes: as position-independent code of others has it.
        ".cfi_personality 155, gnurt_plugins_personality_at",
        "push rbp",
        ".cfi_def_cfa_offset 16",
        ".cfi_offset rbp, -16",
        "mov rbp, rsp",
        ".cfi_def_cfa_register rbp",
        "mov rax, rdi",
        "mov rdi, rsi",
        "call rax",
        "xor eax, eax",
        "gnurt_plugins_landing:",
        "pop rbp",
        ".cfi_def_cfa rsp, 8",
        "ret",
        ".cfi_endproc",
        ".size gnurt_plugins_call, .-gnurt_plugins_call",
        ".popsection",
        ".pushsection .data.rel.ro.gnurt_plugins,\"aw\",@progbits",
        ".balign 8",
        "gnurt_plugins_personality_at:",
        ".quad {personality}",
        ".popsection",
        personality = sym personality,
    );

    #[cfg(target_arch = "aarch64")]
    std::arch::global_asm!(
        ".pushsection .text.gnurt_plugins_call,\"ax\",@progbits",
        ".balign 4",
        ".globl gnurt_plugins_call",
        ".hidden gnurt_plugins_call",
        ".type gnurt_plugins_call,@function",
        ".globl gnurt_plugins_landing",
        ".hidden gnurt_plugins_landing",
        "gnurt_plugins_call:",
        ".cfi_startproc",
        ".cfi_personality 155, gnurt_plugins_personality_at",
        "stp x29, x30, [sp, #-16]!",
        ".cfi_def_cfa_offset 16",
        ".cfi_offset x29, -16",
        ".cfi_offset x30, -8",
        "mov x29, sp",
        "mov x2, x0",
        "mov x0, x1",
        "blr x2",
        "mov x0, xzr",
        "gnurt_plugins_landing:",
        "ldp x29, x30, [sp], #16",
        "ret",
        ".cfi_endproc",
        ".size gnurt_plugins_call, .-gnurt_plugins_call",
        ".popsection",
        ".pushsection .data.rel.ro.gnurt_plugins,\"aw\",@progbits",
        ".balign 8",
        "gnurt_plugins_personality_at:",
        ".xword {personality}",
        ".popsection",
        personality = sym personality,
    );

    /// The unwinder's requests.
    const SEARCH_PHASE: c_int = 1;
    const HANDLER_FRAME: c_int = 4;
    const FORCE_UNWIND: c_int = 8;
    /// The answers.
    const HANDLER_FOUND: c_int = 6;
    const INSTALL_CONTEXT: c_int = 7;
    const CONTINUE_UNWIND: c_int = 8;
    /// The register that functions return pointers in, on both machines.
    const RESULT: c_int = 0;

    unsafe extern "C" {
        static gnurt_plugins_landing: u8;
        fn _Unwind_SetGR(context: *mut c_void, register: c_int, value: usize);
        fn _Unwind_SetIP(context: *mut c_void, folder: usize);
        fn _Unwind_DeleteException(exception: *mut c_void);
    }

    unsafe extern "C-unwind" {
        fn gnurt_plugins_call(
            function: unsafe extern "C-unwind" fn(*mut c_void),
            argument: *mut c_void,
        ) -> *mut c_void;
    }

    /// Every exception that comes to the frame is caught there.
    unsafe extern "C" fn personality(
        _version: c_int,
        actions: c_int,
        _class: u64,
        exception: *mut c_void,
        context: *mut c_void,
    ) -> c_int {
        if actions & FORCE_UNWIND != 0 {
            return CONTINUE_UNWIND;
        }
        if actions & SEARCH_PHASE != 0 {
            return HANDLER_FOUND;
        }
        if actions & HANDLER_FRAME == 0 {
            return CONTINUE_UNWIND;
        }
        // SAFETY: the context is the unwinder's, and of the frame above: it continues at its landing with the
        // exception.
        unsafe {
            _Unwind_SetGR(context, RESULT, exception.addr());
            _Unwind_SetIP(context, (&raw const gnurt_plugins_landing).addr());
        }
        INSTALL_CONTEXT
    }

    /// Calls `work`, once; null, or the exception that left it.
    pub(super) fn call<F: FnOnce()>(work: F) -> *mut c_void {
        /// # Safety
        /// `work` points to an `Option<F>` without other users.
        unsafe extern "C-unwind" fn thunk<F: FnOnce()>(work: *mut c_void) {
            // SAFETY: the caller vouches for it.
            let work = unsafe { &mut *work.cast::<Option<F>>() };
            if let Some(work) = work.take() {
                work();
            }
        }
        let mut work = Some(work);
        // SAFETY: the function takes its argument, which lives until it returns.
        unsafe { gnurt_plugins_call(thunk::<F>, (&raw mut work).cast()) }
    }

    /// # Safety
    /// The exception was caught and has no other references.
    pub(super) unsafe fn delete(exception: *mut c_void) {
        // SAFETY: the caller vouches for it.
        unsafe { _Unwind_DeleteException(exception) }
    }
}

#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod catcher {
    use std::ffi::c_void;

    pub(super) fn call(work: impl FnOnce()) -> *mut c_void {
        work();
        std::ptr::null_mut()
    }

    /// # Safety
    /// Never called: no exception is caught.
    pub(super) unsafe fn delete(_exception: *mut c_void) {}
}

#[cfg(all(test, target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::ffi::c_int;

    /// `_Unwind_Exception`, with space for the unwinder's data.
    #[repr(C, align(16))]
    struct Exception {
        class: u64,
        cleanup: Option<unsafe extern "C" fn(c_int, *mut Exception)>,
        private: [usize; 6],
    }

    unsafe extern "C-unwind" {
        fn _Unwind_RaiseException(exception: *mut Exception) -> c_int;
    }

    unsafe extern "C" fn cleanup(_reason: c_int, exception: *mut Exception) {
        // SAFETY: it came from a box, see `throw`.
        drop(unsafe { Box::from_raw(exception) });
        GONE.set(GONE.get() + 1);
    }

    thread_local!(static GONE: Cell<u32> = const { Cell::new(0) });

    fn throw() {
        let class = u64::from_be_bytes(*b"TESTTEST");
        let exception = Box::into_raw(Box::new(Exception { class, cleanup: Some(cleanup), private: [0; 6] }));
        // SAFETY: the exception is whole, and its cleanup frees it.
        let reason = unsafe { _Unwind_RaiseException(exception) };
        panic!("nobody has caught it: {reason}");
    }

    struct Dropped<'a>(&'a Cell<bool>);

    impl Drop for Dropped<'_> {
        fn drop(&mut self) {
            self.0.set(true);
        }
    }

    #[test]
    fn exceptions_become_values() {
        let runtime = Runtime::default();
        for round in 1..=3 {
            let (mut sum, dropped) = (0, Cell::new(false));
            assert_eq!(runtime.call(|| sum += 1), Ok(()), "nothing is thrown");
            let thrown = runtime.call(|| {
                let _held = Dropped(&dropped);
                sum += 1;
                throw();
            });
            assert_eq!((thrown, sum), (Err(Thrown), 2), "once each");
            assert!(dropped.get(), "what stood in its way was dropped");
            assert_eq!(GONE.get(), round, "its object is gone");
        }
        let nested = runtime.call(|| {
            assert_eq!(runtime.call(throw), Err(Thrown), "the inner one catches");
        });
        assert_eq!(nested, Ok(()), "and the outer one sees nothing");
    }
}
