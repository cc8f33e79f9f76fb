// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as the material library of a small OBJ file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    const OBJ: &[u8] = b"mtllib fuzz.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    gnurt_fuzz::load_scene("fuzz.obj", OBJ, &[("fuzz.mtl", bytes)]);
});
