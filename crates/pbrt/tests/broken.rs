// SPDX-License-Identifier: GPL-3.0-or-later
//! Files that are wrong: each error is one line with file, line, the mistake and its remedy.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::common::{load, read_with_files, world_warned};

/// Texts, the line of their mistake, and a part of the message.
const BROKEN: [(&str, u64, &str); 38] = [
    ("Shape \"sphere\"", 1, "Shape before WorldBegin"),
    ("WorldBegin\nFoo", 2, "unknown statement `Foo`"),
    ("WorldBegin\n\"sphere\"", 2, "where a statement should begin"),
    ("WorldBegin\n[ 1 ]", 2, "bracket"),
    ("WorldBegin\n\nTranslate 1 2", 3, "Translate takes 3 numbers"),
    ("WorldBegin\nTranslate 1 x 2", 2, "found `x`"),
    ("WorldBegin\nScale 1 0 1", 2, "flattens"),
    ("LookAt 0 0 0  0 0 0  0 1 0\nWorldBegin", 1, "no view"),
    ("Transform [ 1 0 0 1  0 1 0 0  0 0 1 0  0 0 0 1 ]\nWorldBegin", 1, "no affine matrix"),
    ("WorldBegin\nShape \"sphere\" \"float radius\" [ 1", 2, "has no `]`"),
    ("WorldBegin\nShape \"sphere\" \"float radius\" x", 2, "`x` is not a number"),
    ("WorldBegin\nShape \"sphere\" \"float radius\" [ 1 2 ]", 2, "has 2 values"),
    ("WorldBegin\nShape \"sphere\" \"float radius\" [ ]", 2, "has no value"),
    ("WorldBegin\nShape \"sphere\" \"flaot radius\" 1", 2, "unknown type `flaot`"),
    ("WorldBegin\nShape \"sphere\" \"float\" 1", 2, "not a type and a name"),
    ("WorldBegin\nShape \"sphere\" \"float radius\" -1", 2, "\"radius\" is -1"),
    ("WorldBegin\nShape \"ball\"", 2, "unknown shape `ball`"),
    ("WorldBegin\nShape \"sphere", 2, "has no end"),
    ("WorldBegin\nShape \"trianglemesh\"", 2, "has no \"point3 P\""),
    (
        "WorldBegin\nShape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 3 ]",
        2,
        "the vertex 3",
    ),
    ("WorldBegin\nShape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 ]", 2, "not a multiple of 3"),
    ("WorldBegin\nShape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 ]", 2, "a curve of 2 points"),
    ("WorldBegin\nShape \"plymesh\" \"string filename\" \"none.ply\"", 0, "no such file"),
    ("WorldBegin\nMaterial \"matte\"", 2, "unknown material `matte`"),
    ("WorldBegin\nNamedMaterial \"gold\"\nShape \"sphere\"", 2, "no material `gold` is defined"),
    ("WorldBegin\nMaterial \"diffuse\" \"texture reflectance\" \"t\"", 2, "no spectrum texture `t`"),
    ("WorldBegin\nTexture \"t\" \"color\" \"constant\"", 2, "unknown type `color`"),
    ("WorldBegin\nTexture \"t\" \"float\" \"clouds\"", 2, "unknown texture class `clouds`"),
    ("WorldBegin\nLightSource \"sun\"", 2, "unknown light `sun`"),
    ("WorldBegin\nLightSource \"point\" \"rgb I\" [ 1 -1 0 ]", 2, "negative"),
    ("WorldBegin\nLightSource \"point\" \"spectrum I\" [ 400 1 300 1 ]", 2, "do not ascend"),
    ("WorldBegin\nAttributeBegin\nAttributeBegin\nAttributeEnd", 2, "AttributeBegin has no AttributeEnd"),
    ("WorldBegin\nAttributeEnd", 2, "AttributeEnd without AttributeBegin"),
    ("WorldBegin\nObjectBegin \"o\"\nAttributeEnd", 3, "AttributeEnd after the ObjectBegin of line 2"),
    ("WorldBegin\nObjectInstance \"o\"", 2, "no object `o` is defined"),
    ("Include \"t.pbrt\"\nWorldBegin", 1, "include each other"),
    ("Camera \"perspective\" \"float fov\" 190\nWorldBegin", 1, "\"fov\" is 190"),
    ("# nothing", 0, "no WorldBegin"),
];

