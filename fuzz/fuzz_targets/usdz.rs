// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a USD package.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    gnurt_fuzz::load_usd("fuzz.usdz", bytes);
});
