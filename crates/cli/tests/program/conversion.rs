// SPDX-License-Identifier: GPL-3.0-or-later
//! `convert`: pictures to pictures, scenes to scenes.

use super::harness::Folder;
use super::samples;

#[test]
fn pictures_keep_their_light() {
    let folder = Folder::new();
    folder.write("a.pfm", samples::pfm());
    folder.gnurt("convert a.pfm b.exr").success();
    folder.gnurt("convert b.exr c.pfm").success();
    folder.gnurt("diff a.pfm c.pfm --fail 0.001").success();
    folder.gnurt("convert a.pfm dark.png --exposure -3 --tone reinhard").success();
    folder.gnurt("convert a.pfm light.png").success();
    assert_ne!(folder.read("dark.png"), folder.read("light.png"), "exposure changes the bytes");
}

#[test]
fn scenes_keep_their_triangles() {
    let folder = Folder::new();
    folder.write("a.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    for format in ["ply", "gltf", "glb", "obj"] {
        folder.gnurt(&format!("convert a.obj out.{format}")).success();
        let run = folder.gnurt(&format!("info out.{format} --json")).success();
        let info: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
        assert_eq!(info["triangles"], 2, "out.{format}");
        folder.gnurt(&format!("render out.{format} -r 8x8 --spp 1 -o p.png")).success();
    }
}

#[cfg(unix)]
#[test]
fn a_file_is_not_converted_into_itself() {
    let folder = Folder::new();
    folder.write("a.pfm", samples::pfm());
    std::os::unix::fs::symlink("a.pfm", folder.at("soft.pfm")).expect("a link");
    std::fs::hard_link(folder.at("a.pfm"), folder.at("hard.pfm")).expect("a link");
    for line in
        ["convert a.pfm soft.pfm", "convert soft.pfm a.pfm", "convert a.pfm hard.pfm", "convert a.pfm a.pfm"]
    {
        println!("{line}");
        folder.gnurt(line).fails(2, "the same file");
    }
    assert_eq!(folder.read("a.pfm"), samples::pfm(), "it is as it was");
}
