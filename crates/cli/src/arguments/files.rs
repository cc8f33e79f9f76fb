// SPDX-License-Identifier: GPL-3.0-or-later
//! Options that say which files a scene may read, and where their textures are kept.
//! Tests: `tests/program/{confine,textures}.rs`.

use std::path::PathBuf;

use clap::Args;
use gnurt::LoadOptions;
use gnurt::image::TileCache;

use super::value;
use crate::failure::Failure;

/// `--confine` and `--texture-memory`.
#[derive(Args, Clone, Debug)]
pub(crate) struct FileArguments {
    /// Read files named by the scene (libraries, textures, buffers) only below this folder; links are followed
    #[arg(
        long,
        help_heading = "Time and machine",
        hide_short_help = true,
        value_name = "DIR",
        allow_hyphen_values = true
    )]
    confine: Option<PathBuf>,

    /// Limit textures in memory to this size; the rest stays in a temporary file [default: all in memory]
    #[arg(
        long,
        help_heading = "Time and machine",
        hide_short_help = true,
        value_name = "MIB",
        value_parser = value::mebibytes,
        allow_hyphen_values = true
    )]
    texture_memory: Option<u64>,
}

impl FileArguments {
    /// What a scene may do.
    pub(crate) fn options(&self) -> Result<LoadOptions, Failure> {
        let failed = |error| Failure::data(format_args!("--texture-memory: {error}"));
        let tiles = self.texture_memory.map(|mib| TileCache::new(mib << 20)).transpose().map_err(failed)?;
        Ok(LoadOptions { confine: self.confine.clone(), tiles, ..LoadOptions::default() })
    }
}
