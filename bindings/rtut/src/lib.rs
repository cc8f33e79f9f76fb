// SPDX-License-Identifier: GPL-3.0-or-later
//! librtut: shapes for programs that use OpenRT.
//!
//! The shapes are written against [`sink::Sink`]; `ffi.rs` holds the exported functions and a sink that calls the
//! `rt*` functions of the process's libOpenRT, which the dynamic linker finds: librtut is not linked with it.
#![deny(unsafe_code)]

pub mod cube;
#[expect(unsafe_code, reason = "C calls in, and out to libOpenRT")]
mod ffi;
pub mod grid;
pub mod logo;
pub mod sink;
pub mod sphere;
pub mod teapot;
pub mod torus;

// libOpenRT's functions, for the linker of the tests.
#[cfg(test)]
use OpenRT as _;
