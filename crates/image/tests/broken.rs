// SPDX-License-Identifier: GPL-3.0-or-later
//! Broken files: cut at every length and corrupted at every byte, each gives a picture or one clear error, no panic.

mod common;

use common::files;
use gnurt_image::{Error, decode, decode_texture};

fn check_message(error: &Error, what: &str) {
    let message = error.to_string();
    assert!(!message.is_empty() && !message.contains('\n'), "{what}: one line: {message}");
    for debug in ["Error {", "Kind", "Some(", "panicked", "os error", "::"] {
        assert!(!message.contains(debug), "{what}: no text for programmers: {message}");
    }
}

#[test]
fn files_cut_anywhere_are_errors() {
    for (name, bytes) in files(12, 10) {
        // A TGA's end is a comment: the picture is whole without it.
        let end = if name == "x.tga" { bytes.len() - 26 } else { bytes.len() };
        for length in 0..end {
            match decode(&bytes[..length], &name) {
                Ok(_) => panic!("{name}: {length} of {} bytes were taken for a picture", bytes.len()),
                Err(error) => check_message(&error, &format!("{name} cut at {length}")),
            }
        }
    }
}

#[test]
fn corrupt_bytes_never_panic() {
    for (name, bytes) in files(12, 10) {
        for at in 0..bytes.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut broken = bytes.clone();
                broken[at] ^= flip;
                if let Err(error) = decode(&broken, &name) {
                    check_message(&error, &format!("{name}, byte {at} ^ {flip:#x}"));
                }
            }
        }
    }
}

#[test]
fn random_tails_never_panic() {
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    for (name, bytes) in files(12, 10) {
        for _ in 0..300 {
            let mut broken = bytes.clone();
            for _ in 0..=random() % 8 {
                let at = random() % broken.len();
                broken[at] = random() as u8;
            }
            if let Err(error) = decode_texture(&broken, &name) {
                check_message(&error, &name);
            }
        }
    }
}

#[test]
fn huge_sizes_are_refused_before_memory_is_taken() {
    let png = {
        let (_, mut bytes) = files(12, 10).remove(0);
        bytes[16..24].copy_from_slice(&[0, 0, 0x3f, 0xff, 0, 0, 0x3f, 0xff]);
        bytes
    };
    let cases: [(&str, &[u8]); 5] = [
        ("a.pfm", b"PF\n16000 16000\n-1\nxxxx"),
        ("b.pfm", b"PF\n4000000000 4000000000\n-1\nxxxx"),
        ("a.hdr", b"#?RADIANCE\n\n-Y 16000 +X 16000\n\x02\x02\x3e\x80"),
        ("a.tga", &[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0x0f, 32, 0, 1, 2, 3]),
        ("a.png", &png),
    ];
    for (name, bytes) in cases {
        let error = decode(bytes, name).expect_err("the file is too short for its size");
        check_message(&error, name);
        let reported = error.to_string().contains("pixels");
        assert!(reported, "{name}: the size is the reason: {error}");
    }
}

#[test]
fn other_files_list_what_is_known() {
    let error = decode(b"Hello, world, this is a letter.", "letter.png").expect_err("a letter is no picture");
    assert!(
        error.to_string().contains("PNG, EXR, HDR, PFM, JPEG, TGA, BMP, WebP, TIFF"),
        "known formats are listed: {error}"
    );
}
