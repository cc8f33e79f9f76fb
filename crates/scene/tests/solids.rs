// SPDX-License-Identifier: GPL-3.0-or-later
//! STL and 3MF, and the axis that points upwards.

use crate::common::{FORMATS, load_named, save};
use gnurt_scene::io::{LoadOptions, Oddity, UpAxis};
use gnurt_scene::{Affine, Material, Mesh, Scene, Surface};

/// The corners of all triangles in the world, one line each, in order.
fn corners(scene: &Scene) -> Vec<String> {
    let mut all = Vec::new();
    for found in scene.occurrences() {
        for &id in &found.object.meshes {
            let mesh = scene.mesh(id);
            let at = |i: u32| found.world_from_object.point(mesh.positions[i as usize].map(f64::from));
            // A rounded zero may have either sign.
            let round = |x: f64| (x * 1e6).round() / 1e6 + 0.0;
            all.extend(mesh.indices.iter().map(|t| format!("{:?}", t.map(|i| at(i).map(round)))));
        }
    }
    all.sort();
    all
}

const TEXT: &str = "solid tetra\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 0 0 1e0\nendloop\nendfacet\nendsolid tetra\n";

#[test]
fn stl_is_read_and_written() {
    let loaded = load_named("t.stl", TEXT.as_bytes()).expect("a text");
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!((mesh.positions.len(), mesh.indices.len()), (4, 2), "equal corners are one vertex");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("out.stl");
    let warnings = save(&loaded.scene, &path).expect("written");
    assert_eq!(warnings.count(Oddity::NotShown), 1, "the material is lost");
    let bytes = std::fs::read(&path).expect("a file");
    assert_eq!(bytes.len(), 84 + 2 * 50, "a binary file");
    assert!(!bytes.starts_with(b"solid"), "that no reader takes for a text");
    let again = load_named("t.stl", &bytes).expect("a binary file");
    assert_eq!(corners(&again.scene), corners(&loaded.scene), "the same triangles");
    let mut odd = bytes.clone();
    odd[..5].copy_from_slice(b"solid");
    let again = load_named("t.stl", &odd).expect("a binary file that begins as a text does");
    assert_eq!(corners(&again.scene), corners(&loaded.scene), "by its length");
}

#[test]
fn broken_solids_are_refused() {
    let message = |bytes: &[u8]| load_named("t.stl", bytes).expect_err("broken").to_string();
    assert!(message(b"").contains("no STL file"), "nothing");
    assert!(message(&[1; 90]).contains("cut off"), "fewer triangles than declared");
    assert!(
        message(&TEXT.as_bytes()[..TEXT.find(" endloop").expect("there")]).contains("without an end"),
        "a text that was cut off"
    );
    let bad = TEXT.replacen("1 0 0", "1 x 0", 1);
    assert!(message(bad.as_bytes()).contains("t.stl:5: `vertex 1 x 0`"), "{}", message(bad.as_bytes()));
    let short = TEXT.replacen("  vertex 1 0 0\n", "", 1);
    assert!(message(short.as_bytes()).contains("facet with 2 corners"), "{}", message(short.as_bytes()));
    assert!(message(b"solid a\npolygon 3\n").contains("t.stl:2: unknown keyword"), "another format");
}

/// A ZIP archive of stored parts.
pub(crate) fn archive(parts: &[(&str, &str)]) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for (name, text) in parts {
        let offset = file.len() as u32;
        let sizes =
            [&[0_u8; 4][..], &(text.len() as u32).to_le_bytes(), &(text.len() as u32).to_le_bytes()].concat();
        let lengths = [&(name.len() as u16).to_le_bytes()[..], &[0; 2]].concat();
        file.extend(b"PK\x03\x04\x14\0\0\0\0\0\0\0\0\0");
        file.extend([&sizes[..], &lengths, name.as_bytes(), text.as_bytes()].concat());
        directory.extend(b"PK\x01\x02\x14\0\x14\0\0\0\0\0\0\0\0\0");
        directory.extend([&sizes[..], &lengths, &[0; 10], &offset.to_le_bytes(), name.as_bytes()].concat());
    }
    let count = (parts.len() as u16).to_le_bytes();
    let (length, start) = ((directory.len() as u32).to_le_bytes(), (file.len() as u32).to_le_bytes());
    file.extend(directory);
    file.extend([b"PK\x05\x06\0\0\0\0", &count[..], &count, &length, &start, &[0; 2]].concat());
    file
}

pub(crate) const MODEL: &str = r##"<?xml version="1.0" encoding="UTF-8"?>
<model unit="centimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">
<resources>
<basematerials id="5"><base name="red" displaycolor="#FF0000"/><base name="green" displaycolor="#00FF00FF"/></basematerials>
<object id="1" name="part" pid="5" pindex="0"><mesh><vertices>
<vertex x="0" y="0" z="0"/><vertex x="10" y="0" z="0"/><vertex x="0" y="10" z="0"/><vertex x="0" y="0" z="10"/></vertices>
<triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="2" v3="3" p1="1"/></triangles></mesh></object>
<object id="2"><components><component objectid="1"/><component objectid="1" transform="1 0 0 0 1 0 0 0 1 20 0 0"/></components></object>
</resources>
<build><item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 100"/></build></model>"##;

