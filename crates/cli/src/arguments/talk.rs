// SPDX-License-Identifier: GPL-3.0-or-later
//! Options that say how much is said. With both `-q` and `-v` the later one wins. They may stand before
//! the command, too, as people know it from other programs. Tests: `tests`, `tests/program/arguments.rs`.

use std::ffi::{OsStr, OsString};

use clap::{ArgAction, Args, Command};

use crate::messages::Verbosity;

/// `-q` and `-v`.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Messages")]
pub(crate) struct TalkArguments {
    /// Say nothing but errors
    #[arg(short, long, overrides_with = "verbose")]
    quiet: bool,
    /// Say what is done and how long it takes; twice: all that is known
    #[arg(short, long, hide_short_help = true, action = ArgAction::Count, overrides_with = "quiet")]
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

/// The words of a command line, the program's name first, with those about talk that stand before the command moved
/// behind it; `root` knows the commands.
pub(crate) fn talk_behind_command(mut words: Vec<OsString>, root: &Command) -> Vec<OsString> {
    let count = words.iter().skip(1).take_while(|word| is_talk(word)).count();
    let talk: Vec<OsString> = words.drain(1..1 + count).collect();
    let (mut command, mut end) = (root, 1);
    while let Some(inner) = words.get(end).and_then(|word| command.find_subcommand(word)) {
        (command, end) = (inner, end + 1);
    }
    words.splice(end..end, talk);
    words
}

fn is_talk(word: &OsStr) -> bool {
    word.to_str().is_some_and(|word| {
        let short = |letters: &str| !letters.is_empty() && letters.chars().all(|c| matches!(c, 'q' | 'v'));
        matches!(word, "--quiet" | "--verbose") || word.strip_prefix('-').is_some_and(short)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::Arguments;
    use clap::CommandFactory;

    #[test]
    fn talk_may_stand_first() {
        for (line, wanted) in [
            ("gnurt -q render a.obj", "gnurt render -q a.obj"),
            ("gnurt -vv --quiet bench rays a.obj", "gnurt bench rays -vv --quiet a.obj"),
            ("gnurt render -q a.obj", "gnurt render -q a.obj"),
            ("gnurt -r 3x3 render -q", "gnurt -r 3x3 render -q"),
            ("gnurt -q", "gnurt -q"),
            ("gnurt", "gnurt"),
        ] {
            let words = line.split(' ').map(OsString::from).collect();
            let found: Vec<_> = talk_behind_command(words, &Arguments::command())
                .into_iter()
                .map(|w| w.into_string())
                .collect();
            let wanted: Vec<_> = wanted.split(' ').map(|word| Ok(word.to_owned())).collect();
            assert_eq!(found, wanted, "{line}");
        }
    }
}
