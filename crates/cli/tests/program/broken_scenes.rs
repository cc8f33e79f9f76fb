// SPDX-License-Identifier: GPL-3.0-or-later
//! Scene files that cannot be shown: one error line that names the file, status 1, and no picture.
//! Truncations and corruptions at every byte are tested in `gnurt-scene`; here is the way to the user.

use super::harness::Folder;
use super::samples;

/// Renders each file and expects one error line with its name and `expected`.
#[track_caller]
fn check(files: &[(&str, Vec<u8>, &str)]) {
    for (name, bytes, expected) in files {
        println!("{name}: {expected}");
        let folder = Folder::new();
        folder.write(name, bytes);
        let before = folder.contents();
        for line in [format!("render {name} -o p.png -r 8x8 --spp 1"), format!("info {name}")] {
            let run = folder.gnurt(&line);
            run.fails(1, expected);
            assert!(
                run.lines("error: ")[0].starts_with(&format!("error: {name}")),
                "the file is named: {}",
                run.stderr
            );
            assert_eq!(folder.contents(), before, "{line} left something behind");
        }
    }
}

fn text(name: &'static str, text: &str, expected: &'static str) -> (&'static str, Vec<u8>, &'static str) {
    (name, text.as_bytes().to_vec(), expected)
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn obj() {
    let with = |rest: &str| format!("{TRIANGLE}{rest}");
    check(&[
        text("a.obj", &with("f 1 2 9\n"), "a.obj:4:"),
        text("a.obj", &with("f 0 1 2\n"), "a.obj:4:"),
        text("a.obj", &with("f 1 2 -9\n"), "a.obj:4:"),
        text("a.obj", &with("f 1 2 x\n"), "a.obj:4:"),
        text("a.obj", &with("f 1 2 99999999999999999999\n"), "a.obj:4:"),
        text("a.obj", &with("f 1/ 2/ 3.5/\n"), "a.obj:4:"),
        text("a.obj", "v 0 0\n", "a.obj:1:"),
        text("a.obj", "v 0 0 zero\n", "a.obj:1:"),
        text("a.obj", &with("\n\nv 1 2\nf 1 2 3\n"), "a.obj:6:"),
        text("a.obj", &with("f 1 2\nf 3 2 7\n"), "a.obj:5:"),
        ("a.obj", b"PNG\x89\0\xff\xfe\0\0".to_vec(), "a.obj"),
        ("a.obj", samples::glb(), "a.obj"),
    ]);
}

#[test]
fn ply() {
    let change = |from: &str, to: &str| samples::PLY.replacen(from, to, 1);
    let binary = samples::binary_ply();
    let cut = |length: usize| binary[..binary.len() - length].to_vec();
    let mut far = binary.clone();
    let last = far.len() - 4;
    far[last..].copy_from_slice(&99_u32.to_le_bytes());
    check(&[
        text("a.ply", "", "a.ply"),
        text("a.ply", "play\n", "a.ply"),
        text("a.ply", "ply\n", "a.ply"),
        text("a.ply", &change("format ascii 1.0\n", ""), "a.ply"),
        text("a.ply", &change("ascii", "morse"), "a.ply"),
        text("a.ply", &change("end_header\n", ""), "a.ply"),
        text("a.ply", &change("element vertex 4", "element vertex many"), "a.ply"),
        text("a.ply", &change("element vertex 4", "element vertex -4"), "a.ply"),
        text("a.ply", &change("element vertex 4", "element vertex 99999999999"), "a.ply"),
        text("a.ply", &change("element vertex 4", "element vertex 5"), "a.ply"),
        text("a.ply", &change("element face 2", "element face 3"), "a.ply"),
        text("a.ply", &change("property float y", "property text y"), "a.ply"),
        text("a.ply", &change("property float y\n", ""), "a.ply"),
        text("a.ply", &change("3 0 1 2", "3 0 1 4"), "a.ply"),
        text("a.ply", &change("3 0 1 2", "3 0 1 -1"), "a.ply"),
        text("a.ply", &change("3 0 1 2", "9 0 1 2"), "a.ply"),
        text("a.ply", &change("1 1 0", "1 one 0"), "a.ply"),
        ("a.ply", cut(1), "a.ply"),
        ("a.ply", cut(20), "a.ply"),
        ("a.ply", cut(60), "a.ply"),
        ("a.ply", far, "a.ply"),
    ]);
}

#[test]
fn gltf() {
    let good = samples::gltf(Some("data:application/octet-stream;base64,AAAA"));
    let change = |from: &str, to: &str| good.replacen(from, to, 1);
    check(&[
        text("a.gltf", "", "a.gltf"),
        text("a.gltf", "{", "a.gltf"),
        text("a.gltf", "[]", "a.gltf"),
        text("a.gltf", "{}", "a.gltf"),
        text("a.gltf", "no json at all", "a.gltf"),
        text("a.gltf", &good, "a.gltf"),
        text("a.gltf", &good[..good.len() / 2], "a.gltf"),
        text("a.gltf", &change("2.0", "1.0"), "a.gltf"),
        text("a.gltf", &change("data:application/octet-stream;base64,AAAA", "missing.bin"), "missing.bin"),
        text("a.gltf", &change("base64,AAAA", "base64,%%%%"), "a.gltf"),
        text("a.gltf", &change("\"mesh\":0", "\"mesh\":7"), "a.gltf"),
        text("a.gltf", &change("\"nodes\":[0]", "\"nodes\":[5]"), "a.gltf"),
        text("a.gltf", &change("\"POSITION\":0", "\"POSITION\":9"), "a.gltf"),
        text("a.gltf", &change("\"bufferView\":0", "\"bufferView\":9"), "a.gltf"),
        text("a.gltf", &change("\"byteLength\":36", "\"byteLength\":99999999"), "a.gltf"),
        text("a.gltf", &change("5126", "1"), "a.gltf"),
        text("a.gltf", &change("\"count\":3", "\"count\":4000000000"), "a.gltf"),
        text("a.gltf", &change("VEC3", "VEC9"), "a.gltf"),
    ]);
}

#[test]
fn glb() {
    let good = samples::glb();
    let with = |at: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[at] = byte;
        bytes
    };
    let mut far = good.clone();
    // The last index of the triangle, before two bytes of padding.
    let index = far.len() - 4;
    far[index] = 200;
    check(&[
        ("a.glb", Vec::new(), "a.glb"),
        ("a.glb", b"glTF".to_vec(), "a.glb"),
        ("a.glb", good[..11].to_vec(), "a.glb"),
        ("a.glb", good[..40].to_vec(), "a.glb"),
        ("a.glb", good[..good.len() - 1].to_vec(), "a.glb"),
        ("a.glb", good[..good.len() - 44].to_vec(), "a.glb"),
        ("a.glb", with(0, b'G'), "a.glb"),
        ("a.glb", with(4, 9), "a.glb"),
        ("a.glb", with(15, 0x7f), "a.glb"),
        ("a.glb", with(16, b'X'), "a.glb"),
        ("a.glb", samples::glb_of("{\"asset\":", &[]), "a.glb"),
        ("a.glb", samples::glb_of(&samples::gltf(None), &[0; 4]), "a.glb"),
        ("a.glb", far, "a.glb"),
        text("a.glb", samples::OBJ, "a.glb"),
    ]);
}

