// SPDX-License-Identifier: GPL-3.0-or-later
//! Options that say which files a scene may read, where textures are kept, and what of the scene is loaded.
//! Tests: `tests/program/{confine,textures}.rs`.

use std::path::PathBuf;

use clap::Args;
use gnurt::LoadOptions;
use gnurt::Override;
use gnurt::image::TileCache;
use gnurt::scene::io::{UpAxis, VariantChoice};

use super::value;
use crate::failure::Failure;
use crate::workers::threads;

/// `--confine`, `--texture-memory`, `--variant`, `--subdivision`, `--up-axis`, `--set` and `--strict`.
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

    /// Choose a variant of a glTF scene by NAME, or one of a USD scene in place of the file's choice; may be given
    /// again for others of USD
    #[arg(
        long,
        help_heading = "Scene",
        hide_short_help = true,
        value_name = "NAME|/PRIM:SET=NAME",
        value_parser = value::variant,
        allow_hyphen_values = true
    )]
    variant: Vec<VariantChoice>,

    /// Refine subdivision surfaces of USD scenes so many times, 0 = show the control mesh [default: 2]
    #[arg(
        long,
        help_heading = "Scene",
        hide_short_help = true,
        value_name = "LEVEL",
        value_parser = value::subdivision,
        allow_hyphen_values = true
    )]
    subdivision: Option<u32>,

    /// Name the axis that points upwards in an OBJ, PLY or STL file: x, y, z [default: y]
    #[arg(
        long,
        help_heading = "Scene",
        hide_short_help = true,
        value_name = "AXIS",
        value_parser = value::up_axis,
        allow_hyphen_values = true
    )]
    up_axis: Option<UpAxis>,

    /// Change a value of the scene, as in materials.gold.roughness=0.3, materials.*.base_color=0.2,0.5,0.8, lights.0.intensity=2,
    /// lights.0.group=key, lights.0.link=chair,table or instances.NAME.visible=false; one number keeps a light's colour; repeatable
    #[arg(
        long,
        help_heading = "Scene",
        hide_short_help = true,
        value_name = "LIST.NAME.FIELD=VALUE",
        value_parser = Override::parse,
        allow_hyphen_values = true
    )]
    pub(crate) set: Vec<Override>,

    /// Take warnings of the scene's files as errors
    #[arg(long, help_heading = "Scene", hide_short_help = true)]
    strict: bool,
}

impl FileArguments {
    /// Permissions and limits of a scene; the changes of `--set` are made later.
    pub(crate) fn options(&self) -> Result<LoadOptions, Failure> {
        let failed = |error| Failure::data(format_args!("--texture-memory: {error}"));
        let tiles = self.texture_memory.map(|mib| TileCache::new(mib << 20)).transpose().map_err(failed)?;
        let (confine, variants, overrides) = (self.confine.clone(), self.variant.clone(), Vec::new());
        let Self { subdivision, strict, up_axis: up, .. } = *self;
        let threads = threads();
        Ok(LoadOptions { confine, tiles, variants, overrides, subdivision, strict, up, threads, at: None })
    }
}
