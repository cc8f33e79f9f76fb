// SPDX-License-Identifier: GPL-3.0-or-later
//! The renderer for FreeCAD's Render workbench, without FreeCAD, renders by the program.

use std::process::Command;

#[test]
fn the_plugin_for_freecad_renders() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("SKIPPED: python3 is missing");
        return;
    }
    let test = concat!(env!("CARGO_MANIFEST_DIR"), "/../../bindings/freecad/tests/test_plugin.py");
    let run =
        Command::new("python3").args(["-B", test, env!("CARGO_BIN_EXE_gnurt")]).output().expect("it starts");
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success() && run.stdout == b"passed\n", "{errors}");
}
