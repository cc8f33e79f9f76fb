// SPDX-License-Identifier: GPL-3.0-or-later
//! OSL's command-line tools: `gnurt oslc`, `gnurt oslinfo` and `gnurt testshade`, with OSL's options and
//! output. They read and write files; the language's crate opens none.
#![forbid(unsafe_code)]

mod console;
mod oslc;
mod oslinfo;
mod picture;
mod testshade;

pub use console::Console;
pub use oslc::oslc;
pub use oslinfo::oslinfo;
pub use testshade::testshade;

/// The tool of a name.
#[must_use]
pub fn tool(name: &str) -> Option<fn(&[String], &mut Console<'_>) -> i32> {
    match name {
        "oslc" => Some(oslc),
        "oslinfo" => Some(oslinfo),
        "testshade" => Some(testshade),
        _ => None,
    }
}
