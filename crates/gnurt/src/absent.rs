// SPDX-License-Identifier: GPL-3.0-or-later
//! Formats that were not compiled into this build: their names are known, so that a message can say how to get them.
//! Invariant: the rows are those of the formats' own crates. Tests: `tests/formats.rs`, which reads the rows of both.

use std::path::Path;

use crate::scene::io::{Error, Format};

#[cfg(not(feature = "gltf"))]
pub(crate) const GLTF_TEXT: Format = Format {
    name: "glTF 2.0",
    extensions: &["gltf"],
    notes: "written without the environment",
    ..GLTF_BINARY
};

#[cfg(not(feature = "gltf"))]
pub(crate) const GLTF_BINARY: Format = Format {
    name: "binary glTF 2.0",
    extensions: &["glb"],
    notes: "one file, with its textures; written without the environment",
    read: Some(|path, _| Err(missing(path).unwrap_or_else(|| absent(path, "glTF", "gltf")))),
    read_whole: true,
    says_up: true,
    write: Some(crate::scene::io::SceneWriter {
        save: |_, path, _| Err(absent(path, "glTF", "gltf")),
        companions: |_, _| Vec::new(),
        has_materials: true,
        has_animations: true,
        has_strands: false,
        is_whole: false,
    }),
};

#[cfg(not(feature = "pbrt"))]
pub(crate) const PBRT: Format = Format {
    name: "pbrt-v4",
    extensions: &["pbrt", "pbrt.gz"],
    notes: "surfaces, textures as shaders, lights, cameras, even media, uniform grids and those of files; curves and hair; no measured materials",
    read: Some(|path, _| Err(missing(path).unwrap_or_else(|| absent(path, "pbrt-v4", "pbrt")))),
    read_whole: false,
    says_up: true,
    write: None,
};

#[cfg(not(feature = "usd"))]
pub(crate) const USD: Format = Format {
    name: "USD",
    extensions: &["usda", "usdc", "usd", "usdz"],
    notes: "read at one moment: [USD](usd.md)",
    read: Some(|path, _| Err(missing(path).unwrap_or_else(|| absent(path, "USD", "usd")))),
    read_whole: false,
    says_up: true,
    write: Some(crate::scene::io::SceneWriter {
        save: |_, path, _| Err(absent(path, "USD", "usd")),
        companions: |_, _| Vec::new(),
        has_materials: true,
        has_animations: false,
        has_strands: true,
        is_whole: false,
    }),
};

/// The error of a file of such a format.
fn absent(path: &Path, name: &str, feature: &str) -> Error {
    let remedy = format!(
        "`cargo run --release --features {feature} -- ...` compiles it; `cargo build --release` and `cargo xtask install` have all formats"
    );
    Error::data(path, None, format!("this program was compiled without {name}"), remedy)
}

/// That there is no such file helps more.
fn missing(path: &Path) -> Option<Error> {
    (!path.exists()).then(|| Error::io(path, "no such file", "check the path"))
}
