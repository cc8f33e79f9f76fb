// SPDX-License-Identifier: GPL-3.0-or-later
//! Odd data that can be shown all the same: a warning per kind, with a count, and a picture.

use super::harness::{Folder, Run};
use super::samples;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

fn render(folder: &Folder, scene: &str) -> Run {
    let run = folder.gnurt(&format!("render {scene} -r 8x8 --spp 1 -o p.png")).success();
    assert!(folder.at("p.png").exists(), "there is a picture");
    run
}

#[test]
fn odd_files_warn_and_render() {
    let with = |rest: &str| format!("{TRIANGLE}{rest}");
    let rows = [
        (with("v nan 0 0\nf 1 2 3\nf 1 2 4\n"), "NaN"),
        (with("v inf 0 0\nf 1 2 3\nf 1 2 4\nf 1 4 3\n"), "2 "),
        (with("f 1 2 3\nf 1 1 2\n"), "area"),
        (with("f 1/9 2/9 3/9\n"), "texture coordinate"),
        (with("f 1//9 2//9 3//9\n"), "normal"),
        (with("mtllib none.mtl\nf 1 2 3\n"), "none.mtl"),
        (with("usemtl nobody\nf 1 2 3\n"), "material"),
        (with("mtllib odd.mtl\nusemtl odd\nf 1 2 3\n"), "odd.mtl"),
        (with("mtllib map.mtl\nusemtl map\nf 1/1 2/1 3/1\n"), "none.png"),
        (with("mtllib map.mtl\nusemtl broken\nf 1/1 2/1 3/1\n"), "broken.png"),
        (with("f 1 2\nf 1 2 3\n"), "corners"),
        (String::new(), "background"),
        (with("f 1 1 1\n"), "background"),
    ];
    for (text, expected) in rows {
        println!("{text:?}");
        let folder = Folder::new();
        folder.write("a.obj", text);
        folder.write("odd.mtl", "newmtl odd\nKd red green blue\n");
        folder.write("map.mtl", "newmtl map\nmap_Kd none.png\nnewmtl broken\nmap_Kd broken.png\n");
        folder.write("broken.png", &b"\x89PNG\r\n\x1a\nbroken"[..]);
        let run = render(&folder, "a.obj");
        assert!(
            run.lines("warning: ").iter().any(|line| line.contains(expected)),
            "'{expected}': {}",
            run.stderr
        );
        assert_eq!(run.lines("error: ").len(), 0, "no error: {}", run.stderr);
    }
}

#[test]
fn plain_oddities_are_silent() {
    let rows = [
        "\u{feff}v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3",
        "  v\t0 0 0\n\tv 1 0 0\n v 0 1 0\n   f 1 2 3\n",
        "frobnicate 7\nv 0 0 0\nv 1 0 0\nv 0 1 0\ns off\nf -3 -2 -1\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 2 0\nv 0 1 0\nf 1 2 3 4 5\n",
    ];
    for text in rows {
        let folder = Folder::new();
        folder.write("a.obj", text);
        let run = render(&folder, "a.obj");
        assert_eq!(run.lines("warning: ").len(), 0, "{text:?}: {}", run.stderr);
    }
}

#[test]
fn kinds_are_counted_on_one_line() {
    let folder = Folder::new();
    let many: String = (0..50).map(|_| "f 1 1 2\n").collect();
    folder.write("a.obj", format!("{TRIANGLE}f 1 2 3\n{many}"));
    let run = render(&folder, "a.obj");
    let warnings = run.lines("warning: ");
    assert_eq!(warnings.len(), 1, "one line per kind: {}", run.stderr);
    assert!(warnings[0].contains("50"), "with its count: {}", run.stderr);
}

#[test]
fn files_may_have_any_name() {
    let folder = Folder::new();
    folder.write("mein Bäum.ply", samples::PLY);
    folder.run(&["render", "mein Bäum.ply", "-r", "4x4", "--spp", "1", "-o", "Bild größer.png"]).success();
    assert!(folder.at("Bild größer.png").exists(), "the picture");
}

#[test]
fn unknown_extensions_warn_or_fail() {
    let folder = Folder::new();
    let text = samples::gltf(Some("triangle.bin"));
    folder.write("triangle.bin", samples::gltf_buffer());
    folder.write("known.gltf", &text);
    let required = r#"{"extensionsUsed":["EXT_odd"],"extensionsRequired":["EXT_odd"],"#;
    folder.write("odd.gltf", text.replacen('{', required, 1));
    assert_eq!(render(&folder, "known.gltf").lines("warning: ").len(), 0, "nothing odd");
    folder.gnurt("info odd.gltf").fails(1, "the file requires the extension `EXT_odd`");
    folder.write("used.gltf", text.replacen('{', r#"{"extensionsUsed":["EXT_odd"],"#, 1));
    let run = render(&folder, "used.gltf");
    assert!(run.lines("warning: ").len() == 1 && run.stderr.contains("EXT_odd"), "{}", run.stderr);
    folder.gnurt("info used.gltf --strict").fails(1, "warnings are errors");
    folder.gnurt("info known.gltf --strict").success();
}
