// SPDX-License-Identifier: GPL-3.0-or-later
//! libgnurt: ray queries for C programs, by `gnurt/rays.h`. The calls of Embree 4 are those of another library,
//! `bindings/embree`.
//!
//! `ffi*.rs` hold the exported functions and all of the `unsafe` code. `ffi_rays.rs` edits the scene of `ray_scene.rs`, which
//! also builds it; `ffi_query.rs` traces queries. No panic crosses to C. docs/reference/c-rays.md is the manual.
#![deny(unsafe_code)]
#![allow(non_snake_case, reason = "C calls have C names")]

#[expect(unsafe_code, reason = "a frame that catches, and what it catches")]
mod ffi_catch;
#[expect(unsafe_code, reason = "memory of C programs")]
mod ffi_columns;
#[allow(dead_code, reason = "bindings/embree compiles it, too, and needs more of it")]
#[expect(unsafe_code, reason = "memory of C programs")]
mod ffi_memory;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_query;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_rays;
mod found;
mod pools;
mod ray_scene;
