// SPDX-License-Identifier: GPL-3.0-or-later
//! libOpenRT: the OpenRT C API on GNU RT.
//!
//! `ffi*.rs` hold the exported functions and all of the `unsafe` code: they turn pointers into values and call the
//! safe state machine, [`context::Context`], whose calls are in one file per noun. No panic crosses to C.
//!
//! Limits today: shader classes are the built-in ones; an updated object's tree is built anew.
#![deny(unsafe_code)]
#![allow(non_snake_case, reason = "the library is called libOpenRT")]

pub mod block;
pub mod camera;
pub mod context;
pub mod current;
pub mod enums;
pub mod error;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi;
#[expect(unsafe_code, reason = "C calls in")]
mod ffi_frame;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_matrix;
#[expect(unsafe_code, reason = "C calls in")]
mod ffi_object;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_shader;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_texture;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_vertex;
pub mod flight;
pub mod frame;
pub mod framebuffer;
pub mod geometry;
pub mod ids;
pub mod instance;
pub mod matrix;
pub mod object;
pub mod parameter;
pub mod primitives;
pub mod progressive;
pub mod query;
pub mod report;
pub mod shader;
pub mod shader_class;
pub mod stacks;
pub mod stage;
pub mod texture;
pub mod usage;
