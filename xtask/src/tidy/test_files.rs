// SPDX-License-Identifier: GPL-3.0-or-later
//! Every test file is compiled: where `autotests = false`, cargo finds none by itself.

use super::files::SourceFile;

/// Complains of files in `tests` that neither `tests/main.rs` nor a `[[test]]` of the manifest names.
pub(super) fn check(files: &[SourceFile]) -> Vec<String> {
    let text = |path: &str| files.iter().find(|file| file.path == path).map_or("", |file| &file.text);
    let mut complaints = Vec::new();
    for manifest in files.iter().filter(|file| file.text.lines().any(|line| line == "autotests = false")) {
        let Some(package) = manifest.path.strip_suffix("Cargo.toml") else { continue };
        let folder = format!("{package}tests/");
        let main = text(&format!("{folder}main.rs"));
        let names = files.iter().filter_map(|file| {
            let name = file.path.strip_prefix(&folder)?.strip_suffix(".rs")?;
            (name != "main" && !name.contains('/')).then_some(name)
        });
        for name in names {
            let module = format!("mod {name};");
            let program = format!("name = \"{name}\"");
            if !main.lines().any(|line| line == module) && !manifest.text.lines().any(|line| line == program)
            {
                complaints.push(format!(
                    "{folder}{name}.rs: say `{module}` in {folder}main.rs; nothing compiles it"
                ));
            }
        }
    }
    complaints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forgotten_files_are_found() {
        let manifest = "autotests = false\n\n[[test]]\nname = \"alone\"\n";
        let mut files = ["alone", "listed", "common/mod", "forgotten"]
            .map(|name| SourceFile::new(&format!("crates/a/tests/{name}.rs"), ""))
            .into_iter()
            .chain([SourceFile::new("crates/a/Cargo.toml", manifest)])
            .chain([SourceFile::new("crates/a/tests/main.rs", "mod common;\nmod listed;\n")])
            .collect::<Vec<_>>();
        let found = check(&files);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("crates/a/tests/forgotten.rs: "), "{found:?}");
        files.retain(|file| !file.path.ends_with("Cargo.toml"));
        assert!(check(&files).is_empty(), "cargo finds them where it may");
    }
}
