// SPDX-License-Identifier: GPL-3.0-or-later
//! The shading language's tools in a program without the language.

use std::path::Path;

use crate::command_line::command_line;
use crate::messages::{Messages, Verbosity};

/// Says how to get the requested tool; none if it is another command. It gives back its exit status.
pub(crate) fn run() -> Option<u8> {
    let mut command_line = command_line().iter().map(|argument| argument.to_string_lossy().into_owned());
    let called = command_line.next()?;
    let is_tool = |name: &str| ["oslc", "oslinfo", "testshade"].contains(&name);
    let called = Path::new(&called).file_stem()?.to_string_lossy().into_owned();
    let name = if is_tool(&called) { called } else { command_line.next()? };
    is_tool(&name).then(|| {
        Messages::new(Verbosity::Normal).error(format!(
            "this program was compiled without the shading language: `cargo run --release --features osl -- {name} ...` \
             compiles it; `cargo build --release` and `cargo xtask install` have it"
        ));
        2
    })
}
