// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures in tiles, and properties of picture files.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use gnurt_image::{Picture, PictureFormat, WriteOptions};
use gnurt_shading::{SurfaceBatch, SurfaceShader};
use gnurt_sl_shading::{Access, Codes, Script};

use super::floor::floor;
use super::kinds::emitted;

/// A picture of two rows of colours: the upper one half as bright.
fn tile(folder: &Path, name: &str, color: [f32; 3]) {
    let mut picture = Picture::new(4, 2);
    for (i, texel) in picture.color.iter_mut().enumerate() {
        let scale = if i < 4 { 0.5 } else { 1.0 };
        *texel = [color[0] * scale, color[1] * scale, color[2] * scale, 1.0];
    }
    gnurt_image::write(&picture, &folder.join(name), &WriteOptions::default()).expect("a picture");
}

/// Points in the tiles 1001, 1002, 1012 and 1022, and left of all.
const POINTS: [[f32; 2]; 5] = [[0.3, 0.9], [1.3, 0.9], [1.3, 1.9], [1.3, 2.9], [-0.3, 0.9]];

fn hits(points: &[[f32; 2]]) -> SurfaceBatch {
    let mut hits = floor(40);
    for i in 0..40 {
        [hits.texcoord[0][i], hits.texcoord[1][i]] = points[i % points.len()];
    }
    hits
}

fn open(folder: &Path, body: &str) -> Arc<dyn SurfaceShader> {
    let at = folder.join("s.osl");
    std::fs::write(&at, format!("surface s () {{ {body} }}")).expect("a shader");
    Script::open(&at, &Access::default()).expect("it compiles").surface().expect("a surface")
}

/// The same by the interpreter and by code.
fn lights_at(folder: &Path, body: &str, points: &[[f32; 2]]) -> Vec<Vec3> {
    let (shader, hits, count) = (open(folder, body), hits(points), points.len());
    let first = emitted(&*shader, &hits);
    Codes::default().wait();
    assert_eq!(first, emitted(&*shader, &hits), "code: {body}");
    assert_eq!(first[..count], first[4 * count..5 * count], "all lanes: {body}");
    first[..count].to_vec()
}

fn lights(folder: &Path, body: &str) -> Vec<Vec3> {
    lights_at(folder, body, &POINTS)
}

#[test]
fn names_of_tiles_are_a_file_for_each_unit_square() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let colors = [[0.25, 0.5, 0.75], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]];
    for (number, color) in [1001, 1002, 1012].into_iter().zip(colors) {
        tile(folder, &format!("a.{number}.pfm"), color);
    }
    for (name, color) in ["u1_v1", "u2_v1", "u2_v2"].into_iter().zip(colors) {
        tile(folder, &format!("b_{name}.pfm"), color);
    }
    for (name, color) in ["u0_v0", "u1_v0", "u1_v1"].into_iter().zip(colors) {
        tile(folder, &format!("c_{name}.pfm"), color);
    }
    let expected = colors.map(Vec3::from);
    for name in ["a.<UDIM>.pfm", "a.%(UDIM)d.pfm", "b_<UVTILE>.pfm", "b_<U>_<V>.pfm", "c_<u>_<v>.pfm"] {
        // At 0.9 downwards is the lower row.
        let found = lights(
            folder,
            &format!("Ci = (color) texture (\"{name}\", u, v, \"wrap\", \"periodic\") * emission ();"),
        );
        assert_eq!(found[..3], expected, "{name}");
        assert_eq!(found[3..], [Vec3::ZERO; 2], "{name}: tiles without a file");
        let missing = "\"missingcolor\", color (0.1, 0.2, 0.3)";
        let found =
            lights(folder, &format!("Ci = (color) texture (\"{name}\", u, v, {missing}) * emission ();"));
        assert_eq!(found[..3], expected, "{name}, with a colour for missing tiles");
        assert_eq!(found[3..], [Vec3::new(0.1, 0.2, 0.3); 2], "{name}: the colour of missing tiles");
    }
    let body = "Ci = (color) texture (\"a.<UDIM>.pfm\", u, v - 0.8) * emission ();";
    assert_eq!(lights(folder, body)[0], expected[0] * 0.5, "the upper row");
}

