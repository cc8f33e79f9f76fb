// SPDX-License-Identifier: GPL-3.0-or-later
//! Documents of MaterialX that stages refer to, as layers with a material for each of theirs.
//! Source: UsdMtlx's layout, `/MaterialX/Materials/NAME`. Tests: `tests/mtlx.rs`.

use std::fmt::Write;

/// Attributes of the materials of a referenced document.
pub(crate) const FILE: &str = "gnurt:mtlx:file";
pub(crate) const NODE: &str = "gnurt:mtlx:node";

/// The layer that a document is when a stage refers to it.
pub(crate) const LAYER: &str = "materialx.usda";

/// Whether an identifier is a document's.
pub(crate) fn is_document(path: &str) -> bool {
    path.to_ascii_lowercase().ends_with(".mtlx")
}

/// The text of a document's layer: its materials, each with its name and file.
pub(crate) fn layer(file: &str, read: &mut gnurt_materialx::Load<'_>) -> Result<String, String> {
    let document = gnurt_materialx::Document::open(std::path::Path::new(file), read);
    let document = document.map_err(|error| error.to_string())?;
    let mut text = String::from("#usda 1.0\n(\n    defaultPrim = \"MaterialX\"\n)\n");
    text.push_str("def Scope \"MaterialX\"\n{\n    def Scope \"Materials\"\n    {\n");
    let quoted = |text: &str| text.replace('\\', "\\\\").replace('"', "\\\"");
    for name in document.materials() {
        let prim: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let _ = write!(
            text,
            "        def Material \"{prim}\"\n        {{\n            custom string {FILE} = \"{}\"\n            \
             custom string {NODE} = \"{}\"\n        }}\n",
            quoted(file),
            quoted(&name)
        );
    }
    text.push_str("    }\n}\n");
    Ok(text)
}
