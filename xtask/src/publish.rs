// SPDX-License-Identifier: GPL-3.0-or-later
//! `cargo xtask crates`: the packages for crates.io.
//! Tests: `tests` here.

use serde_json::Value;

use crate::command;
use crate::failure::Failure;
use crate::workspace::Workspace;

/// Packs every crate, in the order of their dependencies.
///
/// Without an option nothing is compiled and nothing is sent. `--verify` also compiles each crate from its package,
/// `--publish` sends them.
pub(crate) fn crates(arguments: &[String]) -> Result<(), Failure> {
    let options: &[&str] = match arguments {
        [] => &["--dry-run", "--no-verify", "--allow-dirty"],
        [option] if option == "--verify" => &["--dry-run", "--allow-dirty"],
        [option] if option == "--publish" => &[],
        [other, ..] => return Err(format!("crates: unknown '{other}'; [--verify | --publish]")),
    };
    let mut publish = command::cargo();
    publish.args(["publish", "--workspace"]).args(options);
    for name in kept(&Workspace::metadata()?) {
        publish.args(["--exclude", &name]);
    }
    command::run(&mut publish)
}

/// Names of the packages that are not published.
fn kept(metadata: &Value) -> Vec<String> {
    let packages = metadata["packages"].as_array().into_iter().flatten();
    let is_kept = |package: &&Value| package["publish"].as_array().is_some_and(Vec::is_empty);
    packages.filter(is_kept).filter_map(|package| Some(package["name"].as_str()?.to_owned())).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn packages_that_stay_are_found() {
        let metadata = json!({ "packages": [
            { "name": "a", "publish": null }, { "name": "b", "publish": [] }, { "name": "c", "publish": ["x"] },
        ]});
        assert_eq!(kept(&metadata), ["b"]);
    }
}
