// SPDX-License-Identifier: GPL-3.0-or-later
//! Random sequences of OpenRT calls: no panic, no hang, error codes of the specification.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| OpenRT::random::run(bytes));
