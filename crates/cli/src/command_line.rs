// SPDX-License-Identifier: GPL-3.0-or-later
//! The words that the program was called with. They are not always those of the process, whose first ones may be an interpreter's.
//! State is global because a command line is.
//! Tests: `tests`.

use std::ffi::OsString;
use std::path::Path;
use std::sync::OnceLock;

static NAMES: OnceLock<Vec<OsString>> = OnceLock::new();

/// Stores the command line, the program's name first; later ones are ignored.
pub(crate) fn keep(command_line: Vec<OsString>) {
    let _earlier_ones_stay = NAMES.set(command_line);
}

/// The command line, the program's name first.
pub(crate) fn command_line() -> &'static [OsString] {
    NAMES.get().map_or(&[], Vec::as_slice)
}

/// A tool that a command line names.
#[cfg_attr(
    not(any(feature = "osl", test)),
    expect(dead_code, reason = "a program without the language reads the tool's name only")
)]
pub(crate) struct Tool {
    pub(crate) name: String,
    /// Whether the program was called by the tool's name, through a link.
    pub(crate) is_link: bool,
    /// The tool's own arguments.
    pub(crate) arguments: Vec<String>,
}

/// The tool that is named by the program's own name, or else by its first argument.
pub(crate) fn tool(command_line: &[OsString], is_tool: impl Fn(&str) -> bool) -> Option<Tool> {
    let mut command_line = command_line.iter().map(|argument| argument.to_string_lossy().into_owned());
    let called = command_line.next()?;
    let called = Path::new(&called).file_stem()?.to_string_lossy().into_owned();
    let is_link = is_tool(&called);
    let name = if is_link { called } else { command_line.next()? };
    is_tool(&name).then(|| Tool { name, is_link, arguments: command_line.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tools_are_named_by_links_and_arguments() {
        for (command_line, expected) in [
            (&["gnurt", "oslc", "-q", "a.osl"][..], Some(("oslc", false, &["-q", "a.osl"][..]))),
            (&["/usr/bin/oslc", "a.osl"], Some(("oslc", true, &["a.osl"]))),
            (&["oslc.exe"], Some(("oslc", true, &[]))),
            (&["gnurt", "render", "oslc"], None),
            (&["gnurt"], None),
            (&[], None),
        ] {
            let command_line: Vec<OsString> = command_line.iter().map(OsString::from).collect();
            let found = tool(&command_line, |name| name == "oslc");
            let found = found.map(|tool| (tool.name, tool.is_link, tool.arguments));
            let expected = expected.map(|(name, is_link, arguments)| {
                (name.to_owned(), is_link, arguments.iter().map(ToString::to_string).collect())
            });
            assert_eq!(found, expected, "{command_line:?}");
        }
    }
}
