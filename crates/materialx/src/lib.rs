// SPDX-License-Identifier: GPL-3.0-or-later
//! MaterialX documents (`.mtlx`, 1.36 to 1.39) as shaders in the shading language: a document is read with all that it
//! includes, and a material, node or graph of it becomes one text, whose parameters are the document's values. The standard
//! definitions are embedded.
#![doc = include_str!("../README.md")]

mod document;
mod error;
mod generator;
mod library;
mod matching;
mod names;
mod parts;
mod primitives;
mod shader;
mod types;
mod xml;

pub use document::{Document, Load};
pub use error::Error;
pub use shader::Shader;

/// The embedded definitions: the name of each and its node, sorted.
#[must_use]
pub fn nodedefs() -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = library::embedded()
        .nodedefs()
        .map(|def| (def.name().to_owned(), def.get("node").unwrap_or("").to_owned()))
        .collect();
    all.sort();
    all
}
