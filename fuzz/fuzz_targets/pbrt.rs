// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a scene of pbrt-v4.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    gnurt_fuzz::load_scene("fuzz.pbrt", bytes, &[]);
});
