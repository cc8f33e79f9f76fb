// SPDX-License-Identifier: GPL-3.0-or-later
//! Two lengths of help for commands with many options, the frequent options and all of them; and the formats
//! in help texts.
//! Tests: `tests/program/interface.rs`.

use clap::{Arg, ArgAction, Args, Command};
use gnurt::FORMATS;
use gnurt::image::PictureFormat;

/// `--help` and `--help-all`, which replace the parser's own.
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

/// Fills `{SCENES}`, `{PICTURES}` (written) and `{READ_PICTURES}` in the help of a command and of those within it, from
/// the tables of formats.
pub(crate) fn with_formats(command: Command) -> Command {
    let inner: Vec<String> = command.get_subcommands().map(|inner| inner.get_name().to_owned()).collect();
    let command = inner.into_iter().fold(command, |command, name| command.mut_subcommand(name, with_formats));
    let command = match command.get_after_help().and_then(|text| filled(&text.to_string())) {
        Some(text) => command.after_help(text),
        None => command,
    };
    command.mut_args(|argument: Arg| {
        let argument = match argument.get_help().and_then(|text| filled(&text.to_string())) {
            Some(text) => argument.help(text),
            None => argument,
        };
        match argument.get_long_help().and_then(|text| filled(&text.to_string())) {
            Some(text) => argument.long_help(text),
            None => argument,
        }
    })
}

/// The text with its placeholders filled, if it has any.
fn filled(text: &str) -> Option<String> {
    text.contains('{').then(|| {
        text.replace("{SCENES}", &FORMATS.read_extensions())
            .replace("{READ_PICTURES}", &PictureFormat::read_extensions())
            .replace("{PICTURES}", &PictureFormat::written_extensions())
    })
}
