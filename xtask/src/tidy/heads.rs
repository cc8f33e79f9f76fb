// SPDX-License-Identifier: GPL-3.0-or-later
//! File heads: the licence's line first, then, in Rust, what the file is; algorithms say where they come from.
//! Source: original.

use super::files::SourceFile;

const LICENCE: &str = "SPDX-License-Identifier: GPL-3.0-or-later";

/// Rooms whose files say `Source:` in their head.
const CITING: [&str; 9] = [
    "crates/accel/src/",
    "crates/accel-core/src/",
    "crates/accel-bvh/src/",
    "crates/accel-kd/src/",
    "crates/shading/src/",
    "crates/render/src/",
    "crates/scene/src/",
    "crates/image/src/",
    "crates/sl-lib/src/",
];

/// The first line, or the second after `#!`, names the licence.
pub(super) fn licence(file: &SourceFile) -> Vec<(usize, String)> {
    let first = file.text.lines().find(|line| !line.starts_with("#!/")).unwrap_or_default();
    let named = first.contains(LICENCE) && file.text.lines().take(2).any(|line| line == first);
    if named { vec![] } else { vec![(1, format!("the first line must be '{LICENCE}' as a comment"))] }
}

/// Rust files say in `//!` what they are, and in citing rooms where that comes from.
pub(super) fn contract(file: &SourceFile) -> Vec<(usize, String)> {
    if !file.is_rust() {
        return vec![];
    }
    let head: Vec<&str> = file.text.lines().filter(|line| line.starts_with("//!")).collect();
    if file.text.lines().nth(1).is_none_or(|line| !line.starts_with("//!")) {
        return vec![(2, "the second line must begin the file's head with '//!'".into())];
    }
    // A file that only lists others has no algorithm to cite.
    let is_list = file.path.ends_with("/lib.rs") || file.path.ends_with("/mod.rs");
    let cites = head.iter().any(|line| line.contains("Source:"));
    if CITING.iter().any(|room| file.path.starts_with(room)) && !is_list && !cites {
        return vec![(2, "the head must say 'Source:' with a key of docs/papers.bib, or 'original'".into())];
    }
    vec![]
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "// SPDX-License-Identifier: GPL-3.0-or-later\n//! A thing.\n//! Source: original.\n";

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
    fn heads_say_what_and_where_from() {
        let ok = |path: &str, text: &str| contract(&SourceFile::new(path, text)).is_empty();
        let silent = HEAD.replace("//! Source: original.\n", "");
        assert!(ok("crates/accel/src/a.rs", HEAD), "a whole head");
        assert!(!ok("crates/accel/src/a.rs", &silent), "no source in a citing room");
        assert!(ok("crates/accel/src/lib.rs", &silent), "a list of files");
        assert!(ok("crates/cli/src/a.rs", &silent), "no source in another room");
        assert!(!ok("crates/cli/src/a.rs", "// SPDX\nfn a() {}\n"), "no head");
    }
}
