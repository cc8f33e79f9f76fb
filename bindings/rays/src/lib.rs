// SPDX-License-Identifier: GPL-3.0-or-later
//! libgnurt: ray queries for C programs. It has two APIs on the same trees: `gnurt/rays.h`, and the calls of
//! Embree 4.
//!
//! `ffi*.rs` hold the exported functions and all of the `unsafe` code. Embree's calls: `ffi_device.rs`,
//! `ffi_scene.rs`, `ffi_geometry.rs`, `ffi_arrays.rs` edit the objects of `objects.rs`, and `commit.rs`
//! builds from them. `ffi_trace.rs` and `ffi_point.rs` trace queries, `ffi_filter.rs` and `ffi_user.rs` call
//! the program from trees, `ffi_forward.rs` forwards rays to other scenes. Those of `gnurt/rays.h`:
//! `ffi_rays.rs` edits the scene of `ray_scene.rs`, which also builds it; `ffi_query.rs` traces queries. No
//! panic crosses to C. docs/reference/c-rays.md is the manual.
#![deny(unsafe_code)]
#![allow(non_snake_case, reason = "C calls have C names")]

mod commit;
mod device;
mod ffi_abi;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_absent;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_arrays;
#[expect(unsafe_code, reason = "functions of C programs")]
mod ffi_callbacks;
#[expect(unsafe_code, reason = "a frame that catches, and what it catches")]
mod ffi_catch;
#[expect(unsafe_code, reason = "memory of C programs")]
mod ffi_columns;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_device;
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
mod ffi_memory;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_point;
#[expect(unsafe_code, reason = "a pointer to what never changes")]
mod ffi_present;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_query;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_rays;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_scene;
#[expect(unsafe_code, reason = "C calls in, with pointers")]
mod ffi_trace;
#[expect(unsafe_code, reason = "functions of C programs")]
mod ffi_user;
mod found;
mod free_ids;
mod located;
mod objects;
mod pools;
mod ray_scene;
mod transform;