#[test]
fn what_is_no_scene_file() {
    let folder = Folder::new();
    folder.write("scene.xyz", "solid\n");
    folder.write("scene", "v 0 0 0\n");
    std::fs::create_dir(folder.at("folder.obj")).expect("a folder");
    let before = folder.contents();
    let rows = [
        ("missing.obj", "missing.obj: no such file"),
        ("none/missing.obj", "no such file"),
        ("scene.xyz", "unknown scene format"),
        ("scene", "scene"),
        ("folder.obj", "is a folder"),
        ("/dev/null", "/dev/null"),
        ("scene.xyz/a.obj", "scene.xyz/a.obj"),
    ];
    for (scene, expected) in rows {
        println!("{scene}");
        folder.gnurt(&format!("render {scene} -o p.png")).fails(1, expected);
        folder.gnurt(&format!("info {scene} --json")).fails(1, expected);
        folder.gnurt(&format!("trace {scene} --pixel 0,0")).fails(1, expected);
        assert_eq!(folder.contents(), before, "{scene} left something behind");
    }
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_not_read() {
    let folder = Folder::new();
    std::os::unix::fs::symlink("/dev/zero", folder.at("zero.obj")).expect("a link");
    std::os::unix::fs::symlink("nowhere.obj", folder.at("dangling.obj")).expect("a link");
    let made = std::process::Command::new("mkfifo").arg(folder.at("pipe.obj")).status();
    folder.gnurt("render zero.obj -o p.png").fails(1, "device or a pipe");
    folder.gnurt("render dangling.obj -o p.png").fails(1, "dangling.obj");
    if made.is_ok_and(|status| status.success()) {
        folder.gnurt("render pipe.obj -o p.png").fails(1, "device or a pipe");
    }
}

#[test]
fn an_old_picture_survives() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0\n");
    folder.write("p.png", "old");
    folder.gnurt("render a.obj -o p.png").fails(1, "a.obj:1:");
    assert_eq!(folder.read("p.png"), b"old", "the old picture is as it was");
}
