// SPDX-License-Identifier: GPL-3.0-or-later
//! Options that say which files a scene may read. Source: original. Proof: `tests/program/confine.rs`.

use std::path::PathBuf;

use clap::Args;
use gnurt::LoadOptions;

/// `--confine`.
#[derive(Args, Clone, Debug)]
pub(crate) struct FileArguments {
    /// Let the scene name files below this folder only (libraries, textures, buffers; links are followed)
    #[arg(
        long,
        help_heading = "Time and machine",
        hide_short_help = true,
        value_name = "DIR",
        allow_hyphen_values = true
    )]
    confine: Option<PathBuf>,
}

impl FileArguments {
    /// What a scene may do.
    pub(crate) fn options(&self) -> LoadOptions {
        LoadOptions { confine: self.confine.clone() }
    }
}
