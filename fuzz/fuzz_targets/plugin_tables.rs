// SPDX-License-Identifier: GPL-3.0-or-later
//! Tables that a plugin gives: refused in one line, or keeping every promise; see crates/plugins/src/ffi_tables.rs.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| gnurt_plugins::ffi_tables::load_random(bytes));
