// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `bench`. Tests: `tests/program/bench.rs`.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use gnurt::render::{Caustics, Guiding, Integrator};
use gnurt_bench::Class;

use super::value;
use super::value::Resolution;
use super::{FileArguments, MachineArguments, VerbosityArguments, ViewArguments};

/// Arguments of `bench`.
#[derive(Args, Debug)]
pub(crate) struct BenchArguments {
    /// Benchmark
    #[command(subcommand)]
    pub(crate) command: BenchCommand,
}

/// The measurements.
#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// Measure ray queries, beside Embree's where EMBREE4_LIB names a library of Embree 4
    #[command(args_override_self = true)]
    Rays(BenchRaysArguments),
    /// Measure how long trees take to build and how large they are, beside Embree's
    #[command(args_override_self = true)]
    Build(BenchBuildArguments),
    /// Measure updates of deforming scenes, beside Embree's refit and builds
    #[command(args_override_self = true)]
    Dynamic(BenchDynamicArguments),
    /// Measure tables 1 and 2 of the paper (kd-trees), its figures beside ours
    #[command(args_override_self = true)]
    Paper(BenchPaperArguments),
    /// Measure the error of integrators over processor time
    #[command(args_override_self = true)]
    Light(Box<BenchLightArguments>),
}

impl BenchArguments {
    pub(crate) fn verbosity_arguments(&self) -> &VerbosityArguments {
        match &self.command {
            BenchCommand::Rays(arguments) => &arguments.verbosity_arguments,
            BenchCommand::Build(arguments) => &arguments.verbosity_arguments,
            BenchCommand::Dynamic(arguments) => &arguments.verbosity_arguments,
            BenchCommand::Paper(arguments) => &arguments.verbosity_arguments,
            BenchCommand::Light(arguments) => &arguments.verbosity_arguments,
        }
    }

    pub(crate) fn machine(&self) -> Option<&MachineArguments> {
        match &self.command {
            BenchCommand::Rays(arguments) => Some(&arguments.machine),
            BenchCommand::Build(arguments) => Some(&arguments.machine),
            BenchCommand::Dynamic(arguments) => Some(&arguments.machine),
            BenchCommand::Paper(_) => None,
            BenchCommand::Light(arguments) => Some(&arguments.machine),
        }
    }
}

