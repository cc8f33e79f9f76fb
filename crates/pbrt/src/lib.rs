// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes of pbrt-v4: text files of statements, packed by gzip or not, and the files that they name.
//! Source: the file-format page of pbrt-v4; where that is silent, the behaviour of the program.
//! Space: pbrt's is left-handed; `view` says how it becomes right-handed. Light: `spectrum`.
//! Tests: `tests/` of this crate; docs/decisions/0036-pbrt.md has what differs.
//!
//! ```text
//! file -> text -> tokens -> parameters -> statements -> shapes, materials, textures, lights, view -> Scene
//! ```
#![forbid(unsafe_code)]

mod builder;
mod color_space;
mod directives;
mod film;
mod infinite;
mod lights;
mod location;
mod material;
mod media;
mod medium;
mod microfacets;
mod motion;
mod octahedral;
mod osl;
mod parameter;
mod patterns;
mod shapes;
mod sources;
mod spectrum;
mod state;
mod surface;
mod tables;
mod texture;
mod texture_parameters;
mod tokens;
mod transform;
mod view;
mod volume_medium;

use std::path::Path;

use gnurt_scene::io::reader::Access;
use gnurt_scene::io::{Error, Format, Loaded};

/// The format.
pub const FORMAT: Format = Format {
    name: "pbrt-v4",
    extensions: &["pbrt", "pbrt.gz"],
    notes: "surfaces, textures as shaders, lights, cameras, even media, uniform grids and those of files; curves and hair; no measured materials",
    read: Some(load),
    read_whole: false,
    says_up: true,
    write: None,
};

/// Reads a scene and all that it names.
fn load(path: &Path, access: &Access) -> Result<Loaded, Error> {
    directives::read(path, access)
}
