// SPDX-License-Identifier: GPL-3.0-or-later
//! Tables that a plugin gives: rejected in one line, or satisfying every guarantee; see crates/plugins/src/ffi_tables.rs.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| gnurt_plugins::ffi_tables::load_random(bytes));
