// SPDX-License-Identifier: GPL-3.0-or-later
//! libOpenRT: the OpenRT C API on GNU RT.
//!
//! `ffi*.rs` hold the exported functions and all of the `unsafe` code: they turn pointers into values and call the
//! safe state machine, [`context::Context`], whose calls are in one file per noun. No panic crosses to C.
//!
//! Limits today: an updated object's tree is built anew.
#![deny(unsafe_code)]
#![allow(non_snake_case, reason = "the library is called libOpenRT")]

pub mod block;
pub mod camera;
pub mod class;
pub mod context;
pub mod current;
pub mod enums;
pub mod error;
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
#[expect(unsafe_code, reason = "plugins describe the memory")]
mod ffi_plugin_block;
#[expect(unsafe_code, reason = "plugins call in, with pointers")]
mod ffi_plugin_host;
#[expect(unsafe_code, reason = "plugins read and write arrays")]
mod ffi_plugin_lanes;
#[expect(unsafe_code, reason = "code is loaded")]
mod ffi_plugin_library;
#[expect(unsafe_code, reason = "plugins are called")]
mod ffi_plugin_shader;
#[expect(unsafe_code, reason = "a child process is made")]
mod ffi_plugin_trial;
#[expect(unsafe_code, reason = "structures of C")]
mod ffi_rts;
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
pub mod plugin_class;
#[cfg(test)]
mod plugin_cost;
pub mod plugin_frame;
pub mod plugin_load;
mod plugin_search;
pub mod primitives;
pub mod progressive;
pub mod query;
pub mod rendering_object;
pub mod report;
pub mod scene_shader;
pub mod shader;
pub mod shader_class;
pub mod stacks;
pub mod stage;
pub mod texture;
pub mod usage;
