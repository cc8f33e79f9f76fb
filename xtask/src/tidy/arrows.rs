// SPDX-License-Identifier: GPL-3.0-or-later
//! The arrows: which of our crates may use which. The table equals the one in ARCHITECTURE.md.

use crate::workspace::Package;

/// A crate's short name and those that it may use.
const ARROWS: [(&str, &[&str]); 34] = [
    ("simd", &[]),
    ("accel-core", &["simd"]),
    ("accel-bvh", &["simd", "accel-core"]),
    ("accel-kd", &["simd", "accel-core"]),
    ("accel", &["simd", "accel-core", "accel-bvh", "accel-kd"]),
    ("image", &[]),
    ("denoise", &["simd", "image"]),
    ("subdivision", &[]),
    ("scene", &["image", "subdivision"]),
    ("gltf", &["image", "scene"]),
    ("usd", &["image", "scene", "materialx"]),
    ("shading", &["simd", "image", "accel"]),
    ("materialx", &[]),
    ("sl-lib", &[]),
    ("ocio", &["image"]),
    ("pbrt", &["image", "scene", "sl-lib"]),
    ("render", &["simd", "accel", "image", "scene", "shading"]),
    ("sl-shading", &["simd", "accel", "image", "shading", "sl", "sl-lib", "jit", "materialx"]),
    (
        "gnurt",
        &[
            "simd",
            "accel",
            "image",
            "denoise",
            "scene",
            "gltf",
            "usd",
            "shading",
            "render",
            "sl-lib",
            "sl-shading",
            "ocio",
            "pbrt",
        ],
    ),
    ("bench", &["gnurt"]),
    ("view", &["gnurt"]),
    ("plugins", &["gnurt"]),
    ("sl", &["sl-lib"]),
    ("sl-tools", &["sl", "sl-lib"]),
    ("jit", &["simd", "sl-lib", "sl"]),
    ("osl", &["simd", "sl-lib", "sl", "jit"]),
    ("cli", &["gnurt", "bench", "view", "plugins", "sl-tools", "jit"]),
    ("anari", &["gnurt"]),
    ("openrt", &["gnurt", "plugins"]),
    ("rtut", &[]),
    ("python", &["accel", "gnurt", "cli"]),
    ("rays", &["accel"]),
    // Tests of programs that use both.
    ("embree", &["accel", "rays", "subdivision"]),
    ("examples", &["accel", "gnurt"]),
];

/// Packages outside of the table: tests and chores, on which no crate may depend.
const FREE: [&str; 2] = ["testkit", "xtask"];

fn short(name: &str) -> &str {
    name.strip_prefix("gnurt-").unwrap_or(name)
}

/// Complains about every dependency that is not in the table.
pub(super) fn check(packages: &[Package]) -> Vec<String> {
    let mut complaints = Vec::new();
    for package in packages.iter().filter(|package| !FREE.contains(&short(&package.name))) {
        let Some((_, allowed)) = ARROWS.iter().find(|(name, _)| *name == short(&package.name)) else {
            complaints.push(format!("{} is in no row of the table of arrows", package.name));
            continue;
        };
        let refused = package.uses.iter().filter(|used| !allowed.contains(&short(used)));
        complaints.extend(
            refused.map(|used| {
                format!("{} uses {used}, but may only use: {}", package.name, or_nothing(allowed))
            }),
        );
    }
    complaints
}

/// Complains where the table printed in ARCHITECTURE.md differs from ours.
pub(super) fn check_printed(text: &str) -> Vec<String> {
    let cells = |line: &str| {
        line.trim().trim_matches('|').split('|').map(|c| c.trim().to_string()).collect::<Vec<_>>()
    };
    let rows = text.lines().skip_while(|line| !line.starts_with("| crate | may use |"));
    let printed: Vec<(String, Vec<String>)> = rows
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(cells)
        .filter(|row| row.len() >= 2)
        .map(|row| (row[0].clone(), names(&row[1])))
        .collect();
    if printed.is_empty() {
        return vec!["ARCHITECTURE.md: the table '| crate | may use |' is missing".into()];
    }
    let mut complaints = Vec::new();
    for (name, allowed) in ARROWS {
        let row = printed.iter().find(|(printed, _)| printed == name).map(|(_, uses)| uses);
        let same = row.is_some_and(|uses| {
            uses.len() == allowed.len()
                && allowed.iter().all(|used| uses.iter().any(|printed| printed == used))
        });
        if !same {
            let found = row.map_or_else(|| "no row".into(), |uses| uses.join(", "));
            complaints.push(format!("ARCHITECTURE.md: {name} has {found}, tidy has {}", or_nothing(allowed)));
        }
    }
    let unknown = printed.iter().filter(|(name, _)| ARROWS.iter().all(|(known, _)| known != name));
    complaints
        .extend(unknown.map(|(name, _)| format!("ARCHITECTURE.md: {name} is not in tidy's table of arrows")));
    complaints
}

fn names(cell: &str) -> Vec<String> {
    cell.split(',').map(str::trim).filter(|name| !name.is_empty() && *name != "-").map(String::from).collect()
}

fn or_nothing(names: &[&str]) -> String {
    if names.is_empty() { "nothing of ours".into() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, uses: &[&str]) -> Package {
        Package { name: name.into(), uses: uses.iter().map(ToString::to_string).collect() }
    }

    fn printed() -> String {
        let row = |(name, uses): (&str, &[&str])| {
            format!("| {name} | {} | x |\n", if uses.is_empty() { "-".into() } else { uses.join(", ") })
        };
        format!("# A\n| crate | may use | must not know |\n|---|---|---|\n{}\nend", ARROWS.map(row).concat())
    }

    #[test]
    fn arrows_of_the_table_pass() {
        let good = [
            package("gnurt-accel", &["gnurt-accel-bvh", "gnurt-simd"]),
            package("openrt", &["gnurt"]),
            package("xtask", &["gnurt"]),
        ];
        assert_eq!(check(&good), Vec::<String>::new(), "these arrows are allowed");
    }

    #[test]
    fn other_arrows_are_found() {
        for (name, used) in [
            ("gnurt-accel", "gnurt-shading"),
            ("gnurt-accel-kd", "gnurt-accel-bvh"),
            ("gnurt-cli", "gnurt-scene"),
            ("gnurt-simd", "gnurt-image"),
            ("gnurt-render", "gnurt-testkit"),
        ] {
            let complaints = check(&[package(name, &[used])]);
            assert!(
                complaints.len() == 1 && complaints[0].contains(used),
                "{name} -> {used}: {complaints:?}"
            );
        }
        assert_eq!(check(&[package("gnurt-new", &[])]).len(), 1, "a crate without a row is found");
    }

    #[test]
    fn the_printed_table_must_be_equal() {
        assert_eq!(check_printed(&printed()), Vec::<String>::new(), "the same table");
        for (from, to) in [
            ("| scene | image, subdivision |", "| scene | image, accel |"),
            ("| plugins | gnurt | x |\n", ""),
            ("| cli |", "| jit |"),
            ("| crate |", "| x |"),
        ] {
            assert!(!check_printed(&printed().replace(from, to)).is_empty(), "'{from}' -> '{to}' is found");
        }
    }
}
