// SPDX-License-Identifier: GPL-3.0-or-later
//! What the fuzz targets share: bytes become a file of some kind, and the loader is asked for it.
//! The promise under test: a scene, or one error of one line; never a panic, a hang or a great deal of memory.

pub mod shaders;

use std::cell::RefCell;
use std::sync::Once;

use tempfile::TempDir;

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
    load_scene_of(gnurt_scene::io::FORMATS, name, bytes, companions);
}

/// Loads `bytes` as a USD file called `name`.
pub fn load_usd(name: &str, bytes: &[u8]) {
    load_scene_of(gnurt_scene::io::Formats::new(&[&gnurt_usd::FORMAT]), name, bytes, &[]);
}

fn load_scene_of(formats: gnurt_scene::io::Formats, name: &str, bytes: &[u8], companions: &[(&str, &[u8])]) {
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
        match formats.load(write(name, bytes), &gnurt_scene::io::LoadOptions::default()) {
            Ok(loaded) => check(&loaded.scene),
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}"),
        }
    });
}

/// What comes out of a loader may be used without further care.
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
