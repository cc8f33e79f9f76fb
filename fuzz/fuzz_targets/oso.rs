// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a compiled shader, `.oso`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = gnurt_sl::ir::read(&String::from_utf8_lossy(bytes));
});
