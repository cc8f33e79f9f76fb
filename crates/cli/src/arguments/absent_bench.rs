// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `bench` in a program without benchmarks: all are taken, for a message to say how to get them.

use std::ffi::OsString;

use clap::Args;

use super::{MachineArguments, VerbosityArguments};

/// Arguments of `bench`.
#[derive(Args, Debug)]
pub(crate) struct BenchArguments {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _all: Vec<OsString>,
    #[command(flatten)]
    verbosity_arguments: VerbosityArguments,
}

impl BenchArguments {
    pub(crate) fn verbosity_arguments(&self) -> &VerbosityArguments {
        &self.verbosity_arguments
    }

    pub(crate) fn machine(&self) -> Option<&MachineArguments> {
        None
    }
}
