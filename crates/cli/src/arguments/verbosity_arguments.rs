// SPDX-License-Identifier: GPL-3.0-or-later
//! Options for the amount of messages. With both `-q` and `-v` the later one wins. They may precede the
//! command, too, as in other programs. Tests: `tests`, `tests/program/arguments.rs`.

use std::ffi::{OsStr, OsString};

use clap::{ArgAction, Args, Command};

use crate::messages::Verbosity;

/// `-q` and `-v`.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Messages")]
pub(crate) struct VerbosityArguments {
    /// Print errors only
    #[arg(short, long, overrides_with = "verbose")]
    quiet: bool,
    /// Print each step and its time; twice: everything
    #[arg(short, long, hide_short_help = true, action = ArgAction::Count, overrides_with = "quiet")]
    verbose: u8,
}

impl VerbosityArguments {
    /// The requested verbosity; `None` without an option.
    pub(crate) fn verbosity(self) -> Option<Verbosity> {
        match (self.quiet, self.verbose) {
            (true, _) => Some(Verbosity::Quiet),
            (false, 0) => None,
            (false, 1) => Some(Verbosity::Details),
            (false, _) => Some(Verbosity::Everything),
        }
    }
}

/// The words of a command line, the program's name first, with options of verbosity that precede the command
/// moved behind it; `root` defines the commands.
pub(crate) fn verbosity_behind_command(mut command_line: Vec<OsString>, root: &Command) -> Vec<OsString> {
    let count = command_line.iter().skip(1).take_while(|argument| is_verbosity(argument)).count();
    let verbosity_arguments: Vec<OsString> = command_line.drain(1..1 + count).collect();
    let (mut command, mut end) = (root, 1);
    while let Some(inner) = command_line.get(end).and_then(|argument| command.find_subcommand(argument)) {
        (command, end) = (inner, end + 1);
    }
    command_line.splice(end..end, verbosity_arguments);
    command_line
}

fn is_verbosity(argument: &OsStr) -> bool {
    argument.to_str().is_some_and(|argument| {
        let short = |letters: &str| !letters.is_empty() && letters.chars().all(|c| matches!(c, 'q' | 'v'));
        matches!(argument, "--quiet" | "--verbose") || argument.strip_prefix('-').is_some_and(short)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::Arguments;
    use clap::CommandFactory;

    #[test]
    fn talk_may_stand_first() {
        for (line, expected) in [
            ("gnurt -q render a.obj", "gnurt render -q a.obj"),
            ("gnurt -vv --quiet bench rays a.obj", "gnurt bench rays -vv --quiet a.obj"),
            ("gnurt render -q a.obj", "gnurt render -q a.obj"),
            ("gnurt -r 3x3 render -q", "gnurt -r 3x3 render -q"),
            ("gnurt -q", "gnurt -q"),
            ("gnurt", "gnurt"),
        ] {
            let command_line = line.split(' ').map(OsString::from).collect();
            let found: Vec<_> = verbosity_behind_command(command_line, &Arguments::command())
                .into_iter()
                .map(|w| w.into_string())
                .collect();
            let expected: Vec<_> = expected.split(' ').map(|argument| Ok(argument.to_owned())).collect();
            assert_eq!(found, expected, "{line}");
        }
    }
}
