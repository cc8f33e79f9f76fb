// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF 2.0, text and binary.
//! Source: Khronos, glTF 2.0 specification, and the extensions of `KNOWN_EXTENSIONS` (`document.rs`). A
//! warning names each other extension that a file uses.
//!
//! ```text
//! file -> container (JSON, binary chunk) -> Document (buffers) -> animations -> materials, meshes -> nodes: instances, cameras, lights
//!                                                                        \-> rig: what of them moves -> the scene's Animation
//! ```
//!
//! Every index is checked where it is used; unused elements are not read (see `json`). Each glTF mesh becomes
//! one object. Each node that shows it becomes one instance; where that repeats the mesh, the object holds
//! other objects. A mesh deformed by a skin or morph weights becomes an object of its own. The scene is read
//! in its rest pose. Space: +Y up, metres, as here. Tests: `tests/gltf.rs`.

mod accessor;
mod animation;
mod animation_json;
mod base64;
mod camera;
mod container;
mod decoded;
mod document;
mod draco;
mod factor_paths;
mod instancing;
mod json;
mod material;
mod mesh;
mod meshopt;
mod meshopt_filters;
mod nodes;
mod pointer;
mod primitive;
mod ranges;
mod rig;
mod save;
mod skin;
mod specular_glossiness;
mod variants;

use std::path::Path;

use document::Document;
use rig::Rig;

use gnurt_scene::Scene;
use gnurt_scene::io::reader::{self as source, Access};
use gnurt_scene::io::{Error, Format, Loaded, SceneWriter, Warnings};

/// The format of text files.
pub const TEXT: Format = Format {
    name: "glTF 2.0",
    extensions: &["gltf"],
    notes: "written without the environment",
    read: Some(|path, access| load(path, false, access)),
    read_whole: true,
    says_up: true,
    write: Some(SceneWriter {
        save: save::save_text,
        companions: |_, path| vec![save::buffer_file(path)],
        has_materials: true,
        has_animations: true,
        has_strands: false,
        is_whole: false,
    }),
};

/// The format of binary files.
pub const BINARY: Format = Format {
    name: "binary glTF 2.0",
    extensions: &["glb"],
    notes: "one file, with its textures; written without the environment",
    read: Some(|path, access| load(path, true, access)),
    read_whole: true,
    says_up: true,
    write: Some(SceneWriter {
        save: save::save_binary,
        companions: |_, _| Vec::new(),
        has_materials: true,
        has_animations: true,
        has_strands: false,
        is_whole: false,
    }),
};

/// Loads a glTF file and all that it refers to.
fn load(path: &Path, is_binary: bool, access: &Access) -> Result<Loaded, Error> {
    let bytes = source::read_by(path, access.threads())?;
    access.budget.add_file(bytes.len() as u64);
    let mut warnings = Warnings::default();
    let document = Document::new(path, &bytes, is_binary, access, &mut warnings)?;

    let mut scene = Scene::new();
    let drafts = animation::read(&document, &mut warnings)?;
    let materials =
        material::add_all(&document, |index| drafts.drives_material(index), &mut scene, &mut warnings)?;
    let rig = Rig::new(&document, drafts, materials.moving)?;
    nodes::add_all(&document, &materials.added, rig, &mut scene, &mut warnings)?;
    scene.labels_mut().outputs = document.root.outputs();
    let files = document.files();
    Ok(Loaded { scene, warnings, files })
}
