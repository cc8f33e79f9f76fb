// SPDX-License-Identifier: GPL-3.0-or-later
//! The licence texts of parts, as their packages have them. Of a part with a choice of MIT only that text is
//! taken, with files of notices; of all others every text in the package. A part without any file gets MIT's
//! text with its authors' names.
//! Invariant: every part has a text, or it is an error. Tests: `tests`.

use std::path::Path;

use super::parts::Part;
use crate::command;
use crate::failure::Failure;
use crate::install::files::files_in;

/// How names of files with such texts begin.
const BEGINNINGS: [&str; 6] = ["license", "licence", "copying", "copyright", "notice", "unlicense"];

/// Each text once, with the parts that have it.
pub(super) fn of(parts: &[Part]) -> Result<Vec<(String, Vec<String>)>, Failure> {
    let mut all: Vec<(String, Vec<String>)> =
        vec![(mit("The Rust Project Developers"), vec!["Rust's standard library".to_owned()])];
    for part in parts {
        let holder = format!("{} {}", part.name, part.version);
        for text in of_part(part)? {
            match all.iter_mut().find(|(other, _)| tokens(other) == tokens(&text)) {
                Some((_, holders)) if holders.contains(&holder) => {}
                Some((_, holders)) => holders.push(holder.clone()),
                None => all.push((text, vec![holder.clone()])),
            }
        }
    }
    Ok(all)
}

/// Texts are the same if their words are.
fn tokens(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

fn of_part(part: &Part) -> Result<Vec<String>, Failure> {
    let mut files: Vec<(String, String)> = Vec::new();
    for path in files_in(&part.folder)?.iter().filter(|path| path.is_file()) {
        let name = name_of(path);
        if BEGINNINGS.iter().any(|beginning| name.starts_with(beginning)) {
            let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
            files.push((
                name,
                String::from_utf8_lossy(&bytes).replace('\r', "").trim_matches('\n').to_owned(),
            ));
        }
    }
    files.retain(|(_, text)| !text.trim().is_empty());
    let may_be_mit =
        part.license.split([' ', '/', '(', ')']).any(|token| token == "MIT") && !part.license.contains("AND");
    if files.is_empty() {
        let holders = if part.authors.is_empty() {
            format!("the authors of {}", part.name)
        } else {
            part.authors.join(", ")
        };
        return if may_be_mit {
            Ok(vec![mit(&holders)])
        } else if part.license == "Apache-2.0" {
            // The text names no holders.
            let path = command::root().join("LICENSES/Apache-2.0.txt");
            let text =
                std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            Ok(vec![text.trim_matches('\n').to_owned()])
        } else {
            Err(format!("{} {}: no licence file in {}", part.name, part.version, part.folder.display()))
        };
    }
    let is_notice = |name: &str| name.starts_with("notice") || name.starts_with("copyright");
    if may_be_mit && files.iter().any(|(name, _)| name.contains("mit")) {
        files.retain(|(name, _)| name.contains("mit") || is_notice(name));
    }
    Ok(files.into_iter().map(|(_, text)| text).collect())
}

fn name_of(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn mit(holders: &str) -> String {
    format!("Copyright (c) {holders}\n\n{MIT}")
}

const MIT: &str = "\
Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the \"Software\"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all
copies or substantial portions of the Software.

THE SOFTWARE IS PROVIDED \"AS IS\", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
SOFTWARE.";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::install::files::write;

    #[test]
    fn every_part_has_a_text() {
        let root = std::env::temp_dir().join(format!("gnurt-notices-test-{}", std::process::id()));
        for (path, text) in [
            ("two/LICENSE-MIT", "Copyright A\r\n"),
            ("two/LICENSE-APACHE", "Apache"),
            ("two/NOTICE", "Made by A"),
            ("same/license-mit.txt", "Copyright  A"),
            ("bsd/LICENSE", "Copyright B"),
            ("bsd/LICENSE.patents", "None"),
            ("both/LICENSE-MIT", "Copyright C"),
            ("both/LICENSE-APACHE", "Apache"),
            ("empty/LICENSE", "\n"),
        ] {
            write(&root.join(path), text).expect("the temporary folder can be written");
        }
        let part = |name: &str, license: &str| Part {
            name: name.to_owned(),
            version: "1".to_owned(),
            license: license.to_owned(),
            authors: vec!["D".to_owned()],
            repository: String::new(),
            folder: root.join(name),
        };
        let given = [
            part("two", "MIT OR Apache-2.0"),
            part("same", "Apache-2.0/MIT"),
            part("bsd", "BSD-3-Clause"),
            part("both", "MIT AND Apache-2.0"),
            part("empty", "MIT"),
        ];
        let found = of(&given).expect("all have one");
        let holders = |start: &str| {
            let of =
                found.iter().find(|(text, _)| text.starts_with(start)).map(|(_, holders)| holders.join(", "));
            of.unwrap_or_default()
        };
        for (start, wanted) in [
            ("Copyright A", "two 1, same 1"),
            ("Made by A", "two 1"),
            ("Copyright B", "bsd 1"),
            ("None", "bsd 1"),
            ("Copyright C", "both 1"),
            ("Apache", "both 1"),
            ("Copyright (c) D", "empty 1"),
            ("Copyright (c) The Rust Project", "Rust's standard library"),
        ] {
            assert_eq!(holders(start), wanted, "'{start}'");
        }
        let none = of(&[part("empty", "BSD-2-Clause")]).expect_err("a licence without a text");
        assert!(none.contains("empty 1"), "{none}");
        std::fs::remove_dir_all(&root).expect("the test's folder can be removed");
    }
}
