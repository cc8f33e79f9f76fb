// SPDX-License-Identifier: GPL-3.0-or-later
//! Long arrays, which are read beside the library: the same in text and binary layers, at rest and at moments.

use std::fmt::Write;
use std::io::Cursor;

use gnurt_scene::io::{LoadOptions, Loaded};

use crate::support::{FORMATS, Folder, warnings};

/// Points along each side of a grid.
const SIDE: usize = 40;

/// Numbers or vectors as a list.
fn list(elements: impl Iterator<Item = String>) -> String {
    format!("[{}]", elements.collect::<Vec<_>>().join(", "))
}

fn point(i: usize, height: f32) -> [f32; 3] {
    [(i % SIDE) as f32 * 0.1, height, (i / SIDE) as f32 * 0.3]
}

fn points(height: f32) -> String {
    list((0..SIDE * SIDE).map(|i| point(i, height)).map(|[x, y, z]| format!("({x}, {y}, {z})")))
}

/// A grid of squares whose points are at rest, and another one that takes the same points at one moment.
fn layer() -> String {
    let corners = (0..SIDE - 1).flat_map(|y| (0..SIDE - 1).map(move |x| y * SIDE + x));
    let corners = list(corners.flat_map(|i| [i, i + SIDE, i + SIDE + 1, i + 1]).map(|i| i.to_string()));
    let counts = list((0..(SIDE - 1) * (SIDE - 1)).map(|_| "4".to_owned()));
    let texcoords = list((0..SIDE * SIDE).map(|i| format!("({}, {})", i as f32 / 8.0, 1e-3 * i as f32)));
    let mut text = "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n".to_owned();
    for (name, values) in [
        ("Still", format!("point3f[] points = {}", points(0.5))),
        ("Moving", format!("point3f[] points.timeSamples = {{ 0: {}, 24: {} }}", points(0.5), points(2.5))),
    ] {
        let _ = write!(
            text,
            "def Mesh \"{name}\" {{\n uniform token subdivisionScheme = \"none\"\n {values}\n int[] faceVertexCounts = {counts}\n int[] faceVertexIndices = {corners}\n texCoord2f[] primvars:st = {texcoords} ( interpolation = \"vertex\" )\n}}\n"
        );
    }
    text
}

fn binary(text: &str) -> Vec<u8> {
    let data = openusd::usda::parse(text).expect("a layer");
    let mut bytes = Cursor::new(Vec::new());
    openusd::usdc::CrateWriter::write(&data, &mut bytes).expect("memory");
    bytes.into_inner()
}

fn is_right(loaded: &Loaded, heights: [f32; 2], what: &str) {
    assert_eq!(warnings(loaded), "", "{what}");
    let meshes = loaded.scene.meshes();
    assert_eq!(meshes.len(), 2, "{what}");
    for (mesh, height) in meshes.iter().zip(heights) {
        assert_eq!(mesh.primitive_count(), 2 * (SIDE - 1) * (SIDE - 1), "{what}");
        assert_eq!(mesh.positions.len(), SIDE * SIDE, "{what}");
        for (i, position) in mesh.positions.iter().enumerate() {
            assert_eq!(*position, point(i, height), "{what}, point {i}");
            assert_eq!(mesh.texcoords[i], [i as f32 / 8.0, 1e-3 * i as f32], "{what}, point {i}");
        }
    }
}

#[test]
fn long_arrays_in_all_forms() {
    let text = layer();
    let folder = Folder::with(&[("a.usda", &text), ("text.usd", &text)]);
    std::fs::write(folder.path("a.usdc"), binary(&text)).expect("a file");
    std::fs::write(folder.path("binary.usd"), binary(&text)).expect("a file");
    for name in ["a.usda", "text.usd", "a.usdc", "binary.usd"] {
        for (at, moving) in [(None, 0.5), (Some(1.0), 2.5), (Some(0.5), 1.5)] {
            for threads in [1, 3] {
                let options = LoadOptions { at, threads, ..LoadOptions::default() };
                let loaded = FORMATS.load(folder.path(name), &options).expect(name);
                is_right(&loaded, [0.5, moving], &format!("{name} at {at:?}"));
            }
        }
    }
}

#[test]
fn long_arrays_that_are_wrong() {
    let text = layer();
    for (from, to, expected) in [
        ("int[] faceVertexIndices = [0, 40", "int[] faceVertexIndices = [0, 4000", "names point 4000"),
        ("(0, 0.5, 0), (0.1", "(0, 0.5), (0.1", ""),
        ("(0, 0.5, 0), (0.1", "(0, 0.5, 0, 7), (0.1", "a.usda"),
        ("(0, 0.5, 0), (0.1", "(0, abc, 0), (0.1", "a.usda"),
        ("[4, 4", "[4, 9999999999", "a.usda"),
    ] {
        assert!(text.contains(from), "{from}");
        let folder = Folder::with(&[("a.usda", &text.replacen(from, to, 1))]);
        let message = match FORMATS.load(folder.path("a.usda"), &LoadOptions::default()) {
            Ok(loaded) => warnings(&loaded),
            Err(error) => error.to_string(),
        };
        assert!(message.contains(expected), "{to}: {message}");
    }
}

/// A file of OpenUSD, which writes equal arrays once: the points of one mesh are the first sample of another one.
#[test]
fn arrays_that_values_share() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/shared-arrays.usdc");
    for (at, moving) in [(0.0, 1.0), (0.5, 2.0), (1.0, 3.0)] {
        let loaded =
            FORMATS.load(path, &LoadOptions { at: Some(at), ..LoadOptions::default() }).expect("a file");
        let heights = loaded.scene.meshes().iter().map(|mesh| mesh.positions[77][1]);
        assert_eq!(heights.collect::<Vec<_>>(), [1.0, moving], "at {at}");
    }
}

#[test]
fn numbers_may_begin_with_their_point() {
    let points: String = (0..500)
        .map(|i| format!("(.5, -.25, {i}.), ").replacen(".5", if i == 1 { "7." } else { ".5" }, 1))
        .collect();
    // The second one is not written plainly, so the library reads it.
    let with_comment = points.replacen("), ", "), # .5\n", 1);
    let text = |points: &str| {
        format!(
            "def Mesh \"M\" {{ int[] faceVertexCounts = [3]  int[] faceVertexIndices = [0, 1, 499]\n\
             uniform token subdivisionScheme = \"none\"\n point3f[] points = [{}] }}",
            points.trim_end_matches(", ")
        )
    };
    for points in [&points, &with_comment] {
        let loaded = crate::support::load(&text(points));
        let corner = loaded.scene.meshes()[0].positions.last().copied().expect("a vertex");
        assert_eq!(corner, [0.5, -0.25, 499.0]);
    }
}
