// SPDX-License-Identifier: GPL-3.0-or-later
//! librtut: shapes and a window for programs that use OpenRT.
//!
//! The shapes are written against [`sink::Sink`], the window against a program and a renderer. `ffi*.rs` hold
//! the exported functions and the calls of the `rt*` functions of the process's libOpenRT, which the dynamic
//! linker finds: librtut is not linked with it.
#![deny(unsafe_code)]

pub mod cube;
#[expect(unsafe_code, reason = "C calls in, and out to libOpenRT")]
mod ffi;
#[expect(unsafe_code, reason = "C calls in, and out to the program and libOpenRT")]
mod ffi_window;
pub mod grid;
mod guard;
pub mod logo;
pub mod sink;
pub mod sphere;
pub mod teapot;
pub mod torus;
mod window;

// libOpenRT's functions, for the linker of the tests.
#[cfg(test)]
use OpenRT as _;