/// Pictures that vary along s and t, at positions away from their edges. All points are in tiles with files, so that they
/// are read together.
#[test]
fn positions_lie_within_their_tile() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (number, first) in [(1001, 0.0), (1002, 100.0), (1012, 200.0)] {
        let mut picture = Picture::new(4, 4);
        for (i, texel) in picture.color.iter_mut().enumerate() {
            *texel = [first + i as f32, 0.0, 0.0, 1.0];
        }
        gnurt_image::write(&picture, &folder.join(format!("a.{number}.pfm")), &WriteOptions::default())
            .expect("a picture");
    }
    // Rows of four texels, downwards.
    for (s, t, column, row) in [(0.0, 0.0, 1, 3), (0.3, -0.6, 2, 1), (-0.2, -0.3, 0, 2), (0.5, -0.8, 3, 0)] {
        let read = format!("texture (\"a.<UDIM>.pfm\", u + {s}, v + {t}, \"interp\", \"closest\")");
        let found = lights_at(folder, &format!("Ci = (color) {read} * emission ();"), &POINTS[..3]);
        let texel = (4 * row + column) as f32;
        let red: Vec<f32> = found.iter().map(|light| light.x).collect();
        assert_eq!(red, [texel, 100.0 + texel, 200.0 + texel], "{read}");
    }
}

#[test]
fn missing_tiles_are_not_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    tile(folder.path(), "a.1001.pfm", [1.0; 3]);
    for (name, count) in [("a.<UDIM>.pfm", 0), ("none.pfm", 1)] {
        let at = folder.path().join("s.osl");
        std::fs::write(
            &at,
            format!("surface s () {{ Ci = (color) texture (\"{name}\", u, v) * emission (); }}"),
        )
        .expect("a shader");
        let script = Script::open(&at, &Access::default()).expect("it compiles");
        emitted(&*script.surface().expect("a surface"), &hits(&POINTS));
        assert_eq!(script.faults().len(), count, "{name}: {:?}", script.faults());
    }
}

/// The values of ints that a body computes.
fn ints(folder: &Path, body: &str) -> [f32; 3] {
    lights(folder, &format!("int a = -1, b = -1, c = -1; {body} Ci = color (a, b, c) * emission ();"))[0]
        .to_array()
}

#[test]
fn properties_are_those_of_the_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    tile(folder, "a.1001.pfm", [1.0, 0.5, 0.25]);
    tile(folder, "a.1012.pfm", [1.0, 0.5, 0.25]);
    let grey = Picture::new(3, 5);
    gnurt_image::write(&grey, &folder.join("b.png"), &WriteOptions::default()).expect("a picture");
    let bytes = gnurt_image::encode(&grey, PictureFormat::PNG, &WriteOptions::default()).expect("bytes");
    let channels = match bytes[25] {
        2 => 3.0,
        6 => 4.0,
        kind => panic!("colour type {kind}"),
    };
    let info = |file: &str, what: &str, to: &str| format!("gettextureinfo (\"{file}\", \"{what}\", {to})");
    let body = format!(
        "{}; b = {}; c = {};",
        info("b.png", "channels", "a"),
        info("b.png", "exists", "c"),
        info("c.png", "channels", "c")
    );
    assert_eq!(ints(folder, &body), [channels, 1.0, 0.0], "channels, and no file");
    let body = format!("int s[3]; {}; a = s[0]; b = s[1]; c = s[2];", info("b.png", "resolution", "s"));
    assert_eq!(ints(folder, &body), [3.0, 5.0, 1.0], "size with a depth");
    let body = format!("int s[6]; {}; a = s[3]; b = s[4]; c = s[5];", info("b.png", "datawindow", "s"));
    assert_eq!(ints(folder, &body), [2.0, 4.0, 0.0], "window with a depth");
    let body = format!(
        "{}; {}; string t; {}; c = t == \"Plain Texture\";",
        info("b.png", "subimages", "a"),
        info("b.png", "udim", "b"),
        info("b.png", "type", "t")
    );
    assert_eq!(ints(folder, &body), [1.0, 0.0, 1.0], "a plain picture");
    let body = format!(
        "{}; {}; {};",
        info("a.<UDIM>.pfm", "udim", "a"),
        info("a.<UDIM>.pfm", "exists", "b"),
        info("a.<UDIM>.pfm", "channels", "c")
    );
    assert_eq!(ints(folder, &body), [1.0, 1.0, 3.0], "tiles");
    let body = "gettextureinfo (\"a.<UDIM>.pfm\", 1.5, 1.5, \"exists\", a); gettextureinfo (\"a.<UDIM>.pfm\", 0.5, 1.5, \"exists\", b);
        gettextureinfo (\"a.<UDIM>.pfm\", 0.5, 0.5, \"channels\", c);";
    assert_eq!(ints(folder, body), [1.0, 0.0, 3.0], "single tiles");
    let body = "color m = 0; gettextureinfo (\"a.<UDIM>.pfm\", \"averagecolor\", m); Ci = m * emission ();";
    assert_eq!(lights(folder, body)[0], Vec3::new(0.75, 0.375, 0.1875), "means of both rows");
    tile(folder, "a.1013.pfm", [0.0; 3]);
    assert_eq!(lights(folder, &body.replace("= 0;", "= 7;"))[0], Vec3::splat(7.0), "tiles that differ");
}
