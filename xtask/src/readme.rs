// SPDX-License-Identifier: GPL-3.0-or-later
//! The commands of the README, read from it, so that `ci` runs the commands of newcomers.

use crate::command;
use crate::failure::Failure;

/// The README's commands.
pub(crate) struct ReadmeCommands {
    /// Renders a picture.
    pub(crate) first: Vec<String>,
    /// The picture that it makes.
    pub(crate) picture: String,
    /// Runs all tests.
    pub(crate) test: Vec<String>,
    /// Compiles and runs a program in C with the installed files, for a shell.
    pub(crate) compile: String,
}

/// Reads README.md.
pub(crate) fn readme_commands() -> Result<ReadmeCommands, Failure> {
    let path = command::root().join("README.md");
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text)
}

/// The first `cargo run`, the first `cargo test` (or `cargo xtask test`) and the first `cc` within code fences.
fn parse(text: &str) -> Result<ReadmeCommands, Failure> {
    let mut fenced = false;
    let mut commands = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if fenced {
            let bare = line.trim().trim_start_matches("$ ").split(" #").next().unwrap_or_default();
            commands.push(bare.split_whitespace().map(String::from).collect::<Vec<_>>());
        }
    }
    let find = |starts: &[&[&str]]| {
        let begins =
            |command: &&Vec<String>| starts.iter().any(|s| command.iter().take(s.len()).eq(s.iter()));
        commands.iter().find(begins).cloned()
    };
    let first =
        find(&[&["cargo", "run"]]).ok_or("README.md: no code block begins a line with 'cargo run'")?;
    let test = find(&[&["cargo", "test"], &["cargo", "xtask", "test"]]);
    let test = test.ok_or("README.md: no code block begins a line with 'cargo test'")?;
    let output = first.iter().position(|token| token == "-o" || token == "--output");
    let picture = output.and_then(|at| first.get(at + 1)).cloned();
    let picture = picture.ok_or("README.md: the first command names no picture with '-o'")?;
    let compile = find(&[&["cc"]]).ok_or("README.md: no code block begins a line with 'cc'")?.join(" ");
    Ok(ReadmeCommands { first, picture, test, compile })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "# Title\ncargo run no\n```sh\n$ cargo run --release -- render a -o b.png  # look\ncargo test --workspace\ncc a.c -o a && ./a\n```\n";

    #[test]
    fn commands_are_found() {
        let readme_commands = parse(GOOD).expect("both commands are there");
        assert_eq!(
            readme_commands.first.join(" "),
            "cargo run --release -- render a -o b.png",
            "the first command"
        );
        assert_eq!(
            (&readme_commands.picture[..], &readme_commands.test.join(" ")[..], &readme_commands.compile[..]),
            ("b.png", "cargo test --workspace", "cc a.c -o a && ./a"),
            "others"
        );
    }

    #[test]
    fn missing_commands_are_named() {
        for (from, to, expected) in [
            ("cargo run --", "x", "cargo run"),
            ("cargo test", "x", "cargo test"),
            (" -o ", " ", "'-o'"),
            ("cc ", "x", "'cc'"),
        ] {
            let failure = parse(&GOOD.replace(from, to)).err().unwrap_or_default();
            assert!(failure.contains(expected), "without {from}: {failure}");
        }
    }
}
