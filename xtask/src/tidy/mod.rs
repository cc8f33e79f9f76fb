// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask tidy`: rules of ARCHITECTURE.md and CONTRIBUTING.md that the compiler does not check. One
//! file per rule; each rule is a function from plain text to complaints and has a test in which it fails.

mod arrows;
mod attributes;
mod circles;
mod citations;
mod comments;
mod files;
mod heads;
mod imports;
mod known_circles;
mod known_prose;
mod lazy;
mod length;
mod manifests;
mod modules;
mod pages;
mod proofs;
mod prose;
mod rust_code;
mod test_files;
mod unsafe_code;
mod vocabulary;

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;
use files::SourceFile;

/// Checks one file; returns line numbers (from 1) and faults.
type Rule = fn(&SourceFile) -> Vec<(usize, String)>;

const RULES: [Rule; 7] = [
    heads::licence,
    heads::contract,
    length::check,
    unsafe_code::check,
    attributes::check,
    vocabulary::check,
    lazy::check,
];

/// Prints every complaint to stderr; fails if there is one.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    if let Some(argument) = arguments.first() {
        return Err(format!("tidy takes no arguments, not '{argument}'"));
    }
    let root = command::root();
    let metadata = Workspace::metadata()?;
    let mut complaints = arrows::check(&Workspace::from_metadata(&metadata)?.packages);
    complaints.extend(manifests::check(&metadata));
    let architecture = root.join("ARCHITECTURE.md");
    if let Ok(text) = std::fs::read_to_string(&architecture) {
        complaints.extend(arrows::check_printed(&text));
    }
    let bibliography = root.join("docs/papers.bib");
    let bibliography = std::fs::read_to_string(&bibliography)
        .map_err(|error| format!("{}: {error}", bibliography.display()))?;
    let keys = citations::keys(&bibliography);
    let files = files::all(&root)?;
    complaints.extend(circles::check(&files));
    complaints.extend(proofs::check(&files));
    complaints.extend(test_files::check(&files));
    let mut pages = files::pages(&root)?;
    complaints.extend(pages::check(&root, &pages));
    pages.extend(files.iter().filter(|file| file.is_rust()).map(comments::page));
    complaints.extend(prose::check(&pages));
    for file in &files {
        let found = RULES.iter().flat_map(|rule| rule(file)).chain(citations::check(file, &keys));
        complaints.extend(found.map(|(line, what)| format!("{}:{line}: {what}", file.path)));
    }
    for complaint in &complaints {
        eprintln!("{complaint}");
    }
    if complaints.is_empty() { Ok(()) } else { Err(format!("tidy has {} complaints", complaints.len())) }
}
