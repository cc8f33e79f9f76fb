// SPDX-License-Identifier: GPL-3.0-or-later
//! The command line as types. Only here text becomes values; a rejection here costs no work. See
//! docs/reference/cli.md. An option given twice: the last one wins. Values may start with a minus. Tests:
//! `tests/program/arguments.rs`.

#[cfg(all(test, feature = "bench"))]
#[expect(dead_code, reason = "its tests run in programs with benchmarks, too")]
mod absent_bench;
#[cfg_attr(not(feature = "bench"), path = "absent_bench.rs")]
mod bench;
mod denoise;
mod denoiser;
mod files;
mod help;
mod idle;
mod join;
mod ocio;
mod refusal;
mod relight;
mod render;
mod times;
pub(crate) mod value;
mod verbosity_arguments;
mod view;
mod window;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

pub(crate) use bench::BenchArguments;
#[cfg(feature = "bench")]
pub(crate) use bench::{
    BenchBuildArguments, BenchCommand, BenchDynamicArguments, BenchLightArguments, BenchPaperArguments,
    BenchRaysArguments,
};
pub(crate) use denoise::DenoiseArguments;
pub(crate) use denoiser::DenoiserArguments;
pub(crate) use files::FileArguments;
pub(crate) use help::HelpArguments;
use help::with_formats;
pub(crate) use idle::without_effect;
pub(crate) use join::JoinArguments;
pub(crate) use ocio::OcioArguments;
pub(crate) use refusal::{Refusal, explain};
pub(crate) use relight::RelightArguments;
pub(crate) use render::{RenderArguments, StatisticsForm};
pub(crate) use times::TimeArguments;
pub(crate) use value::{ExposureChoice, Pixel, Resolution, ShaderChoice};
pub(crate) use verbosity_arguments::{VerbosityArguments, verbosity_behind_command};
pub(crate) use view::{
    DisplayOptions, FrameArguments, LightArguments, MachineArguments, PictureFileArguments, TreeArguments,
    ViewArguments,
};
pub(crate) use window::WindowArguments;

/// Ray tracing from the command line.
#[derive(Debug, Parser)]
#[command(
    name = "gnurt",
    version,
    about = "GNU RT: a free ray tracing system",
    after_help = AFTER_HELP,
    args_override_self = true,
    subcommand_required = true,
    disable_help_subcommand = false
)]
pub(crate) struct Arguments {
    /// The command.
    #[command(subcommand)]
    pub(crate) command: Command,
}

impl Arguments {
    /// The command line, with the formats that the program reads and writes.
    pub(crate) fn with_formats() -> clap::Command {
        with_formats(<Self as clap::CommandFactory>::command())
    }
}

const AFTER_HELP: &str = "\
Scenes: {SCENES}, or builtin:NAME (`gnurt scenes` lists them); mesh.####.ply is a sequence of files.
Pictures: {PICTURES}.
Shaders: `gnurt oslc`, `gnurt oslinfo` and `gnurt testshade` are OSL's tools with its options (`gnurt oslc --help`).

Environment (options win): GNURT_THREADS as --threads; GNURT_ISA as --isa;
GNURT_LOG = error, warning, info or debug; GNURT_PATH = folders to look for scenes in.

Exit status: 0 done, 1 bad data or pictures differ, 2 bad arguments, 130 stopped by the second Ctrl-C.
The first Ctrl-C ends the rendering and saves the picture so far.";

/// The subcommands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to a picture
    #[command(args_override_self = true, disable_help_flag = true)]
    Render(Box<RenderArguments>),
    /// Join the pieces of a picture from `render --piece`
    #[command(args_override_self = true)]
    Join(Box<JoinArguments>),
    /// Take the noise out of an EXR picture, or of a film's frames together
    #[command(args_override_self = true)]
    Denoise(Box<DenoiseArguments>),
    /// Mix the light groups of an EXR picture, or of a film's frames, with other strengths and colours
    #[command(args_override_self = true)]
    Relight(Box<RelightArguments>),
    /// Fly through a scene in a window
    #[command(
        args_override_self = true,
        disable_help_flag = true,
        after_long_help = format!("{}\n\nKeys with finished pictures:\n{}", gnurt_view::KEYS, gnurt_view::PICTURE_KEYS),
        // A window keeps refining the picture, up to this many samples; timed frames take one sample each.
        mut_arg("spp", |spp| spp.default_value("1024").default_value_if("headless", "true", "1"))
    )]
    View(Box<WindowArguments>),
    /// Print the contents of a scene or a picture
    #[command(args_override_self = true)]
    Info(InfoArguments),
    /// Compare two pictures: exit status 0 if equal, 1 if they differ, 2 if they cannot be compared
    #[command(args_override_self = true)]
    Diff(DiffArguments),
    /// Convert a picture to another picture format, or a scene to another scene format
    #[command(
        args_override_self = true,
        // A picture is converted unchanged unless an option is given.
        mut_arg("tone", |tone| tone.default_value("clamp")),
        mut_arg("exposure", |exposure| exposure.default_value("0"))
    )]
    Convert(ConvertArguments),
    /// Follow the light of one pixel and print each step
    #[command(
        args_override_self = true,
        // Its steps are few, and always the same.
        mut_arg("integrator", |integrator| integrator.default_value("whitted"))
    )]
    Trace(Box<TraceArguments>),
    /// Measure how fast this machine traces rays
    #[command(args_override_self = true)]
    Bench(BenchArguments),
    /// List the built-in scenes
    #[command(args_override_self = true)]
    Scenes(ScenesArguments),
    /// Write man pages and shell completions
    #[command(args_override_self = true, hide = true)]
    Manuals(ManualsArguments),
}

