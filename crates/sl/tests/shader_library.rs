// SPDX-License-Identifier: GPL-3.0-or-later
//! The shaders that come with GNU RT compile without a warning, and document their parameters.

use std::path::{Path, PathBuf};

use gnurt_sl::exec::unknown_operation;
use gnurt_sl::{Options, compile};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders").join(name)
}

#[test]
fn shaders_compile_without_a_warning() {
    let options = Options { warnings_are_errors: true, ..Options::default() };
    let load = |path: &Path| std::fs::read_to_string(path).ok();
    let kinds = [
        ("surfaces", "surface", 21),
        ("lights", "light", 6),
        ("cameras", "camera", 4),
        ("skies", "environment", 3),
        ("pixels", "pixel", 3),
    ];
    for (name, kind, expected) in kinds {
        let mut count = 0;
        for entry in std::fs::read_dir(folder(name)).expect("a folder of shaders") {
            let path = entry.expect("an entry").path();
            if path.extension().is_none_or(|extension| extension != "osl") {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("a shader");
            let compiled = compile(&path.to_string_lossy(), &text, &options, &load);
            let shader = compiled.shader.unwrap_or_else(|| {
                panic!("{}: {:?}", path.display(), compiled.diagnostics);
            });
            assert_eq!(&*shader.kind, kind, "{}", path.display());
            assert_eq!(unknown_operation(&shader), None, "{}", path.display());
            assert!(text.contains("string label = "), "{}: its parameters have labels", path.display());
            count += 1;
        }
        assert_eq!(count, expected, "{name}");
    }
}
