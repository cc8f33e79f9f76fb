// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as an STL file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    gnurt_fuzz::load_scene("fuzz.stl", bytes, &[]);
});
