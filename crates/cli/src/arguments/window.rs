// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `view`. Options shared with `render` have the same names.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;
use gnurt_view::{Comparison, TevAddress};

use super::value;
use super::{
    DenoiserArguments, FileArguments, FrameArguments, HelpArguments, LightArguments, MachineArguments,
    StatisticsForm, TreeArguments, VerbosityArguments, ViewArguments,
};

/// Arguments of `view`.
#[derive(Args, Clone, Debug)]
pub(crate) struct WindowArguments {
    /// Scene file ({SCENES}) or builtin:NAME; or a finished picture ({PICTURES}), or a film of them: frame.####.exr
    pub(crate) scene: OsString,
    /// Render without a window and print the frame rate; of pictures, write one to --output
    #[arg(help_heading = "Picture", long)]
    pub(crate) headless: bool,
    /// Picture to write, of a scene's last frame: {PICTURES}; only without a window
    #[arg(
        help_heading = "Picture",
        hide_short_help = true,
        short,
        long,
        value_name = "FILE",
        allow_hyphen_values = true
    )]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) pictures: FinishedArguments,
    #[command(flatten)]
    pub(crate) view: ViewArguments,
    /// Orbit of the camera around its target over all frames, in degrees; only without a window [default: 360 for several frames]
    #[arg(help_heading = "Camera", hide_short_help = true, long, value_name = "DEGREES", value_parser = value::turn, allow_hyphen_values = true)]
    pub(crate) orbit: Option<f64>,
    #[command(flatten)]
    pub(crate) frame: FrameArguments,
    #[command(flatten)]
    pub(crate) denoiser: DenoiserArguments,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    /// Animation that the space bar plays, by name or number from 0 [default: the first]
    #[arg(help_heading = "Animation", long, value_name = "NAME|INDEX", allow_hyphen_values = true)]
    pub(crate) animation: Option<String>,
    /// Leave after N pictures [default without a window: 1]
    #[arg(help_heading = "Time and machine", hide_short_help = true, long, value_name = "N", value_parser = value::samples, allow_hyphen_values = true)]
    pub(crate) frames: Option<u32>,
    /// Render N refining pictures after the last frame and print their flicker; only without a window
    #[arg(help_heading = "Time and machine", hide_short_help = true, long, value_name = "N", value_parser = value::samples, allow_hyphen_values = true)]
    pub(crate) rest: Option<u32>,
    /// Show the pictures in tev instead of a window: tev:HOST:PORT
    #[arg(help_heading = "Time and machine", hide_short_help = true, long, value_name = "WHERE", value_parser = value::display, allow_hyphen_values = true)]
    pub(crate) display: Option<TevAddress>,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) trees: TreeArguments,
    /// Print frame times: a table on standard error, or json on standard output; only without a window
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

/// How finished pictures are shown.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Finished pictures")]
pub(crate) struct FinishedArguments {
    /// Layer to show: color, or a name that `gnurt info` lists, such as N, albedo or depth.Z [default: color]
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    pub(crate) layer: Option<String>,
    /// Picture or film to compare with
    #[arg(long, value_name = "PICTURE", allow_hyphen_values = true)]
    pub(crate) compare: Option<PathBuf>,
    /// How the two are shown: first, second, split, difference or flip (differences that people see) [default: split]
    #[arg(long, value_name = "HOW", allow_hyphen_values = true, hide_short_help = true)]
    pub(crate) compare_as: Option<Comparison>,
    /// Frames of a film in a second
    #[arg(long, value_name = "N", value_parser = value::frames_per_second, default_value = "24", allow_hyphen_values = true, hide_short_help = true)]
    pub(crate) fps: f64,
}