#[test]
fn models_of_3mf_are_placed_upright_in_metres() {
    let loaded =
        load_named("t.3mf", &archive(&[("[Content_Types].xml", "<x/>"), ("3D/3dmodel.model", MODEL)]));
    let scene = loaded.expect("a model").scene;
    assert_eq!((scene.objects().len(), scene.instances().len()), (2, 1), "an assembly of one part");
    let found = corners(&scene);
    assert_eq!(found.len(), 4, "two triangles twice: {found:?}");
    assert!(found[0].contains("[0.0, 1.0, 0.0], [0.0, 1.0, -0.1], [0.0, 1.1, 0.0]"), "y is up: {found:?}");
    let colors: Vec<_> = scene.meshes().iter().map(|mesh| &scene.material(mesh.material).surface).collect();
    let is = |surface: &Surface, color| matches!(surface, Surface::Matte { base_color } if base_color.factor == color);
    assert!(is(colors[0], [1.0, 0.0, 0.0]) && is(colors[1], [0.0, 1.0, 0.0]), "colours: {colors:?}");
}

#[test]
fn broken_archives_are_refused() {
    let with = |model: &str| archive(&[("3D/3dmodel.model", model)]);
    let message = |bytes: &[u8]| load_named("t.3mf", bytes).expect_err("broken").to_string();
    assert!(message(b"PK").contains("no archive"), "nothing");
    assert!(message(&archive(&[("a", "b")])).contains("no model in the archive"), "another archive");
    let odd = MODEL.replace("v2=\"1\" v3=\"2\"", "v2=\"1\" v3=\"9\"");
    assert!(message(&with(&odd)).contains("line 7 of 3D/3dmodel.model: vertex 9 out of range"), "a corner");
    let circle = MODEL.replace("component objectid=\"1\"", "component objectid=\"2\"");
    assert!(message(&with(&circle)).contains("too deep"), "a circle");
    let missing = MODEL.replace("item objectid=\"2\"", "item objectid=\"7\"");
    assert!(message(&with(&missing)).contains("object 7 of 3d/3dmodel.model does not exist"), "an item");
    let unit = MODEL.replace("centimeter", "yard");
    assert!(message(&with(&unit)).contains("unit `yard`"), "a unit");
    let whole = with(MODEL);
    for cut in 0..whole.len() {
        assert!(load_named("t.3mf", &whole[..cut]).is_err(), "cut off at {cut}");
    }
}

#[test]
fn another_axis_may_point_upwards() {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("grey", [0.5; 3]));
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 3.0]];
    let mesh = scene.add_mesh(Mesh { positions, indices: vec![[0, 1, 2]], material, ..Mesh::default() });
    let object = scene.add_object_of("o", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let load = |name: &str, up| {
        let path = folder.path().join(name);
        save(&scene, &path).expect("written");
        FORMATS.load(path, &LoadOptions { up, ..LoadOptions::default() })
    };
    for name in ["a.stl", "a.obj", "a.ply"] {
        let z = corners(&load(name, Some(UpAxis::Z)).expect("read").scene);
        assert_eq!(z, ["[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 3.0, -2.0]]"], "{name}, z up");
        let x = corners(&load(name, Some(UpAxis::X)).expect("read").scene);
        assert_eq!(x, ["[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-2.0, 0.0, 3.0]]"], "{name}, x up");
    }
    let error = load("a.gltf", Some(UpAxis::Z)).expect_err("glTF says it").to_string();
    assert!(error.contains("says itself which axis points upwards"), "{error}");
}

/// Coordinates of a map: single precision has steps of half a metre there.
#[test]
fn far_meshes_keep_their_shape() {
    let corners =
        [[4_649_776.1, 0.0, 500_000.2], [4_649_776.3, 0.0, 500_000.2], [4_649_776.1, 0.4, 500_000.2]];
    let lines: String = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let rows: String = corners.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{rows}3 0 1 2\n"
    );
    for (name, text) in [("t.obj", format!("{lines}f 1 2 3\n")), ("t.ply", ply)] {
        let scene = load_named(name, text.as_bytes()).expect("a triangle").scene;
        let world = scene.instances()[0].world_from_object;
        let mesh = &scene.meshes()[0];
        for (position, corner) in mesh.positions.iter().zip(corners) {
            let found = world.point(position.map(f64::from));
            assert!((0..3).all(|k| (found[k] - corner[k]).abs() < 1e-4), "{name}: {found:?}, {corner:?}");
        }
    }
}
