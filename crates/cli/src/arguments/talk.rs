// SPDX-License-Identifier: GPL-3.0-or-later
//! Options that say how much is said. Source: original. With both `-q` and `-v` the later one wins.

use clap::{ArgAction, Args};

use crate::messages::Verbosity;

/// `-q` and `-v`.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct TalkArguments {
    /// Say nothing but errors
    #[arg(short, long, overrides_with = "verbose")]
    quiet: bool,
    /// Say what is done and how long it takes; twice: all that is known
    #[arg(short, long, action = ArgAction::Count, overrides_with = "quiet")]
    verbose: u8,
}

impl TalkArguments {
    /// What the options ask for; `None` if there are none.
    pub(crate) fn verbosity(self) -> Option<Verbosity> {
        match (self.quiet, self.verbose) {
            (true, _) => Some(Verbosity::Quiet),
            (false, 0) => None,
            (false, 1) => Some(Verbosity::Details),
            (false, _) => Some(Verbosity::Everything),
        }
    }
}
