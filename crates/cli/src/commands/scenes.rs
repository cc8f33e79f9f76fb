// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt scenes`: the names of the built-in scenes. Tests: `tests/program/interface.rs`.

use gnurt::{BUILTIN, builtin_scenes};

use crate::failure::Outcome;
use crate::messages::print;

/// Lists them.
pub(crate) fn run() -> Outcome {
    let longest = builtin_scenes().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines = builtin_scenes().map(|(name, about)| format!("{BUILTIN}{name:longest$}  {about}"));
    print(lines.collect::<Vec<_>>().join("\n"))
}
