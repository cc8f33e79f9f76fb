// SPDX-License-Identifier: GPL-3.0-or-later
//! Code shared by the tests of files.
#![allow(dead_code, reason = "every test program uses a part")]

use std::path::{Path, PathBuf};
use std::process::Command;

use gnurt_scene::Scene;
use gnurt_scene::io::{Error, Formats, LoadOptions, Loaded, Warnings};

/// The formats of the crate, and glTF.
pub(crate) const FORMATS: Formats = gnurt_scene::io::FORMATS.with(&[&gnurt_gltf::TEXT, &gnurt_gltf::BINARY]);

pub(crate) fn load(path: impl AsRef<Path>) -> Result<Loaded, Error> {
    FORMATS.load(path, &LoadOptions::default())
}

pub(crate) fn save(scene: &Scene, path: impl AsRef<Path>) -> Result<Warnings, Error> {
    FORMATS.save(scene, path)
}

/// Loads bytes as a file of this name in a folder of its own.
pub(crate) fn load_named(name: &str, bytes: &[u8]) -> Result<Loaded, Error> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    load(path)
}

/// A binary glTF file of a JSON text and a binary chunk.
pub(crate) fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", binary)] {
        if !chunk.is_empty() {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
    }
    let length = (file.len() as u32).to_le_bytes();
    file[8..12].copy_from_slice(&length);
    file
}

/// The benchmark scenes of these names, unpacked below a folder; `None`, and said, where they are absent.
pub(crate) fn unpacked(folder: &Path, names: &[&str]) -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes");
    if !source.join("unpack.py").exists() {
        eprintln!("SKIPPED: the benchmark scenes (../shared/scenes) are not here");
        return None;
    }
    let done = Command::new("python3").arg(source.join("unpack.py")).arg(folder).args(names).output();
    if !done.is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED: the benchmark scenes cannot be unpacked; is python3 there?");
        return None;
    }
    Some(folder.to_owned())
}