#[test]
fn errors_name_their_place() {
    for (text, line, part) in BROKEN {
        let (loaded, _folder) = read_with_files(text, &[]);
        let error = loaded.expect_err(text);
        let message = error.to_string();
        assert!(message.contains(part), "{text:?}: {message}");
        if line > 0 {
            assert!(message.contains(&format!("t.pbrt:{line}: ")), "{text:?}: {message}");
        }
        assert!(!message.contains('\n') && message.len() < 600, "one line: {message}");
    }
}

#[test]
fn mutations_end() {
    let whole = "LookAt 0 1 5 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" [ 40 ]\nFilm \"rgb\" \"integer xresolution\" 9\n\
        WorldBegin\nTexture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ 1 0 0 ]\nAttributeBegin\nTranslate 1 2 3\n\
        Material \"coateddiffuse\" \"texture reflectance\" \"c\" \"float roughness\" .1\nShape \"loopsubdiv\" \"integer levels\" 1 \
        \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 ]\nAttributeEnd\nShape \"curve\" \"point3 P\" \
        [ 0 0 0 1 0 0 2 1 0 3 3 3 ]\nLightSource \"spot\" \"blackbody I\" 3000\n";
    let bytes = whole.as_bytes();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.pbrt");
    for at in (0..bytes.len()).step_by(3) {
        for with in [&b""[..], b"[", b"\"", b"9999999999", b"-", b"\xff"] {
            let mutated = [&bytes[..at], with, &bytes[at + 1..]].concat();
            // A new file: file systems write an overwritten one to the disk at once, in milliseconds.
            let _ = std::fs::remove_file(&path);
            std::fs::write(&path, mutated).expect("a file");
            if let Err(error) = load(&path) {
                assert!(!error.to_string().contains('\n'), "{error}");
            }
        }
    }
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}

#[test]
fn packed_files_are_read_and_bombs_are_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.pbrt.gz");
    std::fs::write(&path, packed(b"WorldBegin\nShape \"sphere\"\n")).expect("a file");
    assert_eq!(load(&path).expect("a scene").scene.meshes().len(), 1);
    let mut bomb = packed(b"WorldBegin\n");
    let spaces = packed(&vec![b' '; 64 << 20]);
    (0..16).for_each(|_| bomb.extend(&spaces));
    std::fs::write(&path, bomb).expect("a file");
    let error = load(&path).expect_err("a gigabyte of spaces").to_string();
    assert!(error.contains("more memory"), "{error}");
    std::fs::write(&path, &packed(b"WorldBegin\n")[..9]).expect("a file");
    let error = load(&path).expect_err("cut off").to_string();
    assert!(error.contains("gzip"), "{error}");
}

#[test]
fn what_is_lacking_is_told_once() {
    let text = "MakeNamedMedium \"fog\" \"string type\" \"cloud\"\nMediumInterface \"fog\" \"\"\n\
        Material \"measured\" \"string filename\" \"x.bsdf\"\nShape \"sphere\" \"float size\" 3\n";
    let expected = ["`cloud`", "\"measured\"", "\"float size\" of Shape"];
    let loaded = world_warned(text, &expected);
    let first = loaded.warnings.iter().next().map(ToString::to_string).unwrap_or_default();
    assert!(first.contains("t.pbrt:2: "), "{first}");
}

#[test]
fn files_include_others() {
    let text = "WorldBegin\nAttributeBegin\nInclude \"a.pbrt\"\nShape \"disk\"\nAttributeEnd\nImport \"b.pbrt\"\nShape \"disk\"\n";
    let files: [(&str, &[u8]); 2] = [
        ("a.pbrt", b"Translate 1 0 0\n"),
        ("b.pbrt", b"Translate 9 0 0\nShape \"disk\" \"float height\" 2\n"),
    ];
    let (loaded, _folder) = read_with_files(text, &files);
    let scene = loaded.expect("a scene").scene;
    let mut locations: Vec<f64> =
        scene.instances().iter().map(|i| i.world_from_object.columns[3][0].abs()).collect();
    locations.sort_by(f64::total_cmp);
    assert_eq!(locations, [0.0, 1.0, 9.0], "what is included goes on, what is imported ends");
    let (loaded, _folder) = read_with_files("WorldBegin\nInclude \"a.pbrt\"\n", &[("a.pbrt", b"\nFoo\n")]);
    let error = loaded.expect_err("wrong").to_string();
    assert!(error.contains("a.pbrt:2: "), "{error}");
    let (loaded, _folder) = read_with_files("WorldBegin\n\nInclude \"none.pbrt\"\n", &[]);
    let error = loaded.expect_err("missing").to_string();
    assert!(error.contains("t.pbrt:3: ") && error.contains("no such file"), "{error}");
}
