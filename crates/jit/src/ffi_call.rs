// SPDX-License-Identifier: GPL-3.0-or-later
//! Calls machine code, and is called by it.
//! The convention is that of the System V ABI on all systems with x86-64, and the system's own on ARM.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use crate::ffi_memory::Executable;

/// One line of the cache: memory starts where one does.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Line(pub(crate) [u32; 16]);

/// The words of lines.
pub(crate) fn cell_values(lines: &mut [Line]) -> &mut [u32] {
    let count = lines.len() * 16;
    // SAFETY: a line is sixteen words and nothing else.
    unsafe { std::slice::from_raw_parts_mut(lines.as_mut_ptr().cast(), count) }
}

/// The calls of machine code.
pub(crate) trait Calls {
    /// Does call `number`; the group's memory goes with it.
    fn call(&mut self, memory: &mut [u32], number: u32);
}

struct Context<'a, C> {
    calls: &'a mut C,
    memory: *mut u32,
    length: usize,
    panic: Option<Box<dyn Any + Send>>,
}

/// The crossing in both directions by a calling convention.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
macro_rules! crossing {
    ($convention:literal) => {
        extern $convention fn receive<C: Calls>(context: *mut Context<'_, C>, number: u32) {
            // SAFETY: `enter` passed this pointer to the code, and does not use its target until the code returns.
            let context = unsafe { &mut *context };
            if context.panic.is_some() {
                return;
            }
            // SAFETY: the memory that `enter` was given; the code does not touch it until this returns.
            let memory = unsafe { std::slice::from_raw_parts_mut(context.memory, context.length) };
            // A panic must not pass through code that has no tables for it.
            if let Err(panic) = catch_unwind(AssertUnwindSafe(|| context.calls.call(memory, number))) {
                context.panic = Some(panic);
            }
        }

        /// The function at the start of code.
        type Entry<'a, C> = extern $convention fn(
            *mut u32,
            *mut Context<'a, C>,
            extern $convention fn(*mut Context<'a, C>, u32),
            *const u8,
        );
    };
}

// One encoder serves all systems.
#[cfg(target_arch = "x86_64")]
crossing!("sysv64");
#[cfg(target_arch = "aarch64")]
crossing!("C");

/// Runs a layer's code, which starts `layer` bytes into it.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
pub(crate) fn enter<C: Calls>(code: &Executable, layer: u32, memory: &mut [Line], calls: &mut C) {
    let memory = cell_values(memory);
    let mut context = Context { calls, memory: memory.as_mut_ptr(), length: memory.len(), panic: None };
    #[expect(clippy::disallowed_methods, reason = "an address becomes a function: nothing else does that")]
    // SAFETY: `Isa::entry` puts a function of this type at the start of code, and `layer` is one of its
    // offsets. The memory has the layout of the code.
    let (entry, layer): (Entry<'_, C>, *const u8) = unsafe {
        (std::mem::transmute::<*const u8, Entry<'_, C>>(code.start()), code.start().add(layer as usize))
    };
    crate::ffi_memory::see_code();
    entry(context.memory, &mut context, receive::<C>, layer);
    if let Some(panic) = context.panic {
        resume_unwind(panic);
    }
}

/// There is no code for this kind of CPU: nothing comes here.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
pub(crate) fn enter<C: Calls>(code: &Executable, layer: u32, memory: &mut [Line], calls: &mut C) {
    let memory = cell_values(memory);
    let mut context = Context { calls, memory: memory.as_mut_ptr(), length: memory.len(), panic: None };
    let _ = (code.start(), layer, context.length, context.memory, catch_unwind(AssertUnwindSafe(|| ())));
    if let Some(panic) = context.panic.take() {
        resume_unwind(panic);
    }
    let _ = &mut context.calls;
    unreachable!("code is only made for x86-64 and aarch64");
}
