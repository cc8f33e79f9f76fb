// SPDX-License-Identifier: GPL-3.0-or-later
//! libOpenRT: the OpenRT C API on GNU RT. It exports only the functions of `openrt/rt.h`.
//!
//! `ffi*.rs` hold the exported functions and all of the `unsafe` code: they turn pointers into values and call the
//! safe state machine, `context::Context`, whose calls are in `calls`, one file per noun. Each file imports
//! only from the right in this order: `ffi_*`, `calls`, `context`, `frame` and `stage`, `state`. No panic
//! crosses to C.
//!
//! Limits today: an updated object's tree is rebuilt.
#![deny(unsafe_code)]
#![allow(non_snake_case, reason = "the library is called libOpenRT")]

mod calls;
mod context;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi;
#[expect(unsafe_code, reason = "C calls in")]
mod ffi_frame;
#[expect(unsafe_code, reason = "one value, many threads")]
mod ffi_lock;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_matrix;
#[expect(unsafe_code, reason = "C calls in")]
mod ffi_object;
#[expect(unsafe_code, reason = "pointers of C")]
mod ffi_pointers;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_shader;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_texture;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_vertex;
mod frame;
#[cfg(any(test, fuzzing))]
pub mod random;
mod stage;
mod state;
