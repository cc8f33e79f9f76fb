// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as the text of a group of shaders, of which four are there: read, laid out, written, read back.
#![no_main]

use gnurt_fuzz::shaders;
use gnurt_sl::group::{read_group, write_group};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let mut find = |name: &str| shaders::known(name);
    let Ok(group) = read_group("fuzz", &text, &mut find, &mut Vec::new()) else { return };
    shaders::messages_of(&group);
    let again = write_group(&group);
    read_group("fuzz", &again, &mut find, &mut Vec::new()).expect("what is written is read");
});
