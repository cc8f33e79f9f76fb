// SPDX-License-Identifier: GPL-3.0-or-later
//! Machine code for the shading language: a group of shaders for sixteen points at once, or for two times sixteen.
//!
//! Stages of a group: `lower` makes a program of it (control on masks, a bit for each point, and regions of
//! operations without branches). `control` and `region` make machine code of that; what they need of a
//! machine is the trait in `isa`. `x86` has it for AVX2 and AVX-512, `aarch64` for NEON. `ffi_memory` keeps
//! the code, `inputs` brings it the points, [`Lanes`] runs it. The library's functions are compiled in instead of called: they are written over a trait of
//! numbers, and `term` is a number that records its operations. The interpreter executes operations without
//! code (texts, messages, closures, queries of the renderer), lane by lane, in the middle of the code.
//!
//! Two batches in one run share control flow: a row of memory has 32 numbers, and the code of a region is written for the
//! first sixteen points and then for the others, with the same registers. Neither waits for the other, so the processor
//! overlaps chains of operations by itself. Calls out of the code are made for each batch by itself.
//!
//! Invariant: the interpreter defines the meaning. Every value has its bits, except for those of NaNs.
//! Tests: `tests/`.

#![cfg_attr(
    not(all(any(target_arch = "x86_64", target_arch = "aarch64"), any(unix, windows))),
    allow(dead_code, reason = "other machines have no code: the interpreter runs")
)]

mod aarch64;
mod cache;
mod compiled;
mod control;
mod engine;
mod ffi_call;
mod ffi_memory;
mod fingerprint;
mod inputs;
mod isa;
mod lanes;
mod layout;
mod lower;
mod op;
mod program;
mod region;
mod term;
mod x86;

pub use cache::{Cache, Job};
pub use compiled::{Compiled, NoCode};
pub use engine::engine;
pub use lanes::Lanes;
