// SPDX-License-Identifier: GPL-3.0-or-later
//! The calls of Embree 4 on GNU RT's trees: the library that `cargo xtask install` names libembree4.so.4.
//!
//! `ffi*.rs` hold the exported functions and all of the `unsafe` code. `ffi_device.rs`, `ffi_scene.rs`, `ffi_geometry.rs`,
//! `ffi_arrays.rs` edit the objects of `objects.rs`, and `commit.rs` builds from them. `ffi_trace.rs`, `ffi_point.rs` and
//! `ffi_collide.rs` answer queries, `ffi_filter.rs` and `ffi_user.rs` call the program from trees, `ffi_forward.rs` forwards rays to other
//! scenes. No panic crosses to C. docs/reference/c-rays.md is the manual. Tests: `tests/c/*.c`.
//!
//! Memory, exceptions and threads are files of libgnurt, compiled a second time: a library of both would export
//! the calls of both.
#![deny(unsafe_code)]
#![allow(non_snake_case, reason = "C calls have C names")]

mod builder;
mod cells;
mod commit;
mod cones;
mod control;
mod cut;
mod device;
mod ffi_abi;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_absent;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_arrays;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_build;
#[expect(unsafe_code, reason = "functions of C programs")]
mod ffi_callbacks;
#[expect(unsafe_code, reason = "a frame that catches, and what it catches")]
#[path = "../../rays/src/ffi_catch.rs"]
mod ffi_catch;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_collide;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_device;
#[expect(unsafe_code, reason = "functions of C programs")]
mod ffi_displace;
#[expect(unsafe_code, reason = "functions of C programs")]
mod ffi_filter;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_forward;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_geometry;
#[expect(unsafe_code, reason = "values behind pointers")]
mod ffi_handle;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_interpolate;
#[expect(unsafe_code, reason = "memory of C programs")]
mod ffi_lane;
#[expect(unsafe_code, reason = "memory of C programs")]
#[path = "../../rays/src/ffi_memory.rs"]
mod ffi_memory;
#[expect(unsafe_code, reason = "memory of ours in the form of the program's")]
mod ffi_own;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_point;
#[expect(unsafe_code, reason = "a pointer to what never changes")]
mod ffi_present;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_scene;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_subdivision;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_trace;
#[expect(unsafe_code, reason = "functions of C programs")]
mod ffi_user;
mod free_ids;
mod interpolate;
mod located;
mod objects;
#[path = "../../rays/src/pools.rs"]
mod pools;
mod transform;
