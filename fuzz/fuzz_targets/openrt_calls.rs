// SPDX-License-Identifier: GPL-3.0-or-later
//! Random sequences of OpenRT calls: no panic, no hang, error codes of the specification.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../bindings/openrt/tests/calls/mod.rs"]
mod calls;

fuzz_target!(|bytes: &[u8]| calls::run(bytes));
