// SPDX-License-Identifier: GPL-3.0-or-later
//! `info` and `scenes`.

use super::harness::Folder;
use super::samples;

#[test]
fn counts() {
    let folder = Folder::new();
    folder.write("a.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    let run = folder.gnurt("info a.obj --json --tree").success();
    let info: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON alone on standard output");
    for (name, count) in [("triangles", 2), ("objects", 1), ("instances", 1)] {
        assert_eq!(info[name], count, "{name}: {info}");
    }
    for name in ["lights", "cameras"] {
        assert_eq!(info[name], serde_json::json!([]), "{name}: {info}");
    }
    let shown = &info["occurrences"][0];
    assert_eq!(
        (&shown["triangles"], &shown["bounds"][1]),
        (&2.into(), &serde_json::json!([1.0, 2.0, 0.0])),
        "{shown}"
    );
    assert!(
        shown["area"].as_f64().is_some_and(|area| area > 0.0) && shown["centroid"][0].is_f64(),
        "{shown}"
    );
    assert_eq!(info["bounds"]["max"], serde_json::json!([1.0, 2.0, 0.0]), "the upper corner");
    assert!(info["memory"]["total"].as_u64().is_some_and(|bytes| bytes > 0), "memory: {info}");
    assert_eq!(info["material_names"][1], "red", "what --shader takes: {info}");
    assert!(info["tree"]["nodes"].is_u64(), "trees: {info}");
    let text = folder.gnurt("info a.obj").success().stdout;
    assert!(text.contains("'default', 'red'\n"), "names of materials: {text}");
    for expected_text in [
        "triangles",
        "vertices",
        "objects",
        "instances",
        "materials",
        "lights",
        "cameras",
        "bounds",
        "memory",
    ] {
        assert!(text.contains(expected_text), "{expected_text} is told: {text}");
    }
}

#[test]
fn light_is_counted() {
    let info = Folder::new().gnurt("info builtin:cornell --json").success();
    let info: serde_json::Value = serde_json::from_str(&info.stdout).expect("JSON");
    let camera = &info["cameras"][0];
    assert_eq!(camera["type"], "perspective", "the box has a camera: {info}");
    assert!(info["emissive_triangles"].as_u64().is_some_and(|n| n >= 2), "and a lamp: {info}");
}

#[test]
fn scenes_are_listed() {
    let run = Folder::new().gnurt("scenes").success();
    assert!(run.stdout.lines().count() >= 3 && run.stdout.contains("builtin:cornell"), "{}", run.stdout);
}

#[test]
fn pictures_are_listed() {
    let folder = Folder::new();
    folder.write("a.pfm", samples::pfm());
    folder.gnurt("convert a.pfm a.exr").success();
    let run = folder.gnurt("info a.exr --json").success();
    let info: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON alone on standard output");
    assert!(info["width"].is_u64() && info["height"].is_u64() && info["layers"].is_array(), "{info}");
    assert!(info["greatest"][0].as_f64().is_some_and(|x| x > 1.0), "{info}");
    let run = folder.gnurt("info a.exr").success();
    assert!(run.stdout.contains("size") && run.stdout.contains("linear"), "{}", run.stdout);
    folder.write("broken.exr", b"v/1\x01");
    folder.gnurt("info broken.exr").fails(1, "broken.exr");
}
