// SPDX-License-Identifier: GPL-3.0-or-later
//! Third-party packages in our releases, after `cargo metadata`: direct and indirect dependencies of our
//! programs and libraries. Build dependencies (build scripts, dependencies of procedural macros) are in none
//! of our files.
//! Tests: `tests`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde_json::Value;

use crate::command;
use crate::failure::Failure;

/// A package by others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) version: String,
    /// As an SPDX expression.
    pub(super) license: String,
    pub(super) authors: Vec<String>,
    /// Its address, or empty.
    pub(super) repository: String,
    /// The folder of its source.
    pub(super) folder: PathBuf,
}

/// Our packages that are given away as programs and libraries.
const GIVEN: [&str; 7] =
    ["gnurt-cli", "openrt", "rtut", "gnurt-rays", "gnurt-embree", "gnurt-anari", "gnurt-python"];

/// The parts of a build for a machine, by name and version.
pub(super) fn of_packages(target: &str) -> Result<Vec<Part>, Failure> {
    let mut cargo = command::cargo();
    cargo.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", target]);
    let output = cargo.output().map_err(|error| format!("cargo metadata cannot be run: {error}"))?;
    if !output.status.success() {
        return Err(format!("cargo metadata failed: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let metadata: Value = serde_json::from_slice(&output.stdout)
        .map_err(|error| format!("cargo metadata: invalid JSON: {error}"))?;
    let mut parts = of_metadata(&metadata)?;
    parts.push(definitions());
    parts.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(parts)
}

/// MaterialX's definitions, which a crate of ours embeds.
fn definitions() -> Part {
    Part {
        name: "materialx-definitions".into(),
        version: "1.39.5".into(),
        license: "Apache-2.0".into(),
        authors: vec!["Contributors to the MaterialX Project".into()],
        repository: "https://github.com/AcademySoftwareFoundation/MaterialX".into(),
        folder: command::root().join("crates/materialx/library"),
    }
}

fn of_metadata(metadata: &Value) -> Result<Vec<Part>, Failure> {
    let list = |value: &'_ Value| value.as_array().cloned().unwrap_or_default();
    let packages = list(&metadata["packages"]);
    let nodes = list(&metadata["resolve"]["nodes"]);
    let package = |id: &Value| packages.iter().find(|package| package["id"] == *id);
    let mut pending: Vec<Value> = Vec::new();
    for name in GIVEN {
        // The same name may be another's package, too.
        let ours = packages.iter().find(|package| package["name"] == name && package["source"].is_null());
        pending.push(ours.ok_or_else(|| format!("cargo metadata lacks '{name}'"))?["id"].clone());
    }
    let mut met = BTreeSet::new();
    let mut parts = Vec::new();
    while let Some(id) = pending.pop() {
        if !met.insert(id.as_str().unwrap_or_default().to_owned()) {
            continue;
        }
        let found = package(&id).ok_or_else(|| format!("cargo metadata lacks the package {id}"))?;
        if !found["source"].is_null() {
            parts.push(part(found)?);
        }
        // Dependencies of a procedural macro run in the compiler only.
        let is_macro = |target: &Value| list(&target["kind"]).iter().any(|kind| kind == "proc-macro");
        if list(&found["targets"]).iter().any(is_macro) {
            continue;
        }
        let node = nodes.iter().find(|node| node["id"] == id);
        for dependency in node.map(|node| list(&node["deps"])).unwrap_or_default() {
            if list(&dependency["dep_kinds"]).iter().any(|kind| kind["kind"].is_null()) {
                pending.push(dependency["pkg"].clone());
            }
        }
    }
    parts.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(parts)
}

fn part(package: &Value) -> Result<Part, Failure> {
    let text = |key: &str| package[key].as_str().unwrap_or_default().to_owned();
    let (name, license) = (text("name"), text("license"));
    let manifest = PathBuf::from(text("manifest_path"));
    let folder = manifest.parent().map(PathBuf::from).unwrap_or_default();
    if license.is_empty() {
        return Err(format!("{name}: no SPDX expression in its manifest"));
    }
    let authors = package["authors"].as_array().cloned().unwrap_or_default();
    let authors = authors.iter().filter_map(|author| author.as_str().map(String::from)).collect();
    Ok(Part { name, version: text("version"), license, authors, repository: text("repository"), folder })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn parts_are_what_is_linked() {
        let ours = |name: &str| json!({"id": name, "name": name, "version": "1", "source": null, "targets": [{"kind": ["lib"]}]});
        let other = |name: &str, kind: &str| {
            json!({"id": name, "name": name, "version": "2", "source": "registry", "license": "MIT",
                "manifest_path": format!("/r/{name}/Cargo.toml"), "targets": [{"kind": [kind]}]})
        };
        let dep = |name: &str, kind: Value| json!({"pkg": name, "dep_kinds": [{"kind": kind}]});
        let mut packages: Vec<Value> = GIVEN.iter().map(|name| ours(name)).collect();
        packages.extend([
            other("linked", "lib"),
            other("below", "lib"),
            other("derive", "proc-macro"),
            other("syn", "lib"),
            other("cc", "lib"),
            other("tests", "lib"),
        ]);
        let nodes = json!([
            {"id": "openrt", "deps": [dep("linked", Value::Null), dep("cc", json!("build")), dep("tests", json!("dev"))]},
            {"id": "linked", "deps": [dep("below", Value::Null), dep("derive", Value::Null)]},
            {"id": "derive", "deps": [dep("syn", Value::Null)]},
            {"id": "below", "deps": [dep("linked", Value::Null)]},
        ]);
        let parts =
            of_metadata(&json!({"packages": packages, "resolve": {"nodes": nodes}})).expect("all are there");
        let names: Vec<&str> = parts.iter().map(|part| &part.name[..]).collect();
        assert_eq!(names, ["below", "derive", "linked"], "no build scripts, no tests, no compiler's parts");
        let lacking = of_metadata(&json!({"packages": [], "resolve": {"nodes": []}}));
        assert!(lacking.is_err_and(|why| why.contains("gnurt-cli")), "what is missing is named");
    }
}