/// Arguments of `bench rays`.
#[derive(Args, Debug)]
pub(crate) struct BenchRaysArguments {
    /// Scene files ({SCENES}) or builtin:NAME; each is measured by itself
    #[arg(value_name = "SCENE", default_value = "builtin:materials")]
    pub(crate) scenes: Vec<OsString>,
    /// Classes of rays: primary, shadow, ao, diffuse, shuffled
    #[arg(long = "class", value_name = "LIST", value_parser = value::ray_class, value_delimiter = ',')]
    pub(crate) classes: Vec<Class>,
    /// Engines: gnurt, embree4
    #[arg(long = "engine", value_name = "LIST", value_parser = value::engine, value_delimiter = ',')]
    pub(crate) engines: Vec<String>,
    /// Parts of names of modes, like bvh-high,kd,coherent,robust-16
    #[arg(long = "mode", value_name = "LIST", value_delimiter = ',')]
    pub(crate) modes: Vec<String>,
    /// Columns and rows of primary rays
    #[arg(long, value_name = "N", value_parser = value::columns, allow_hyphen_values = true, default_value = "1024")]
    pub(crate) size: u32,
    /// Runs of each mode, in turns
    #[arg(long, value_name = "N", value_parser = value::rounds, allow_hyphen_values = true, default_value = "5")]
    pub(crate) rounds: usize,
    /// Rays per batch
    #[arg(long, value_name = "N", value_parser = value::batch, allow_hyphen_values = true, default_value = "4096")]
    pub(crate) batch: usize,
    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write a complete record as JSON: machine, rate of every round, pairs compared
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Write the best of each side as bars
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `bench build`.
#[derive(Args, Debug)]
pub(crate) struct BenchBuildArguments {
    /// Scene files ({SCENES}) or builtin:NAME; each is measured by itself
    #[arg(value_name = "SCENE", default_value = "builtin:materials")]
    pub(crate) scenes: Vec<OsString>,
    /// Engines: gnurt, embree4
    #[arg(long = "engine", value_name = "LIST", value_parser = value::engine, value_delimiter = ',')]
    pub(crate) engines: Vec<String>,
    /// Parts of names of modes, like bvh-high,kd,compact
    #[arg(long = "mode", value_name = "LIST", value_delimiter = ',')]
    pub(crate) modes: Vec<String>,
    /// Runs of each mode, in turns
    #[arg(long, value_name = "N", value_parser = value::rounds, allow_hyphen_values = true, default_value = "5")]
    pub(crate) rounds: usize,
    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `bench dynamic`.
#[derive(Args, Debug)]
pub(crate) struct BenchDynamicArguments {
    /// Scene files ({SCENES}) or builtin:NAME; each is deformed and measured by itself
    #[arg(value_name = "SCENE", default_value = "builtin:materials")]
    pub(crate) scenes: Vec<OsString>,
    /// Cases: refit and rebuild of each scene; top: a tree over instances; stadium: a small thing in a large one; fuzzy: trees that know poses; crowd, crowd64: characters in 1000 or 64 poses
    #[arg(long = "case", value_name = "LIST", value_parser = value::motion_case, value_delimiter = ',')]
    pub(crate) cases: Vec<String>,
    /// Instances of the case top
    #[arg(long, value_name = "N", value_parser = value::instances, allow_hyphen_values = true, default_value = "100000")]
    pub(crate) instances: usize,
    /// Characters of a crowd
    #[arg(long, value_name = "N", value_parser = value::characters, allow_hyphen_values = true, default_value = "1000")]
    pub(crate) characters: usize,
    /// Frames of deformation; crowds take at most 10 of them
    #[arg(long, value_name = "N", value_parser = value::rounds, allow_hyphen_values = true, default_value = "100")]
    pub(crate) frames: usize,
    /// Columns and rows of the primary rays that diffuse ones start from
    #[arg(long, value_name = "N", value_parser = value::columns, allow_hyphen_values = true, default_value = "512")]
    pub(crate) size: u32,
    /// Builds of each quality, and runs over the rays, in turns
    #[arg(long, value_name = "N", value_parser = value::rounds, allow_hyphen_values = true, default_value = "5")]
    pub(crate) rounds: usize,
    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write times of updates and rates of rays as bars
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `bench paper`.
#[derive(Args, Debug)]
pub(crate) struct BenchPaperArguments {
    /// Scene files: office, soda (for the paper's Theater), conference, dragon (for its Buddha), or any other
    #[arg(value_name = "SCENE", required = true)]
    pub(crate) scenes: Vec<OsString>,
    /// Columns and rows of camera rays
    #[arg(long, value_name = "N", value_parser = value::columns, allow_hyphen_values = true, default_value = "1024")]
    pub(crate) size: u32,
    /// Runs of each
    #[arg(long, value_name = "N", value_parser = value::rounds, allow_hyphen_values = true, default_value = "5")]
    pub(crate) rounds: usize,
    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}

/// Arguments of `bench light`.
#[derive(Args, Debug)]
pub(crate) struct BenchLightArguments {
    /// Scene file ({SCENES}) or builtin:NAME
    #[arg(value_name = "SCENE", default_value = "builtin:slit")]
    pub(crate) scene: OsString,
    /// Integrators that are compared
    #[arg(long = "integrator", value_name = "LIST", value_parser = value::integrator, value_delimiter = ',', default_value = "ir,bir,mir")]
    pub(crate) integrators: Vec<Integrator>,
    /// Size of the pictures in pixels
    #[arg(short, long, value_name = "WxH", value_parser = value::resolution, allow_hyphen_values = true, default_value = "160x120")]
    pub(crate) resolution: Resolution,
    /// Seconds of all processors together for each picture
    #[arg(long, value_name = "TIME", value_parser = value::time, allow_hyphen_values = true, default_value = "10s")]
    pub(crate) time: Duration,
    /// Pictures by each integrator, under other seeds
    #[arg(long, value_name = "N", value_parser = value::rounds, allow_hyphen_values = true, default_value = "5")]
    pub(crate) rounds: usize,
    /// Samples per pixel of each of the two reference pictures by path
    #[arg(long, value_name = "N", value_parser = value::samples, allow_hyphen_values = true, default_value = "1024")]
    pub(crate) truth_spp: u32,
    /// Save the reference pictures here, the second with a 2 before its extension, and reuse them if they exist
    #[arg(long, value_name = "FILE")]
    pub(crate) truth: Option<PathBuf>,
    /// Write the last picture of each integrator's first seed as FOLDER/NAME.exr
    #[arg(long, value_name = "FOLDER")]
    pub(crate) pictures: Option<PathBuf>,
    /// Maximum depth: edges of a path
    #[arg(long, value_name = "N", value_parser = value::depth, allow_hyphen_values = true, default_value = "8")]
    pub(crate) max_depth: u32,
    /// Virtual lights per sample of a pixel, approximately
    #[arg(long, value_name = "N", value_parser = value::virtual_lights, allow_hyphen_values = true, default_value = "1024")]
    pub(crate) vpls: u32,
    /// path: guide paths to where a pilot rendering found light: on, off or auto; reference pictures are not guided
    #[arg(long, value_name = "WHEN", value_parser = value::guide, allow_hyphen_values = true, default_value = "off")]
    pub(crate) guide: Guiding,
    /// path, ir, bir, mir: search for lamps that mirrors and smooth glass show to rough surfaces: on, off or auto; for reference pictures, too
    #[arg(long, value_name = "WHICH", value_parser = value::caustics, allow_hyphen_values = true, default_value = "off")]
    pub(crate) caustics: Caustics,
    /// Limit of the geometry term of virtual lights, 1/area
    #[arg(long, value_name = "X", value_parser = value::clamp, allow_hyphen_values = true)]
    pub(crate) clamp: Option<f32>,
    /// Render each picture twice with the same virtual lights, to separate their error from that of rays
    #[arg(long)]
    pub(crate) separate_lights: bool,
    /// Make every material a Lambertian reflector of its base colour
    #[arg(long)]
    pub(crate) force_diffuse: bool,
    /// Write all points as comma-separated values
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write errors over samples as curves
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) view: ViewArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) files: FileArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}
