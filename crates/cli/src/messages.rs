// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages of the program: lines on standard error, and reports on standard output. See
//! docs/reference/cli.md. Invariants: a message is one line for any contents of a file or an argument;
//! colours only on a terminal; a closed standard error or output is no panic. Tests:
//! `tests::one_line_without_control_characters`, `tests/program/interface.rs`.

use std::fmt;
use std::io::{self, IsTerminal, Write};

use gnurt::image::system_reason;

use crate::failure::{Failure, Outcome};

/// The amount of messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verbosity {
    /// Errors only.
    Quiet,
    /// Warnings, notes and, on a terminal, progress.
    #[default]
    Normal,
    /// The steps and their times.
    Details,
    /// All that is known.
    Everything,
}

/// The writer of messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Messages {
    verbosity: Verbosity,
    color: bool,
    terminal: bool,
}

impl Messages {
    /// A speaker for standard error as it is.
    pub(crate) fn new(verbosity: Verbosity) -> Self {
        let terminal = io::stderr().is_terminal();
        let expected = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let able = std::env::var_os("TERM").is_none_or(|term| term != "dumb");
        Self { verbosity, color: terminal && expected && able, terminal }
    }

    /// Whether a progress bar would be visible and is enabled.
    pub(crate) fn shows_progress(&self) -> bool {
        self.terminal && self.verbosity >= Verbosity::Normal
    }

    /// Whether success is to be silent.
    pub(crate) fn is_quiet(&self) -> bool {
        self.verbosity == Verbosity::Quiet
    }

    /// The same, but for errors only: for work that is reported elsewhere.
    pub(crate) fn silent(self) -> Self {
        Self { verbosity: Verbosity::Quiet, ..self }
    }

    /// The reason of a failure.
    pub(crate) fn error(&self, text: impl fmt::Display) {
        self.line("error", "\x1b[1;31m", text);
    }

    /// Something odd that was dealt with.
    pub(crate) fn warning(&self, text: impl fmt::Display) {
        if self.verbosity >= Verbosity::Normal {
            self.line("warning", "\x1b[1;33m", text);
        }
    }

    /// Something that was decided for the user.
    pub(crate) fn note(&self, text: impl fmt::Display) {
        if self.verbosity >= Verbosity::Normal {
            self.line("note", "\x1b[1;36m", text);
        }
    }

    /// Messages of `-v`.
    pub(crate) fn detail(&self, text: impl fmt::Display) {
        if self.verbosity >= Verbosity::Details {
            self.line("info", "\x1b[1m", text);
        }
    }

    /// Messages of `-vv`.
    pub(crate) fn trace(&self, text: impl fmt::Display) {
        if self.verbosity >= Verbosity::Everything {
            self.line("debug", "\x1b[2m", text);
        }
    }

    /// A requested table: several lines on standard error, even under `-q`.
    pub(crate) fn table(&self, text: impl fmt::Display) {
        // A closed standard error cannot be reported.
        let _ = writeln!(io::stderr().lock(), "{text}");
    }

    fn line(&self, label: &str, color: &str, text: impl fmt::Display) {
        let text = one_line(&text.to_string());
        let (on, off) = if self.color { (color, "\x1b[0m") } else { ("", "") };
        // One write, so that lines of several threads never mix. A closed standard error cannot be reported.
        let _ = io::stderr().lock().write_all(format!("{on}{label}:{off} {text}\n").as_bytes());
    }
}

/// Writes a report to standard output; a reader that left early is no failure.
pub(crate) fn print(text: impl fmt::Display) -> Outcome {
    let mut out = io::stdout().lock();
    writeln!(out, "{text}").and_then(|()| out.flush()).map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::Unheard,
        _ => Failure::data(format_args!("standard output: {}", system_reason(&error))),
    })
}

/// Line breaks become blanks, other control characters the replacement character. Text after a blank line is
/// for callers with space for it: the source line that a shader's compiler draws.
fn one_line(text: &str) -> String {
    let text = text.split("\n\n").next().unwrap_or_default();
    let printable = |c: char| match c {
        '\n' | '\r' | '\t' => ' ',
        c if c.is_control() => '\u{fffd}',
        c => c,
    };
    text.trim_end().chars().map(printable).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_without_control_characters() {
        assert_eq!(one_line("a\nb\x1b[31m\tc\n"), "a b\u{fffd}[31m c", "a name in a message moves no cursor");
        assert_eq!(one_line("a.osl:1:2: what\n\n1 | drawn"), "a.osl:1:2: what", "no drawings");
    }

    #[test]
    fn verbosity_is_ordered() {
        assert!(
            Verbosity::Quiet < Verbosity::Normal && Verbosity::Details < Verbosity::Everything,
            "least first"
        );
    }
}
