// SPDX-License-Identifier: GPL-3.0-or-later
//! Documents for tests, and their shaders compiled and run.

use std::path::Path;

use gnurt_materialx::{Document, Shader};
use gnurt_sl_tools::{Console, tool};

/// The document of these elements.
pub(crate) fn document(elements: &str) -> String {
    format!("<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n{elements}\n</materialx>\n")
}

/// The shader of a text; `files` are by name what it includes.
pub(crate) fn shader(text: &str, files: &[(&str, String)], name: Option<&str>) -> Result<Shader, String> {
    let mut load = |path: &Path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        found.map(|(_, text)| text.clone()).ok_or_else(|| format!("{}: no file", path.display()))
    };
    let document =
        Document::of_text(Path::new("t.mtlx"), text, &mut load).map_err(|error| error.to_string())?;
    document.shader(name).map_err(|error| error.to_string())
}

/// The shader of elements.
pub(crate) fn generated(elements: &str, name: Option<&str>) -> Result<Shader, String> {
    shader(&document(elements), &[], name)
}

/// Compiles a text.
pub(crate) fn compiled(text: &str) -> Result<(), String> {
    let none = |_: &Path| None;
    let made = gnurt_sl::compile("t.osl", text, &gnurt_sl::Options::default(), &none);
    match made.shader {
        Some(_) => Ok(()),
        None => {
            Err(made.diagnostics.list.iter().map(|d| format!("{}: {}; ", d.loc.line, d.message)).collect())
        }
    }
}

/// The first number of a node's value, at u = v = 0.5.
pub(crate) fn value(elements: &str, name: &str) -> f32 {
    let made = generated(elements, Some(name)).expect("a shader");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("t.osl");
    let end = made.text.rfind('}').expect("an end");
    let printed = format!("{}    printf(\"@%.8g@\", (float) result);\n}}\n", &made.text[..end]);
    std::fs::write(&file, printed).expect("a file");
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let oso = folder.path().join("t.oso");
    for (name, arguments) in
        [("oslc", vec!["-q".into(), "-o".into(), text(&oso), text(&file)]), ("testshade", vec![text(&oso)])]
    {
        let mut console = Console::new(&mut out, &mut err, true);
        let status = tool(name).expect("a tool")(&arguments, &mut console);
        console.flush();
        assert_eq!(status, 0, "{}", String::from_utf8_lossy(&err));
    }
    let out = String::from_utf8_lossy(&out);
    let number = out.split('@').nth(1).unwrap_or_else(|| panic!("no number in {out}"));
    number.parse().expect("a number")
}
