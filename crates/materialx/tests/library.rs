// SPDX-License-Identifier: GPL-3.0-or-later
//! The embedded definitions, each as a shader that compiles.

use gnurt_materialx::nodedefs;

use crate::made::{compiled, generated};

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
