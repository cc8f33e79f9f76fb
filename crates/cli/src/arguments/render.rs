// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `render`, in the order of its help. Source: names after pbrt, Mitsuba and appleseed.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use gnurt::layers::LayerList;
use gnurt::render::Piece;
use gnurt_view::TevAddress;

use super::value::{self, Crop};
use super::{
    DenoiserArguments, FileArguments, FrameArguments, HelpArguments, LightArguments, MachineArguments,
    OcioArguments, TimeArguments, TreeArguments, VerbosityArguments, ViewArguments,
};

/// Arguments of `render`.
#[derive(Args, Debug)]
pub(crate) struct RenderArguments {
    /// Scene file ({SCENES}), a sequence of files (mesh.####.ply) or builtin:NAME
    pub(crate) scene: OsString,
    /// Picture to write: {PICTURES}; without it the scene's name with .png, in the current folder
    #[arg(help_heading = "Picture", short, long, value_name = "FILE", allow_hyphen_values = true)]
    pub(crate) output: Option<PathBuf>,
    /// Also write a heat map of each pixel's cost
    #[arg(
        help_heading = "Picture",
        hide_short_help = true,
        long,
        value_name = "FILE",
        allow_hyphen_values = true
    )]
    pub(crate) heatmap: Option<PathBuf>,
    /// Layers of an EXR between commas: all, none, denoise, normal and others of surfaces, direct and others of light, cryptomatte, light:NAME, shader.NAME (a shader's output), NAME=EXPRESSION (a light path expression); a wrong word lists all [default: all of surfaces]
    #[arg(help_heading = "Picture", hide_short_help = true, long, value_name = "LIST", value_parser = value::layers, allow_hyphen_values = true)]
    pub(crate) layers: Option<LayerList>,
    /// Things per pixel in the layers of Cryptomatte, 2 to 32
    #[arg(help_heading = "Picture", hide_short_help = true, long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=32), allow_hyphen_values = true, default_value = "6")]
    pub(crate) crypto_depth: u32,
    /// Add a layer to an EXR for each light group, and one for all other light; `gnurt relight` mixes them
    #[arg(help_heading = "Picture", hide_short_help = true, long)]
    pub(crate) light_groups: bool,
    /// Leave the background out of a PNG, which becomes transparent there; an EXR has it as a layer of its own anyway
    #[arg(help_heading = "Picture", hide_short_help = true, long, conflicts_with = "piece")]
    pub(crate) transparent: bool,
    /// Render only these pixels (origin at the upper left, x1 and y1 excluded); the others stay black
    #[arg(help_heading = "Picture", hide_short_help = true, long, value_name = "X0,Y0,X1,Y1", value_parser = value::crop, allow_hyphen_values = true)]
    pub(crate) crop: Option<Crop>,
    /// Render piece I of N; other processes or machines render the others, and `gnurt join` joins them
    #[arg(help_heading = "Picture", hide_short_help = true, long, value_name = "I/N", value_parser = value::piece, allow_hyphen_values = true)]
    pub(crate) piece: Option<Piece>,
    /// Render and write this number of rows at a time, for .exr and .png pictures larger than memory; rounded up to whole blocks of the file
    #[arg(help_heading = "Picture", hide_short_help = true, long, value_name = "ROWS", value_parser = clap::value_parser!(u32).range(1..), allow_hyphen_values = true)]
    pub(crate) band_rows: Option<u32>,
    #[command(flatten)]
    pub(crate) times: TimeArguments,
    #[command(flatten)]
    pub(crate) view: ViewArguments,
    #[command(flatten)]
    pub(crate) frame: FrameArguments,
    #[command(flatten)]
    pub(crate) denoiser: DenoiserArguments,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    #[command(flatten)]
    pub(crate) ocio: OcioArguments,
    /// Stop after TIME (90, 90s, 1.5m, 2h) and save the picture
    #[arg(help_heading = "Time and machine", long, value_name = "TIME", value_parser = value::time, allow_hyphen_values = true)]
    pub(crate) time: Option<Duration>,
    /// Also show the picture in tev while it renders: tev:HOST:PORT
    #[arg(help_heading = "Time and machine", hide_short_help = true, long, value_name = "WHERE", value_parser = value::display, allow_hyphen_values = true)]
    pub(crate) display: Option<TevAddress>,
    /// Save the state of the rendering in FILE, and resume from it if it exists
    #[arg(
        help_heading = "Time and machine",
        hide_short_help = true,
        long,
        value_name = "FILE",
        allow_hyphen_values = true
    )]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Time between two checkpoints
    #[arg(help_heading = "Time and machine", hide_short_help = true, long, value_name = "TIME", value_parser = value::time, allow_hyphen_values = true, default_value = "60s", requires = "checkpoint")]
    pub(crate) checkpoint_every: Duration,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) trees: TreeArguments,
    /// Print counts and times: a table on standard error, or json on standard output
    #[arg(
        help_heading = "Messages", hide_short_help = true,
        long,
        value_name = "FORM",
        value_parser = StatisticsForm::parse,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "table"
    )]
    pub(crate) stats: Option<StatisticsForm>,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
    #[command(flatten)]
    pub(crate) help: HelpArguments,
}

/// How statistics are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StatisticsForm {
    /// For people, on standard error.
    Table,
    /// For programs, on standard output.
    Json,
}

impl StatisticsForm {
    pub(super) fn parse(name: &str) -> Result<Self, String> {
        match name {
            "table" => Ok(Self::Table),
            "json" => Ok(Self::Json),
            _ => Err(crate::nearest::unknown("form", name, &["table", "json"])),
        }
    }
}
