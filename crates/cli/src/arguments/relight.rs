// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `gnurt relight`, which mixes light groups of finished pictures. Tests: `tests/program/relight.rs`.

use std::path::PathBuf;

use clap::Args;
use gnurt::relight::Gain;

use super::value;
use super::{LightArguments, OcioArguments, VerbosityArguments};

/// Arguments of `relight`.
#[derive(Args, Debug)]
pub(crate) struct RelightArguments {
    /// Picture with light groups (.exr), as `gnurt render --light-groups` writes it, or a film's frames: frame.####.exr
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Gains of groups, one number or three between commas: key=2 sky=1,0.8,0.6; rest = light without a group [default: 1]
    #[arg(value_name = "GROUP=GAIN", value_parser = value::gain)]
    pub(crate) gains: Vec<Gain>,
    /// Picture to write: {PICTURES}; of a film, with # for the number
    #[arg(short, long, value_name = "FILE", allow_hyphen_values = true, required = true)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) light: LightArguments,
    #[command(flatten)]
    pub(crate) ocio: OcioArguments,
    #[command(flatten)]
    pub(crate) verbosity_arguments: VerbosityArguments,
}
