// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a compiled shader, `.oso`: a valid one runs at a point, by the interpreter and by machine
//! code.
#![no_main]

use gnurt_fuzz::shaders;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(shader) = gnurt_sl::ir::read(&String::from_utf8_lossy(bytes)) {
        shaders::messages(shader.clone());
        shaders::coded(shader);
    }
});
