// SPDX-License-Identifier: GPL-3.0-or-later
//! Two lengths of help for commands with many options: what most people need, and all.
//! Tests: `tests/program/interface.rs`.

use clap::{ArgAction, Args};

/// `--help` and `--help-all`, in place of the parser's own.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Messages")]
pub(crate) struct HelpArguments {
    /// Print this help
    #[arg(short, long, action = ArgAction::HelpShort)]
    help: Option<bool>,
    /// Print all options
    #[arg(long, action = ArgAction::HelpLong)]
    help_all: Option<bool>,
}
