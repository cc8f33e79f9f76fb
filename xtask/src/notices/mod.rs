// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask notices [--check]`: the copyright notices of all parts by others that our program, libraries and Python package
//! contain, in one file, made from Cargo.lock and the licence files of the parts' own packages.
//! Most of the parts' licences want their notices in every copy. Invariant: the same lock file gives the same
//! file on every machine. Tests: `tests` of the submodules; `--check` is a step of CI and of `dist`.

mod parts;
mod texts;

use crate::command;
use crate::failure::Failure;
use crate::install::files::{read, write};
use parts::Part;

/// Where it is stored: maturin takes nothing from above the Python package's folder.
pub(crate) const FILE: &str = "bindings/python/LICENSE-THIRD-PARTY.txt";
/// For which machine our packages are made; the parts for windows and clocks of other systems are others.
const TARGET: &str = "x86_64-unknown-linux-gnu";
const USAGE: &str = "usage: cargo xtask notices [--check] [--target TRIPLE]";
/// Fewer bytes than this are no notices of more than a hundred parts.
const FEWEST_BYTES: usize = 1 << 14;

/// Writes the file, or reports that it is out of date.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let (mut checks, mut target) = (false, TARGET);
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match &argument[..] {
            "--help" => {
                eprintln!("{USAGE}");
                return Ok(());
            }
            "--check" => checks = true,
            "--target" => target = rest.next().ok_or_else(|| format!("--target: triple missing; {USAGE}"))?,
            other => return Err(format!("unknown argument '{other}'; {USAGE}")),
        }
    }
    let text = text(&parts::of_packages(target)?)?;
    let file = command::root().join(FILE);
    if !checks {
        return write(&file, &text);
    }
    if read(&file).unwrap_or_default() == text {
        return Ok(());
    }
    Err(format!("{FILE} is out of date; `cargo xtask notices` writes it again"))
}

/// The file is up to date with the lock file.
pub(crate) fn check() -> Result<(), Failure> {
    run(&["--check".to_owned()])
}

/// The notices as they are stored.
pub(crate) fn retained(root: &std::path::Path) -> Result<String, Failure> {
    let text = read(&root.join(FILE))?;
    if text.len() < FEWEST_BYTES {
        return Err(format!("{FILE}: only {} bytes; `cargo xtask notices` writes it again", text.len()));
    }
    Ok(text)
}

/// The list of parts, then each licence text once, with the parts that it is for.
fn text(parts: &[Part]) -> Result<String, Failure> {
    let mut text = "Parts by others that GNU RT's program, libraries and Python package contain, and their notices.\n\
        GNU RT itself is GPL-3.0-or-later: see COPYING. `cargo xtask notices` makes this file from Cargo.lock.\n\n"
        .to_owned();
    for Part { name, version, license, repository, .. } in parts {
        text += &format!("{name} {version}: {license}");
        text += &if repository.is_empty() { String::new() } else { format!(" <{repository}>") };
        text.push('\n');
    }
    text += "Rust's standard library: MIT OR Apache-2.0 <https://github.com/rust-lang/rust>\n";
    for (notice, holders) in texts::of(parts)? {
        text += &format!("\n{}\n{}\n\n{notice}\n", "=".repeat(80), holders.join(", "));
    }
    Ok(text)
}
