// SPDX-License-Identifier: GPL-3.0-or-later
//! Metadata that crates.io requires of a crate: keywords, a page, the licence's text. The limits are those of crates.io.

use std::path::Path;

use serde_json::Value;

/// Complains about missing metadata of published crates, from `cargo metadata`.
pub(super) fn check(metadata: &Value) -> Vec<String> {
    let empty = Vec::new();
    let packages = metadata["packages"].as_array().unwrap_or(&empty);
    let unpublished: Vec<&str> =
        packages.iter().filter(|package| !is_published(package)).filter_map(|p| p["name"].as_str()).collect();
    let published = packages.iter().filter(|package| is_published(package));
    published
        .flat_map(|package| {
            let name = package["name"].as_str().unwrap_or_default();
            lacks(package, &unpublished).into_iter().map(move |what| format!("{name}: {what}"))
        })
        .collect()
}

fn is_published(package: &Value) -> bool {
    package["publish"].as_array().is_none_or(|registries| !registries.is_empty())
}

fn lacks(package: &Value, unpublished: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for field in ["description", "license", "readme"] {
        if package[field].as_str().is_none_or(str::is_empty) {
            found.push(format!("the manifest has no '{field}'"));
        }
    }
    for field in ["keywords", "categories"] {
        let count = package[field].as_array().map_or(0, Vec::len);
        if !(1..=5).contains(&count) {
            found.push(format!("the manifest has {count} {field}; crates.io takes 1 to 5"));
        }
    }
    let folder = Path::new(package["manifest_path"].as_str().unwrap_or_default()).parent();
    for file in ["COPYING", "README.md"] {
        if folder.is_none_or(|folder| !folder.join(file).exists()) {
            found.push(format!("{file} is not beside the manifest"));
        }
    }
    // A dependency on an unpublished version cannot be satisfied.
    let empty = Vec::new();
    let dependencies = package["dependencies"].as_array().unwrap_or(&empty);
    let versioned = dependencies.iter().filter(|d| d["path"].is_string() && d["req"] != "*");
    let names = versioned.filter_map(|d| d["name"].as_str()).filter(|name| unpublished.contains(name));
    found
        .extend(names.map(|name| format!("{name} is not published, so its dependency must name no version")));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command;
    use serde_json::json;

    #[test]
    fn poor_manifests_are_found() {
        let folder = command::root().join("crates/accel/Cargo.toml");
        let good = json!({
            "name": "a", "publish": null, "description": "A", "license": "X", "readme": "README.md", "keywords": ["a"],
            "categories": ["graphics"], "manifest_path": folder,
            "dependencies": [{ "name": "kit", "path": "/kit", "req": "*" }],
        });
        let kit = json!({ "name": "kit", "publish": [] });
        let complaints = |change: &dyn Fn(&mut Value)| {
            let mut package = good.clone();
            change(&mut package);
            check(&json!({ "packages": [package, kit] })).len()
        };
        assert_eq!(complaints(&|_| {}), 0, "nothing is missing");
        assert_eq!(complaints(&|p| p["description"] = json!("")), 1, "no description");
        assert_eq!(complaints(&|p| p["keywords"] = json!([])), 1, "no keywords");
        assert_eq!(complaints(&|p| p["categories"] = json!(["a", "b", "c", "d", "e", "f"])), 1, "too many");
        assert_eq!(
            complaints(&|p| p["manifest_path"] = json!("/nowhere/Cargo.toml")),
            2,
            "no files beside it"
        );
        assert_eq!(
            complaints(&|p| p["dependencies"][0]["req"] = json!("^0.1")),
            1,
            "a version of what is not there"
        );
        assert_eq!(complaints(&|p| p["publish"] = json!([])), 0, "nobody looks at what is not published");
    }
}
