// SPDX-License-Identifier: GPL-3.0-or-later
//! Calls of the program's functions that exceptions may leave: they end here and become a value.
//! Source: the Itanium C++ ABI, "Exception Handling"; the same frame as in `crates/plugins/src/ffi_catch.rs`, where the way it works
//! is told (decision 0017): neither crate may use the other. The C++ runtime is found among the libraries of the process.
//! Invariant: nothing unwinds out of [`call`] but forced unwinding. Where: Linux on x86-64 and aarch64; elsewhere an exception
//! ends the process at the next `catch_unwind`. Tests: `tests/c/throws.cpp`.

use std::ffi::{CStr, c_char, c_void};
use std::fmt;

/// An exception left the call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Thrown;

impl fmt::Display for Thrown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a function of the program has thrown an exception")
    }
}

/// Calls `work`. An exception that leaves it has ended, and its object is gone, when this returns.
#[inline]
pub(crate) fn call<R>(work: impl FnOnce() -> R) -> Result<R, Thrown> {
    let mut answer = None;
    let exception = catcher::call(|| answer = Some(work()));
    match answer {
        Some(answer) if exception.is_null() => Ok(answer),
        _ => {
            end(exception);
            Err(Thrown)
        }
    }
}

/// Ends an exception that was caught.
#[cold]
fn end(exception: *mut c_void) {
    if exception.is_null() {
        return;
    }
    // SAFETY: an exception begins with eight bytes that say whose it is.
    let class = unsafe { exception.cast::<u64>().read_unaligned() }.to_be_bytes();
    match cpp() {
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
}

type BeginCatch = unsafe extern "C" fn(*mut c_void) -> *mut c_void;
type EndCatch = unsafe extern "C" fn();

/// Without a loader of this kind there is no C++ runtime.
#[cfg(not(unix))]
fn cpp() -> Option<(BeginCatch, EndCatch)> {
    None
}

/// The C++ runtime of the process, which counts the exceptions in progress; none where it is not visible to
/// all libraries.
#[cfg(unix)]
fn cpp() -> Option<(BeginCatch, EndCatch)> {
    unsafe extern "C" {
        fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
    }
    /// # Safety
    /// `F` is the type of the function of this name.
    unsafe fn find<F: Copy>(name: &CStr) -> Option<F> {
        // SAFETY: a null pointer is for all libraries that are seen by all, and the name ends with a zero.
        let found = unsafe { dlsym(std::ptr::null_mut(), name.as_ptr()) };
        // SAFETY: pointers to functions are as large as others on every system that has `dlsym`.
        (!found.is_null()).then(|| unsafe { (&raw const found).cast::<F>().read() })
    }
    // SAFETY: the C++ ABI defines the types of the functions of these names. They stay as long as the library.
    unsafe { find::<BeginCatch>(c"__cxa_begin_catch").zip(find::<EndCatch>(c"__cxa_end_catch")) }
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod catcher {
    use std::ffi::{c_int, c_void};

    // `gnurt_rays_call(function, argument)` calls the function and returns 0; or, where the personality has sent an
    // exception to `gnurt_rays_landing`, the exception.
    #[cfg(target_arch = "x86_64")]
    std::arch::global_asm!(
        ".pushsection .text.gnurt_rays_call,\"ax\",@progbits",
        ".globl gnurt_rays_call",
        ".hidden gnurt_rays_call",
        ".type gnurt_rays_call,@function",
        ".globl gnurt_rays_landing",
        ".hidden gnurt_rays_landing",
        "gnurt_rays_call:",
        ".cfi_startproc",
        // Indirect, relative to its own address, four bytes: as position-independent code of others has it.
        ".cfi_personality 155, gnurt_rays_personality_at",
        "push rbp",
        ".cfi_def_cfa_offset 16",
        ".cfi_offset rbp, -16",
        "mov rbp, rsp",
        ".cfi_def_cfa_register rbp",
        "mov rax, rdi",
        "mov rdi, rsi",
        "call rax",
        "xor eax, eax",
        "gnurt_rays_landing:",
        "pop rbp",
        ".cfi_def_cfa rsp, 8",
        "ret",
        ".cfi_endproc",
        ".size gnurt_rays_call, .-gnurt_rays_call",
        ".popsection",
        ".pushsection .data.rel.ro.gnurt_rays,\"aw\",@progbits",
        ".balign 8",
        "gnurt_rays_personality_at:",
        ".quad {personality}",
        ".popsection",
        personality = sym personality,
    );

    #[cfg(target_arch = "aarch64")]
    std::arch::global_asm!(
        ".pushsection .text.gnurt_rays_call,\"ax\",@progbits",
        ".balign 4",
        ".globl gnurt_rays_call",
        ".hidden gnurt_rays_call",
        ".type gnurt_rays_call,@function",
        ".globl gnurt_rays_landing",
        ".hidden gnurt_rays_landing",
        "gnurt_rays_call:",
        ".cfi_startproc",
        ".cfi_personality 155, gnurt_rays_personality_at",
        "stp x29, x30, [sp, #-16]!",
        ".cfi_def_cfa_offset 16",
        ".cfi_offset x29, -16",
        ".cfi_offset x30, -8",
        "mov x29, sp",
        "mov x2, x0",
        "mov x0, x1",
        "blr x2",
        "mov x0, xzr",
        "gnurt_rays_landing:",
        "ldp x29, x30, [sp], #16",
        "ret",
        ".cfi_endproc",
        ".size gnurt_rays_call, .-gnurt_rays_call",
        ".popsection",
        ".pushsection .data.rel.ro.gnurt_rays,\"aw\",@progbits",
        ".balign 8",
        "gnurt_rays_personality_at:",
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
        static gnurt_rays_landing: u8;
        fn _Unwind_SetGR(context: *mut c_void, register: c_int, value: usize);
        fn _Unwind_SetIP(context: *mut c_void, shown_instance: usize);
        fn _Unwind_DeleteException(exception: *mut c_void);
    }

    unsafe extern "C-unwind" {
        fn gnurt_rays_call(
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
        // SAFETY: the context is the unwinder's, and of the frame above: it goes on at its landing with the exception.
        unsafe {
            _Unwind_SetGR(context, RESULT, exception.addr());
            _Unwind_SetIP(context, (&raw const gnurt_rays_landing).addr());
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
        unsafe { gnurt_rays_call(thunk::<F>, (&raw mut work).cast()) }
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
