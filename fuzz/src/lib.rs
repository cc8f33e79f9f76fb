// SPDX-License-Identifier: GPL-3.0-or-later
//! Common parts of the fuzz targets: bytes become a file of some kind, which the loader reads. The tested
//! guarantee: a scene, or one error of one line; never a panic, a hang or excessive memory.

pub mod shaders;

use std::cell::RefCell;
use std::sync::Once;

use gnurt_scene::io::{Formats, LoadOptions};
use tempfile::TempDir;

/// The formats of all crates.
const FORMATS: Formats = gnurt_scene::io::FORMATS.with(&[
    &gnurt_gltf::TEXT,
    &gnurt_gltf::BINARY,
    &gnurt_pbrt::FORMAT,
    &gnurt_usd::FORMAT,
]);

thread_local! {
    static FOLDER: RefCell<TempDir> = RefCell::new(tempfile::tempdir().expect("a temporary folder"));
}

/// Lets decoders of pictures panic where that becomes an error: the fuzzer's own hook would end the run before anybody
/// catches them.
pub fn let_decoders_panic() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let end = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !gnurt_image::expects_panics() {
                end(panic);
            }
        }));
    });
}

/// Loads `bytes` as a scene file called `name`, beside the `companions` (name and contents).
pub fn load_scene(name: &str, bytes: &[u8], companions: &[(&str, &[u8])]) {
    let_decoders_panic();
    FOLDER.with_borrow(|folder| {
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).expect("the temporary folder takes files");
            path
        };
        companions.iter().for_each(|(name, bytes)| {
            write(name, bytes);
        });
        match FORMATS.load(write(name, bytes), &LoadOptions::default()) {
            Ok(loaded) => check(&loaded.scene),
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}"),
        }
    });
}

/// The output of a loader can be used without further checks.
fn check(scene: &gnurt_scene::Scene) {
    for mesh in scene.meshes() {
        let vertices = mesh.positions.len();
        assert!(
            mesh.indices.iter().flatten().all(|&i| (i as usize) < vertices),
            "an index of `{}` is out of range",
            mesh.name
        );
        for (what, length) in
            [("normals", mesh.normals.len()), ("texcoords", mesh.texcoords.len()), ("colors", mesh.colors.len())]
        {
            assert!(length == 0 || length == vertices, "{what} of `{}`: {length} of {vertices}", mesh.name);
        }
        assert!(mesh.material.index() < scene.materials().len(), "no such material");
    }
}
