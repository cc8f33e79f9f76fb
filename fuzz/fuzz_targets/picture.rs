// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a picture: the first one chooses the format that its name claims.
#![no_main]

const NAMES: [&str; 8] = ["p.png", "p.jpg", "p.tga", "p.bmp", "p.webp", "p.hdr", "p.pfm", "p.exr"];

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&first, rest)) = bytes.split_first() else { return };
    gnurt_fuzz::let_decoders_panic();
    let name = NAMES[usize::from(first) % NAMES.len()];
    if let Err(error) = gnurt_image::decode(rest, name) {
        assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}");
    }
    let _ = gnurt_image::decode_texture(rest, name);
});
