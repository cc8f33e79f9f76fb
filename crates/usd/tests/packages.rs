// SPDX-License-Identifier: GPL-3.0-or-later
//! Packages: layers and textures within, faults.

use std::io::Write;

use gnurt_scene::io::LoadOptions;

use crate::support::{Folder, warnings};

/// A zip archive of stored entries; `method`: how they say that they are packed.
fn archive(entries: &[(&str, &[u8])], method: u8) -> Vec<u8> {
    let (mut bytes, mut list) = (Vec::new(), Vec::new());
    for (name, data) in entries {
        let at = bytes.len() as u32;
        let common = |to: &mut Vec<u8>| {
            to.extend([20, 0, 0, 0, method, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
            for size in [data.len() as u32; 2] {
                to.extend(size.to_le_bytes());
            }
            to.extend([name.len() as u8, 0, 0, 0]);
        };
        bytes.extend(b"PK\x03\x04");
        common(&mut bytes);
        bytes.extend(name.as_bytes());
        bytes.write_all(data).expect("memory");
        list.extend(b"PK\x01\x02\x14\x00");
        common(&mut list);
        list.extend([0; 10]);
        list.extend(at.to_le_bytes());
        list.extend(name.as_bytes());
    }
    let at = bytes.len() as u32;
    bytes.extend(&list);
    bytes.extend(b"PK\x05\x06\x00\x00\x00\x00");
    for _ in 0..2 {
        bytes.extend((entries.len() as u16).to_le_bytes());
    }
    bytes.extend((list.len() as u32).to_le_bytes());
    bytes.extend(at.to_le_bytes());
    bytes.extend([0, 0]);
    bytes
}

const ROOT: &[u8] =
    b"#usda 1.0\n( metersPerUnit = 1 )\ndef \"A\" ( prepend references = @./parts/part.usda@</P> ) {}\n";
const PART: &[u8] = b"#usda 1.0\ndef Cube \"P\" {\n}\n";

fn load(bytes: &[u8]) -> Result<gnurt_scene::io::Loaded, String> {
    let folder = Folder::with(&[]);
    std::fs::write(folder.path("a.usdz"), bytes).expect("a file");
    folder.load("a.usdz", &LoadOptions::default()).map_err(|error| error.to_string())
}

#[test]
fn layers_within_find_each_other() {
    let loaded = load(&archive(&[("root.usda", ROOT), ("parts/part.usda", PART)], 0)).expect("a package");
    assert_eq!(warnings(&loaded), "");
    assert_eq!(loaded.scene.meshes().len(), 1, "the cube of the other layer");
}

#[test]
fn faults_are_told() {
    let faults = [
        (Vec::new(), "zip archive"),
        (b"#usda 1.0\n".to_vec(), "zip archive"),
        (archive(&[], 0), "no entries"),
        (archive(&[("a.png", b"x")], 0), "its first entry is 'a.png'"),
        (archive(&[("root.usda", ROOT)], 8), "compressed"),
        (archive(&[("root.usda", b"nonsense")], 0), "no USD layer"),
    ];
    for (bytes, expected) in faults {
        let error = load(&bytes).expect_err(expected);
        assert!(error.contains(expected) && error.contains("a.usdz"), "{error}; expected {expected}");
    }
    let mut cut = archive(&[("root.usda", ROOT)], 0);
    cut.drain(30..200.min(cut.len() - 80));
    assert!(load(&cut).is_err(), "a part is missing");
}
