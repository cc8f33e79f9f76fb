// SPDX-License-Identifier: GPL-3.0-or-later
//! The shading language's tools: `gnurt oslc`, `gnurt oslinfo`, `gnurt testshade`, and the same through links of those names.
//! Their options are OSL's and not clap's, so they are handled before all others.

use std::io::{BufWriter, stderr, stdout};

use gnurt_sl_tools::{Console, tool};

use crate::command_line::{self, Tool, command_line};

/// Runs the requested tool; none if it is another command. It gives back its exit status.
pub(crate) fn run() -> Option<u8> {
    let Tool { name, is_link, arguments } = command_line::tool(command_line(), |name| tool(name).is_some())?;
    let run = tool(&name)?;
    let (mut out, mut err) = (BufWriter::new(stdout()), stderr());
    let mut console = Console::new(&mut out, &mut err, is_link);
    console.engine = Some(gnurt_jit::engine);
    let textures = gnurt::osl::StoredTextures::default();
    console.textures = Some(&textures);
    let status = run(&arguments, &mut console);
    console.flush();
    Some(u8::try_from(status).unwrap_or(1))
}
