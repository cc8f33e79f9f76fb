// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes that may read files of one folder only.
//! The folder of the tests: `in/` is allowed, `out/` is not.

use std::path::Path;

use crate::common::{FORMATS, load};
use gnurt_scene::io::{Error, LoadOptions, Loaded};

const V: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
/// A PNG of one pixel.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x06\0\0\0\x1f\x15\xc4\x89\0\0\0\rIDATx\xdac\xfc\xcf\xc0P\x0f\0\x04\x85\x01\x80\x84\xa9\x8c!\0\0\0\0IEND\xaeB`\x82";

fn write(path: &Path, bytes: impl AsRef<[u8]>) {
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    std::fs::write(path, bytes).expect("a file");
}

/// Loads a scene in `in/` that may read only files there.
fn confined(folder: &Path, name: &str, text: &str) -> Result<Loaded, Error> {
    let path = folder.join("in").join(name);
    write(&path, text);
    FORMATS.load(path, &LoadOptions { confine: Some(folder.join("in")), ..LoadOptions::default() })
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for position in ["in/maps", "out"] {
        write(&folder.path().join(position).join("a.png"), PNG);
        write(&folder.path().join(position).join("lib.mtl"), "newmtl a\nKd x root:x:0:0\n");
        write(&folder.path().join(position).join("a.bin"), [0; 36]);
    }
    folder
}

/// Ways to `out/` from a file in `in/`.
fn escapes(folder: &Path, name: &str) -> Vec<String> {
    let absolute = folder.join("out").join(name).display().to_string();
    let mut paths = vec![
        format!("../out/{name}"),
        format!("maps/../../out/{name}"),
        format!("..\\out\\{name}"),
        format!("%2e%2e/out/{name}"),
        format!("../out/none-{name}"),
        format!("../none/{name}"),
        "../..".to_owned(),
        absolute,
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.join("out").join(name), folder.join("in").join(name))
            .expect("a link");
        std::os::unix::fs::symlink(folder.join("out"), folder.join(format!("in/to-{name}"))).expect("a link");
        let nowhere = format!("nowhere-{name}");
        std::os::unix::fs::symlink(folder.join("out/gone"), folder.join("in").join(&nowhere))
            .expect("a link");
        paths.extend([name.to_owned(), format!("to-{name}/{name}"), nowhere, "/dev/zero".to_owned()]);
    }
    paths
}

#[test]
fn libraries_and_textures() {
    let folder = folder();
    let at = folder.path();
    let scene = |library: &str| format!("mtllib {library}\n{V}usemtl a\nf 1 2 3\n");
    confined(at, "t.obj", &scene("maps/lib.mtl")).expect("a library below the folder");
    for escape in escapes(at, "lib.mtl") {
        let line = confined(at, "t.obj", &scene(&escape)).expect_err(&escape).to_string();
        assert!(
            line.contains("t.obj:1: ") && line.contains("is outside"),
            "{escape}: file, line and problem: {line}"
        );
        assert!(
            line.contains("; expected a file below ") && !line.contains("root:"),
            "{escape}: and what is right: {line}"
        );
    }
    let library = |map: &str| write(&at.join("in/maps/t.mtl"), format!("newmtl a\nmap_Kd {map}\n"));
    library("-s 2 2 2 a.png");
    let loaded = confined(at, "t.obj", &scene("maps/t.mtl")).expect("a texture below the folder");
    assert_eq!((loaded.scene.textures().len(), loaded.warnings.is_empty()), (1, true), "it is read");
    for escape in escapes(at, "a.png") {
        // From the library's folder, one up.
        let escape = if escape.starts_with("/") { escape } else { format!("../{escape}") };
        library(&escape);
        let line = confined(at, "t.obj", &scene("maps/t.mtl")).expect_err(&escape).to_string();
        assert!(line.contains("t.mtl:2: ") && line.contains("is outside"), "{escape}: {line}");
    }
    library("none.png");
    let loaded = confined(at, "t.obj", &scene("maps/t.mtl")).expect("a missing texture is no error");
    assert!(!loaded.warnings.is_empty(), "but said");
}

#[test]
fn buffers_and_images() {
    let folder = folder();
    let at = folder.path();
    let buffer = |uri: &str| {
        let uri = uri.replace('\\', "\\\\");
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\n\"buffers\":[{{\"byteLength\":36,\"uri\":\"{uri}\"}}]}}"
        )
    };
    let image = |uri: &str| {
        let uri = uri.replace('\\', "\\\\");
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\n\"images\":[\n{{\"uri\":\"{uri}\"}}]}}")
    };
    confined(at, "t.gltf", &buffer("maps/a.bin")).expect("a buffer below the folder");
    confined(at, "t.gltf", &buffer("data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"))
        .expect("data");
    confined(at, "t.gltf", &image("maps/a.png")).expect("an image below the folder");
    for escape in escapes(at, "a.bin") {
        let line = confined(at, "t.gltf", &buffer(&escape)).expect_err(&escape).to_string();
        assert!(line.contains("t.gltf:2: buffers[0]: ") && line.contains("is outside"), "{escape}: {line}");
    }
    for escape in escapes(at, "a.png") {
        let line = confined(at, "t.gltf", &image(&escape)).expect_err(&escape).to_string();
        assert!(line.contains("t.gltf:3: images[0]: ") && line.contains("is outside"), "{escape}: {line}");
    }
}

#[test]
fn the_folder_must_be_one() {
    let folder = folder();
    let scene = folder.path().join("in/t.obj");
    write(&scene, V);
    for bad in ["none", "in/t.obj"] {
        let options = LoadOptions { confine: Some(folder.path().join(bad)), ..LoadOptions::default() };
        FORMATS.load(&scene, &options).expect_err("it is no folder");
    }
    load(&scene).expect("without a folder all is well");
}

#[test]
fn libraries_are_not_quoted() {
    let folder = folder();
    let path = folder.path().join("in/t.obj");
    write(&path, format!("mtllib ../out/lib.mtl\n{V}usemtl a\nf 1 2 3\n"));
    let loaded = load(&path).expect("a bad line is no error");
    let line = loaded.warnings.iter().map(ToString::to_string).collect::<String>();
    assert!(
        line.contains("lib.mtl:2: ") && line.contains("`Kd`: expected 3 numbers"),
        "what is wrong: {line}"
    );
    assert!(!line.contains("root"), "but not what stands there: {line}");
}
