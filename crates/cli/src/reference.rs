// SPDX-License-Identifier: GPL-3.0-or-later
//! The reference page of the command line in Markdown, made from the description of commands and options.
//! `docs/reference/command-line.md` is its output. Tests: `tests/program/manuals.rs`.

use std::fmt::Write;

use clap::{Arg, Command};

const HEAD: &str = "<!-- SPDX-License-Identifier: GPL-3.0-or-later -->
# Command line

Every command and option of `gnurt`, as `gnurt help COMMAND` shows them. `gnurt manuals DIR` writes this page from the
program's own description, beside man pages and completions.
";

/// The page of a program and all of its commands that help lists.
pub(crate) fn page(program: &Command) -> String {
    let mut page = HEAD.to_owned();
    command(&mut page, program, "gnurt");
    page
}

fn command(page: &mut String, command: &Command, name: &str) {
    let _ = write!(page, "\n## {name}\n");
    if let Some(about) = command.get_long_about().or_else(|| command.get_about()) {
        let _ = write!(page, "\n{}\n", sentence(&about.to_string()));
    }
    let usage = command.clone().render_usage().to_string();
    let _ = write!(page, "\n```text\n{}\n```\n", usage.trim_start_matches("Usage: ").trim());
    let mut heading = None;
    for argument in command.get_arguments().filter(|argument| !argument.is_hide_set()) {
        let own = argument.get_help_heading().unwrap_or(match argument.is_positional() {
            true => "Arguments",
            false => "Options",
        });
        if heading.replace(own) != Some(own) {
            let _ = write!(page, "\n**{own}**\n\n");
        }
        item(page, argument);
    }
    if let Some(more) = command.get_after_long_help().or_else(|| command.get_after_help()) {
        let _ = write!(page, "\n```text\n{}\n```\n", more.to_string().trim());
    }
    for inner in command.get_subcommands().filter(|inner| !inner.is_hide_set()) {
        self::command(page, inner, &format!("{name} {}", inner.get_name()));
    }
}

/// One argument: its names and values, its text, its values by name, its default.
fn item(page: &mut String, argument: &Arg) {
    let long = argument.get_long().map(|long| format!("--{long}"));
    let short = argument.get_short().map(|short| format!("-{short}"));
    let mut names = [short, long].into_iter().flatten().collect::<Vec<_>>().join(", ");
    if argument.is_positional() || argument.get_action().takes_values() {
        let values = argument.get_value_names().unwrap_or_default();
        let values = values.iter().map(|value| value.to_string()).collect::<Vec<_>>().join(" ");
        names = format!("{names} {values}").trim().to_owned();
    }
    let help = argument.get_long_help().or_else(|| argument.get_help());
    let _ = write!(page, "* `{names}`: {}", sentence(&help.map(ToString::to_string).unwrap_or_default()));
    let takes_values = argument.get_action().takes_values();
    let is_listed = takes_values && !argument.is_hide_possible_values_set();
    let values = argument.get_possible_values().into_iter().filter(|value| is_listed && !value.is_hide_set());
    let values: Vec<_> = values.map(|value| format!("`{}`", value.get_name())).collect();
    if !values.is_empty() {
        let _ = write!(page, " Values: {}.", values.join(", "));
    }
    let defaults: Vec<_> =
        argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    if !defaults.is_empty() && takes_values && !argument.is_hide_default_value_set() {
        let _ = write!(page, " Default: `{}`.", defaults.join(" "));
    }
    page.push('\n');
}

/// A text in one line, with a full stop.
fn sentence(text: &str) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match text.chars().last() {
        None | Some('.' | ':' | ')' | '!') => text,
        Some(_) => text + ".",
    }
}
