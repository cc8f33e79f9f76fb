// SPDX-License-Identifier: GPL-3.0-or-later
//! The shading language's tools in a program without the language.
//! Tests: `command_line`, and `absent_osl` of gnurt for the message; `cargo xtask ci` compiles the program without features.

use crate::command_line::{command_line, tool};
use crate::messages::{Messages, Verbosity};

/// Reports how to get the requested tool; none if it is another command. It gives back its exit status.
pub(crate) fn run() -> Option<u8> {
    let tool = tool(command_line(), |name| ["oslc", "oslinfo", "testshade"].contains(&name))?;
    Messages::new(Verbosity::Normal).error(gnurt::osl::absent(&format!("{} ...", tool.name)));
    Some(2)
}
