// SPDX-License-Identifier: GPL-3.0-or-later
//! The ANARI device of GNU RT: `anariLoadLibrary("gnurt")`.
//!
//! `ffi*.rs` hold the tables of functions that ANARI's loader calls and all of the `unsafe` code: `ffi_library.rs` is the entry,
//! `ffi_device.rs` a device's functions. `device.rs` and `object.rs` keep objects and parameters, `schema` describes them, `world.rs`
//! makes a scene of them, `frame.rs` and `picture.rs` render it. No panic crosses to the program.
//! docs/how-to/anari.md is the manual.
#![deny(unsafe_code)]

mod area_light;
mod attribute;
mod camera;
mod device;
mod ffi_abi;
#[expect(unsafe_code, reason = "memory of programs")]
mod ffi_array;
#[doc(hidden)]
#[expect(unsafe_code, reason = "calls as programs make them")]
pub mod ffi_client;
#[expect(unsafe_code, reason = "calls of programs, with pointers")]
mod ffi_device;
#[expect(unsafe_code, reason = "functions of programs")]
mod ffi_frame;
mod ffi_introspection;
#[expect(unsafe_code, reason = "calls of programs, with pointers")]
mod ffi_library;
mod ffi_properties;
#[expect(unsafe_code, reason = "functions of programs")]
mod ffi_status;
mod field;
mod first_hit;
mod frame;
mod freshness;
mod geometry;
mod light;
mod material;
mod motion;
mod movers;
mod nanovdb;
mod object;
mod output;
mod picture;
mod pixel;
mod sampler;
mod schema;
mod settings;
mod shader;
mod table;
mod transforms;
#[doc(hidden)]
#[expect(non_upper_case_globals, reason = "ANARI's own names")]
pub mod types;
mod volume;
mod world;

pub use ffi_abi::Library;
pub use ffi_library::anari_library_gnurt_new_library;
