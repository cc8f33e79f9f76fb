// SPDX-License-Identifier: GPL-3.0-or-later
//! The shading language's tools: `gnurt oslc`, `gnurt oslinfo`, `gnurt testshade`, and the same through links of those names.
//! Their options are OSL's and not clap's, so they are handled before all others.

use std::io::{BufWriter, stderr, stdout};
use std::path::Path;

use gnurt_sl_tools::{Console, tool};

use crate::command_line::command_line;

/// Runs the requested tool; none if it is another command. It gives back its exit status.
pub(crate) fn run() -> Option<u8> {
    let mut command_line = command_line().iter().map(|argument| argument.to_string_lossy().into_owned());
    let called = command_line.next()?;
    let called = Path::new(&called).file_stem()?.to_string_lossy().into_owned();
    let link = tool(&called).is_some();
    let name = if link { called } else { command_line.next()? };
    let run = tool(&name)?;
    let rest: Vec<String> = command_line.collect();
    let (mut out, mut err) = (BufWriter::new(stdout()), stderr());
    let mut console = Console::new(&mut out, &mut err, link);
    console.engine = Some(gnurt_jit::engine);
    let textures = gnurt::osl::StoredTextures::default();
    console.textures = Some(&textures);
    let status = run(&rest, &mut console);
    console.flush();
    Some(u8::try_from(status).unwrap_or(1))
}
