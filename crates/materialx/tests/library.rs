// SPDX-License-Identifier: GPL-3.0-or-later
//! The embedded definitions, each as a shader that compiles.

use std::path::Path;

use gnurt_materialx::{Document, nodedefs};

/// The text of a document's only thing.
pub(crate) fn generated(xml: &str, name: Option<&str>) -> Result<gnurt_materialx::Shader, String> {
    let text = format!("<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">{xml}</materialx>");
    let mut none = |path: &Path| Err(format!("{}: no file", path.display()));
    let document = Document::of_text(Path::new("t.mtlx"), &text, &mut none).map_err(|error| error.to_string())?;
    document.shader(name).map_err(|error| error.to_string())
}

/// Compiles a text.
pub(crate) fn compiled(text: &str) -> Result<(), String> {
    let none = |_: &Path| None;
    let made = gnurt_sl::compile("t.osl", text, &gnurt_sl::Options::default(), &none);
    match made.shader {
        Some(_) => Ok(()),
        None => Err(made.diagnostics.list.iter().map(|d| format!("{}: {}; ", d.loc.line, d.message)).collect()),
    }
}

#[test]
fn every_definition_is_a_shader_that_compiles() {
    let mut faults = Vec::new();
    let all = nodedefs();
    for (def, node) in &all {
        let xml = format!("<{node} name=\"n\" nodedef=\"{def}\"/>");
        match generated(&xml, Some("n")) {
            Ok(shader) => {
                if let Err(why) = compiled(&shader.text) {
                    faults.push(format!("{def}: {why}\n{}", shader.text));
                }
            }
            Err(why) => faults.push(format!("{def}: {why}")),
        }
    }
    assert_eq!(all.len(), 806);
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults[..faults.len().min(8)].join("\n"));
}