impl Command {
    /// How much it is to say.
    pub(crate) fn verbosity_arguments(&self) -> &VerbosityArguments {
        match self {
            Self::Render(arguments) => &arguments.verbosity_arguments,
            Self::Join(arguments) => &arguments.verbosity_arguments,
            Self::Denoise(arguments) => &arguments.verbosity_arguments,
            Self::Relight(arguments) => &arguments.verbosity_arguments,
            Self::View(arguments) => &arguments.verbosity_arguments,
            Self::Info(arguments) => &arguments.verbosity_arguments,
            Self::Diff(arguments) => &arguments.verbosity_arguments,
            Self::Convert(arguments) => &arguments.verbosity_arguments,
            Self::Trace(arguments) => &arguments.verbosity_arguments,
            Self::Bench(arguments) => arguments.verbosity_arguments(),
            Self::Scenes(arguments) => &arguments.verbosity_arguments,
            Self::Manuals(arguments) => &arguments.verbosity_arguments,
        }
    }

    /// How it is to use the machine, if it computes at all.
    pub(crate) fn machine(&self) -> Option<&MachineArguments> {
        match self {
            Self::Render(arguments) => Some(&arguments.machine),
            Self::Join(arguments) => Some(&arguments.machine),
            Self::Denoise(arguments) => Some(&arguments.machine),
            Self::View(arguments) => Some(&arguments.machine),
            Self::Info(arguments) => Some(&arguments.machine),
            Self::Trace(arguments) => Some(&arguments.machine),
            Self::Bench(arguments) => arguments.machine(),
            Self::Relight(_) | Self::Diff(_) | Self::Convert(_) | Self::Scenes(_) | Self::Manuals(_) => None,
        }
    }
}

/// Arguments of `info`.
#[derive(Args, Debug)]
pub(crate) struct InfoArguments {
    /// Scene file ({SCENES}), builtin:NAME or picture
    pub(crate) scene: OsString,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Time of the animation to print, in seconds [default: the scene at rest]
    #[arg(long, value_name = "SECONDS", value_parser = value::seconds, allow_hyphen_values = true)]
    pub(crate) at: Option<f64>,
    /// Build the trees and print their size
    #[arg(long)]
    pub(crate) tree: bool,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) trees: TreeArguments,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `diff`.
#[derive(Args, Debug)]
pub(crate) struct DiffArguments {
    /// A picture ({READ_PICTURES})
    pub(crate) a: PathBuf,
    /// The picture it is compared with: reference of relMSE
    pub(crate) b: PathBuf,
    /// Largest absolute difference of a linear value that still passes
    #[arg(long, value_name = "T", value_parser = value::tolerance, allow_hyphen_values = true, default_value = "0")]
    pub(crate) fail: f64,
    /// Also print FLIP, the mean difference that people see on a screen: 0 = none to 1
    #[arg(long)]
    pub(crate) flip: bool,
    /// Write a picture of the differences ({PICTURES}): absolute ones, or with --flip those that people see
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `convert`.
#[derive(Args, Debug)]
pub(crate) struct ConvertArguments {
    /// A picture or a scene
    #[arg(value_name = "IN")]
    pub(crate) input: OsString,
    /// File to write; its extension selects the format
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) denoiser: DenoiserArguments,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    #[command(flatten)]
    pub(crate) ocio: OcioArguments,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `trace`.
#[derive(Args, Debug)]
pub(crate) struct TraceArguments {
    /// Scene file ({SCENES}) or builtin:NAME
    pub(crate) scene: OsString,
    /// The pixel, from the upper left corner
    #[arg(long, value_name = "X,Y", value_parser = value::pixel, allow_hyphen_values = true)]
    pub(crate) pixel: Pixel,
    #[command(flatten)]
    pub(crate) frame: FrameArguments,
    #[command(flatten)]
    pub(crate) view: ViewArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) trees: TreeArguments,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `scenes`.
#[derive(Args, Debug)]
pub(crate) struct ScenesArguments {
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `manuals`.
#[derive(Args, Debug)]
pub(crate) struct ManualsArguments {
    /// The folder to write to; it is made
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}
