// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments of `bench` in a program without benchmarks: all are taken, for a message to say how to get them.
//! Tests: `tests`, and `cargo xtask ci`, which compiles the program without features.

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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Command;

    #[test]
    fn all_arguments_are_taken() {
        let command = BenchArguments::augment_args(Command::new("bench"));
        for arguments in [&["bench"][..], &["bench", "rays", "--threads", "2"], &["bench", "--no-such", "-z"]]
        {
            let taken = command.clone().try_get_matches_from(arguments);
            assert!(taken.is_ok(), "{arguments:?}: {:?}", taken.err());
        }
    }
}
