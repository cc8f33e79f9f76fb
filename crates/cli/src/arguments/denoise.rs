// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `gnurt denoise`, which filters finished pictures and films. Tests: `tests/program/denoise.rs`.

use std::path::PathBuf;

use clap::Args;

use super::value::{self, FrameRange};
use super::{DenoiserArguments, LightArguments, MachineArguments, OcioArguments, VerbosityArguments};

/// Arguments of `denoise`.
#[derive(Args, Debug)]
pub(crate) struct DenoiseArguments {
    /// Picture with layers of albedo and normal (.exr), or a film's frames: frame.####.exr
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Picture to write: {PICTURES}; of a film, with # for the number
    #[arg(short, long, value_name = "FILE", allow_hyphen_values = true, required = true)]
    pub(crate) output: PathBuf,
    /// Frames of the film, both ends included: 0..47, or every second one: 0..47:2 [default: all files]
    #[arg(long, value_name = "FIRST..LAST[:STEP]", value_parser = value::frames, allow_hyphen_values = true)]
    pub(crate) frames: Option<FrameRange>,
    /// Frames on each side to borrow light from, where a point's light stays the same; 0 = each frame by itself [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=16), allow_hyphen_values = true)]
    pub(crate) denoise_window: Option<u8>,
    #[command(flatten)]
    pub(crate) denoiser: DenoiserArguments,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    #[command(flatten)]
    pub(crate) ocio: OcioArguments,
    #[command(flatten)]
    pub(crate) machine: MachineArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}
