// SPDX-License-Identifier: GPL-3.0-or-later
//! Every test is compiled: where `autotests = false`, cargo finds no file by itself; where a library says `test = false`, it
//! takes none from the library's sources.

use super::files::SourceFile;

/// Complains of tests that nothing compiles.
pub(super) fn check(files: &[SourceFile]) -> Vec<String> {
    let mut complaints = forgotten_files(files);
    complaints.extend(unit_tests(files));
    complaints
}

/// Tests in the sources of libraries whose manifests say that there are none.
fn unit_tests(files: &[SourceFile]) -> impl Iterator<Item = String> {
    let manifests = files.iter().filter(|file| is_without_unit_tests(&file.text));
    manifests.filter_map(|file| file.path.strip_suffix("Cargo.toml")).flat_map(|package| {
        let of_library = files.iter().filter(move |file| {
            let source = file.path.strip_prefix(package).and_then(|path| path.strip_prefix("src/"));
            source.is_some() && file.code.contains("#[test]")
        });
        of_library.map(move |file| {
            format!(
                "{}: it has tests; {package}Cargo.toml must not say `test = false` of the library",
                file.path
            )
        })
    })
}

/// Whether a manifest says `test = false` of its library.
fn is_without_unit_tests(manifest: &str) -> bool {
    let of_library = manifest.lines().skip_while(|line| *line != "[lib]").skip(1);
    of_library.take_while(|line| !line.starts_with('[')).any(|line| line == "test = false")
}

/// Files in `tests` that neither `tests/main.rs` nor a `[[test]]` of the manifest names.
fn forgotten_files(files: &[SourceFile]) -> Vec<String> {
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
    #[test]
    fn unit_tests_that_are_not_run_are_found() {
        let files = |manifest: &str| {
            [
                SourceFile::new("crates/a/Cargo.toml", manifest),
                SourceFile::new(
                    "crates/a/src/deep/part.rs",
                    "#[cfg(test)]\nmod tests {\n    #[test]\n    fn one() {}\n}\n",
                ),
                SourceFile::new("crates/a/tests/main.rs", "#[test]\nfn two() {}\n"),
            ]
        };
        let found = check(&files("[package]\n\n[lib]\ntest = false\n"));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("crates/a/src/deep/part.rs: "), "{found:?}");
        assert_eq!(
            check(&files("[lib]\nname = \"b\"\ntest = false\n\n[lints]\n")).len(),
            1,
            "after other keys"
        );
        assert!(check(&files("[package]\n")).is_empty(), "cargo runs them");
        assert!(
            check(&files("[lib]\n\n[[bin]]\ntest = false\n")).is_empty(),
            "the program has none, the library may"
        );
    }
}
