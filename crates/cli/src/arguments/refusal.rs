// SPDX-License-Identifier: GPL-3.0-or-later
//! The argument parser's errors, in the one-line form of all errors of this program.
//! Tests: `tests/program/arguments.rs`, and `tests` here.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory};

use super::Arguments;
use crate::command_line::command_line;
use crate::nearest::unknown;

/// The outcome of an invalid command line.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// Help or version: text for standard output, and success.
    Answer(String),
    /// A mistake: the text behind `error:`.
    Mistake(String),
}

/// Rewrites the parser's messages.
pub(crate) fn explain(error: &clap::Error) -> Refusal {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Refusal::Answer(error.render().to_string()),
        _ => Refusal::Mistake(mistake(error)),
    }
}

fn mistake(error: &clap::Error) -> String {
    let (argument, value) = (text(error, ContextKind::InvalidArg), text(error, ContextKind::InvalidValue));
    match error.kind() {
        ErrorKind::ValueValidation => {
            let why = std::error::Error::source(error).map(ToString::to_string).unwrap_or_default();
            format!("{} '{value}': {why}", name_of(&argument))
        }
        ErrorKind::InvalidValue if value.is_empty() => {
            format!("{}: a value is missing; give {argument}", name_of(&argument))
        }
        ErrorKind::UnknownArgument => unknown_argument(&argument),
        ErrorKind::InvalidSubcommand => {
            let root = Arguments::command();
            let given = text(error, ContextKind::InvalidSubcommand);
            unknown("command", &given, &commands(used_command(&root)))
        }
        ErrorKind::MissingSubcommand | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let root = Arguments::command();
            format!("command missing; valid are: {}", commands(used_command(&root)).join(", "))
        }
        ErrorKind::MissingRequiredArgument => {
            format!("{} is missing; see --help", argument.replace('\n', ", "))
        }
        ErrorKind::InvalidUtf8 => "an argument is invalid UTF-8; only file names may be other bytes".into(),
        _ => first_line(error),
    }
}

/// `unknown option '--sppp'; did you mean '--spp'? valid are: ...`, or a file name too many.
fn unknown_argument(argument: &str) -> String {
    if !argument.starts_with('-') {
        return format!("'{argument}' is one argument too many; see --help");
    }
    let root = Arguments::command();
    let options: Vec<String> = used_command(&root)
        .get_arguments()
        .flat_map(|option| option.get_long_and_visible_aliases().unwrap_or_default())
        .map(|long| format!("--{long}"))
        .collect();
    let mut options: Vec<&str> = options.iter().map(String::as_str).collect();
    if !options.contains(&"--help") {
        options.push("--help");
    }
    // `--sppp=4` means the option before the sign.
    let written = argument.split('=').next().unwrap_or(argument);
    let short = written.strip_prefix('-').and_then(|letters| letters.chars().next());
    let is_short = |option: &clap::Arg| option.get_short().is_some() && option.get_short() == short;
    // The option is known, but invalid here.
    if options.contains(&written) || used_command(&root).get_arguments().any(is_short) {
        return format!("{written}: options follow the command, as in 'gnurt render SCENE {written} ...'");
    }
    unknown("option", written, &options)
}

/// The subcommand that the process was called with, or its subcommand.
fn used_command(root: &Command) -> &Command {
    command_line().iter().skip(1).fold(root, |command, name| command.find_subcommand(name).unwrap_or(command))
}

fn commands(root: &Command) -> Vec<&str> {
    let visible = root.get_subcommands().filter(|command| !command.is_hide_set());
    visible.map(Command::get_name).chain(["help"]).collect()
}

/// `--spp <N>` without the part after the name.
fn name_of(argument: &str) -> &str {
    argument.split([' ', '=', '[']).next().unwrap_or(argument)
}

/// A piece of the parser's knowledge as text.
fn text(error: &clap::Error, kind: ContextKind) -> String {
    match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        Some(ContextValue::Strings(texts)) => texts.join(", "),
        Some(other) => other.to_string(),
        None => String::new(),
    }
}

/// The parser's own message, for kinds of errors that this program's arguments never cause.
fn first_line(error: &clap::Error) -> String {
    let whole = error.render().to_string();
    let line = whole.lines().next().unwrap_or("bad arguments");
    line.strip_prefix("error: ").unwrap_or(line).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    fn message(command_line: &[&str]) -> String {
        let line = std::iter::once("gnurt").chain(command_line.iter().copied());
        match explain(&Arguments::try_parse_from(line).expect_err("a bad command line")) {
            Refusal::Answer(text) | Refusal::Mistake(text) => text,
        }
    }

    #[test]
    fn the_arguments_are_consistent() {
        let root = Arguments::command();
        root.clone().debug_assert();
        // The library's own checks are left out of tests, as all of its debugging is.
        fn check(command: &Command) {
            let mut names: Vec<&str> = command.get_arguments().filter_map(clap::Arg::get_long).collect();
            names.sort_unstable();
            let twice = names.windows(2).find(|pair| pair[0] == pair[1]);
            assert_eq!(twice, None, "{}: one name, two options", command.get_name());
            command.get_subcommands().for_each(check);
        }
        check(&root);
    }

    #[test]
    fn says_which_option_and_what_would_be_right() {
        let spp = message(&["render", "a.obj", "--spp", "0"]);
        assert_eq!(spp, "--spp '0': give a whole number from 1 to 2147483647", "a bad value");
        assert!(message(&["render"]).contains("<SCENE> is missing"), "{}", message(&["render"]));
        let missing = message(&["render", "a.obj", "--spp"]);
        assert!(missing.contains("--spp: a value is missing"), "{missing}");
        let command = message(&["rendr"]);
        assert!(command.contains("did you mean 'render'?"), "{command}");
        assert!(
            message(&["info", "a.obj", "b.obj"]).contains("'b.obj' is one argument too many"),
            "a file too many"
        );
        assert!(message(&[]).starts_with("command missing"), "{}", message(&[]));
    }

    #[test]
    fn help_is_an_answer() {
        let error = Arguments::try_parse_from(["gnurt", "--help"]).expect_err("help is told as an error");
        assert!(
            matches!(explain(&error), Refusal::Answer(text) if text.contains("render")),
            "help is an answer"
        );
    }
}
