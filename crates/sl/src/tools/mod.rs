// SPDX-License-Identifier: GPL-3.0-or-later
//! OSL's command-line tools: `gnurt oslc`, `gnurt oslinfo` and `gnurt testshade`, with OSL's options and
//! output. Options and output are those of OSL's tools.

mod console;
mod engine;
mod oslc;
mod oslinfo;
mod picture;
mod testshade;
mod textures;

pub use console::Console;
pub use engine::{Batch, Engine};
pub use oslc::oslc;
pub use oslinfo::oslinfo;
pub use testshade::testshade;
pub use textures::Textures;

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
