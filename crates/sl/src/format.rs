// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers and texts as source text has them.
//! Tests: `tests/format.rs` reads the text back, and compares with numbers printed by C.

pub use gnurt_sl_lib::text::general;

/// A text with unprintable characters and quotes escaped, as in source text.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            '\x07' => out.push_str("\\a"),
            '\x08' => out.push_str("\\b"),
            '\x0b' => out.push_str("\\v"),
            '\x0c' => out.push_str("\\f"),
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c => out.push(c),
        }
    }
    out
}
