// SPDX-License-Identifier: GPL-3.0-or-later
//! File heads: the licence's line first, then, in Rust, the file's subject.
//!
//! CONTRIBUTING.md (Files) lists the parts of a head: `Source:` for work of others, `Space:`, `Invariant:`, `Tests:`.

use super::files::SourceFile;

const LICENCE: &str = "SPDX-License-Identifier: GPL-3.0-or-later";

/// Labels that heads had once: original work needs no source, and a test is no proof.
const GONE: [&str; 2] = ["Source: original", "Proof:"];

/// The first line, or the second after `#!`, names the licence.
pub(super) fn licence(file: &SourceFile) -> Vec<(usize, String)> {
    let first = file.text.lines().find(|line| !line.starts_with("#!/")).unwrap_or_default();
    let named = first.contains(LICENCE) && file.text.lines().take(2).any(|line| line == first);
    if named { vec![] } else { vec![(1, format!("the first line must be '{LICENCE}' as a comment"))] }
}

/// Rust files begin with a head, which has none of the labels that are gone.
pub(super) fn contract(file: &SourceFile) -> Vec<(usize, String)> {
    if !file.is_rust() {
        return vec![];
    }
    if file.text.lines().nth(1).is_none_or(|line| !line.starts_with("//!")) {
        return vec![(2, "the second line must begin the file's head with '//!'".into())];
    }
    let head = file.text.lines().enumerate().filter(|(_, line)| line.starts_with("//!"));
    let gone = head.flat_map(|(number, line)| {
        GONE.iter()
            .filter(|label| line.contains(**label))
            .map(move |label| (number + 1, format!("'{label}' is gone: see CONTRIBUTING.md, Files")))
    });
    gone.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "// SPDX-License-Identifier: GPL-3.0-or-later\n//! A thing. Tests: `tests`.\n";

    #[test]
    fn the_licence_comes_first() {
        let ok = |path: &str, text: &str| licence(&SourceFile::new(path, text)).is_empty();
        assert!(ok("a.rs", HEAD), "a Rust file");
        assert!(ok(".ci/run", "#!/bin/bash\n# SPDX-License-Identifier: GPL-3.0-or-later\n"), "a script");
        assert!(ok("a.h", "/* SPDX-License-Identifier: GPL-3.0-or-later */\n"), "a header");
        assert!(!ok("a.rs", "//! A thing.\n// SPDX-License-Identifier: GPL-3.0-or-later\n"), "too late");
        assert!(!ok("a.toml", "# SPDX-License-Identifier: MIT\n"), "another licence");
        assert!(!ok("a.c", ""), "an empty file");
    }

    #[test]
    fn heads_are_there_and_have_no_old_labels() {
        let ok = |text: &str| contract(&SourceFile::new("crates/accel/src/a.rs", text)).is_empty();
        assert!(ok(HEAD), "a whole head");
        assert!(!ok("// SPDX\nfn a() {}\n"), "no head");
        for label in GONE {
            assert!(!ok(&HEAD.replace("Tests:", label)), "{label}");
        }
    }
}
