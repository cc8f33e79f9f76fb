// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `join`.

use std::path::PathBuf;

use clap::Args;

use super::{DenoiserArguments, LightArguments, MachineArguments, OcioArguments, VerbosityArguments};

/// Arguments of `join`.
#[derive(Args, Debug)]
pub(crate) struct JoinArguments {
    /// Pieces from `gnurt render --piece`: all of one picture, in any order; duplicates are allowed
    #[arg(value_name = "PIECE", required = true)]
    pub(crate) pieces: Vec<PathBuf>,
    /// Picture to write: {PICTURES}
    #[arg(short, long, value_name = "FILE", allow_hyphen_values = true, required = true)]
    pub(crate) output: PathBuf,
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
