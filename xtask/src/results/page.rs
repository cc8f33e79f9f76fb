// SPDX-License-Identifier: GPL-3.0-or-later
//! The part of a page between two markers, which a program writes. Tests: below.

use std::path::Path;

use crate::failure::Failure;

const BEGIN: &str = "<!-- measured: begin -->";
const END: &str = "<!-- measured: end -->";

/// Writes `text` between the markers of the file.
pub(super) fn replace(path: &Path, text: &str) -> Result<(), Failure> {
    let name = path.display();
    let old = std::fs::read_to_string(path).map_err(|error| format!("'{name}' cannot be read: {error}"))?;
    let new = between(&old, text).ok_or_else(|| format!("'{name}': no lines '{BEGIN}' and '{END}'"))?;
    std::fs::write(path, new).map_err(|error| format!("'{name}' cannot be written: {error}"))
}

fn between(page: &str, text: &str) -> Option<String> {
    let (head, rest) = page.split_once(BEGIN)?;
    let (_, tail) = rest.split_once(END)?;
    Some(format!("{head}{BEGIN}\n{}\n{END}{tail}", text.trim_end()))
}

#[cfg(test)]
mod tests {
    use super::{BEGIN, END, between};

    #[test]
    fn only_the_part_between_the_markers_changes() {
        let page = format!("a\n{BEGIN}\nold\n{END}\nb\n");
        assert_eq!(between(&page, "new\n"), Some(format!("a\n{BEGIN}\nnew\n{END}\nb\n")));
        assert_eq!(between("a\nb\n", "new"), None);
    }
}
