// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a shader's source text: compiled, written, read back, written again the same; and run at a point, where it does the same.
#![no_main]

use gnurt_fuzz::shaders;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let compiled = gnurt_sl::compile("fuzz.osl", &text, &gnurt_sl::Options::default(), &|_| None);
    let wrong = compiled.diagnostics.list.iter().find(|d| d.message.contains("the compiler made a mistake"));
    assert!(wrong.is_none(), "{wrong:?}");
    if let Some(shader) = compiled.shader {
        let oso = gnurt_sl::ir::write(&shader, "");
        let back = gnurt_sl::ir::read(&oso).expect("what is written is read");
        assert_eq!(gnurt_sl::ir::write(&back, ""), oso, "and written again the same");
        let requested = shaders::messages(shader.clone());
        if let Some(found) = shaders::coded(shader) {
            assert_eq!(found, requested, "machine code does the same");
        }
        assert_eq!(shaders::messages(back), requested, "and so does what was read back");
    }
});
