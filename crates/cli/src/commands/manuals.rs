// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt manuals DIR`: a man page for the program and one for each command, completions for bash, zsh and fish, and the
//! reference page in Markdown, made from the command line's own description. Man pages and completions by clap's crates.
//! Tests: `tests/program/manuals.rs`.

use std::path::Path;

use clap::Command;
use clap_complete::Shell;

use crate::arguments::{Arguments, ManualsArguments};
use crate::failure::{Failure, Outcome};
use crate::reference;

/// Writes them all.
pub(crate) fn run(arguments: &ManualsArguments) -> Outcome {
    let folder = &arguments.folder;
    let failed =
        |error: std::io::Error| Failure::data(format!("cannot write to {}: {error}", folder.display()));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let mut program = without_help(Arguments::with_formats());
    program.build();
    write_pages(&program, "gnurt", folder).map_err(failed)?;
    std::fs::write(folder.join("command-line.md"), reference::page(&program)).map_err(failed)?;
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        clap_complete::generate_to(shell, &mut Arguments::with_formats(), "gnurt", folder).map_err(failed)?;
    }
    Ok(())
}

/// Without the commands `help`, which have no page.
fn without_help(command: Command) -> Command {
    let inner: Vec<String> = command.get_subcommands().map(|inner| inner.get_name().to_owned()).collect();
    let command = inner.into_iter().fold(command, |command, name| command.mut_subcommand(name, without_help));
    command.disable_help_subcommand(true)
}

/// The page of a command, and those of the commands within it.
fn write_pages(command: &Command, name: &str, folder: &Path) -> std::io::Result<()> {
    let mut page = Vec::new();
    let title = name.to_uppercase();
    // The page writes "gnurt render"; its file and title are gnurt-render, as for other programs of many
    // commands. Options without short help would have no text there.
    let named =
        command.clone().display_name(name.to_owned()).mut_args(|argument| argument.hide_short_help(false));
    clap_mangen::Man::new(named).title(title).render(&mut page)?;
    std::fs::write(folder.join(format!("{name}.1")), page)?;
    for inner in command.get_subcommands().filter(|inner| !inner.is_hide_set()) {
        write_pages(inner, &format!("{name}-{}", inner.get_name()), folder)?;
    }
    Ok(())
}
