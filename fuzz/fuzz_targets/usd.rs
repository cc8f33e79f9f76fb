// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a USD layer, text or binary.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    gnurt_fuzz::load_usd("fuzz.usd", bytes);
});
