// SPDX-License-Identifier: GPL-3.0-or-later
//! The shaders that come with GNU RT compile without a warning, and say what their parameters are.

use std::path::{Path, PathBuf};

use gnurt_sl::{Options, compile};

fn surfaces() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders/surfaces")
}

#[test]
fn surfaces_compile_without_a_warning() {
    let options = Options { warnings_are_errors: true, ..Options::default() };
    let load = |path: &Path| std::fs::read_to_string(path).ok();
    let mut count = 0;
    for entry in std::fs::read_dir(surfaces()).expect("the folder of surfaces") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|extension| extension != "osl") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a shader");
        let compiled = compile(&path.to_string_lossy(), &text, &options, &load);
        assert!(compiled.shader.is_some(), "{}: {:?}", path.display(), compiled.diagnostics);
        assert!(text.contains("string label = "), "{}: its parameters have labels", path.display());
        count += 1;
    }
    assert_eq!(count, 20, "surfaces");
}
