// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a shader's source text: compiled, written, read back.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let compiled = gnurt_sl::compile("fuzz.osl", &text, &gnurt_sl::Options::default(), &|_| None);
    if let Some(shader) = compiled.shader {
        let oso = gnurt_sl::ir::write(&shader, "");
        gnurt_sl::ir::read(&oso).expect("what is written is read");
    }
});
