// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF 2.0: objects as meshes, instances as nodes, cameras, lights, materials, animations; pictures inside the
//! buffer.
//! Source: glTF 2.0; KHR_lights_punctual and the extensions of `gltf/material.rs`. A file lists exactly the
//! extensions that it uses. The buffer of `.gltf` is the file NAME.bin, that of `.glb` is inside. Tests:
//! `tests/save.rs`.

mod animation;
mod buffer;
mod camera;
mod material;
mod mesh;
mod nodes;
mod opacity;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use buffer::Buffer;
use nodes::Nodes;
use opacity::BaseTexture;

use gnurt_scene::Scene;
use gnurt_scene::id::{MaterialId, TextureId};
use gnurt_scene::io::writer::{check_writable, encode_texture, leave_out, measures, write};
use gnurt_scene::io::{Error, Warnings};
use gnurt_scene::labels::Shining;
use gnurt_scene::material::TextureRef;

/// Writes a text file and its buffer.
pub(crate) fn save_text(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    save(scene, path, false, warnings)
}

/// Writes a binary file.
pub(crate) fn save_binary(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    save(scene, path, true, warnings)
}

fn save(scene: &Scene, path: &Path, is_binary: bool, warnings: &mut Warnings) -> Result<(), Error> {
    let scene = &shown(scene);
    let mut buffer = Buffer::default();
    let meshes: Vec<Value> = scene
        .objects()
        .iter()
        .filter(|object| mesh::shown_meshes(scene, object).next().is_some())
        .map(|object| mesh::mesh(scene, object, &mut buffer))
        .collect();
    let mut merged = Vec::new();
    let mut lost = 0;
    let materials: Vec<Value> = scene
        .materials()
        .iter()
        .zip(0..)
        .map(|(material, id)| {
            let mut made =
                material::material(material, |base| match opacity::base_texture(scene, material, base) {
                    BaseTexture::AsIs(texture) => texture,
                    BaseTexture::Lost(texture) => {
                        lost += 1;
                        texture
                    }
                    BaseTexture::Merged(texture, like) => {
                        let id = TextureId((scene.textures().len() + merged.len()) as u32);
                        merged.push(texture);
                        Some(TextureRef { texture: id, ..like })
                    }
                });
            nodes::put_into_group(&mut made, scene, Shining::Material(MaterialId(id)));
            made
        })
        .collect();
    leave_out(lost, "opacity under coordinates of its own", path, warnings);
    let bumps = scene.materials().iter().filter(|material| material.bump.is_some()).count();
    leave_out(bumps, "bump map", path, warnings);
    let bright = scene.materials().iter().filter(|material| material::is_too_bright(material)).count();
    leave_out(bright, "base colour above 1, cut off", path, warnings);
    let (mut images, mut samplers, mut textures) = (Vec::new(), Vec::new(), Vec::new());
    let measures = measures(scene);
    for (k, texture) in scene.textures().iter().chain(&merged).enumerate() {
        let is_measure = measures.contains(&TextureId(k as u32));
        let view = buffer.add_bytes(&encode_texture(&texture.texels, is_measure, path)?);
        images.push(json!({ "name": texture.name, "mimeType": "image/png", "bufferView": view }));
        samplers.push(material::sampler(texture));
        textures.push(json!({ "source": k, "sampler": k, "name": texture.name }));
    }
    let mut nodes = Nodes::new(scene, path, warnings)?;
    let matrices = |joints: &[[f32; 16]]| buffer.add_floats("MAT4", joints);
    let skins = scene.animation().map(|animation| nodes.skins(animation, matrices)).unwrap_or_default();
    let cameras: Vec<Value> = scene.cameras().iter().map(camera::camera).collect();

    let mut root = json!({});
    let mut put = |key: &str, values: Vec<Value>| {
        // Empty arrays are not allowed.
        if !values.is_empty() {
            root[key] = values.into();
        }
    };
    put("meshes", meshes);
    put("nodes", std::mem::take(&mut nodes.list));
    put("skins", skins);
    put("materials", materials);
    put("images", images);
    put("samplers", samplers);
    put("textures", textures);
    put("cameras", cameras);
    put(
        "scenes",
        vec![match nodes.roots.is_empty() {
            true => json!({}),
            false => json!({ "nodes": nodes.roots }),
        }],
    );
    root["scene"] = 0.into();
    root["asset"] = json!({ "version": "2.0", "generator": gnurt_image::SOFTWARE });
    let has_lights = !nodes.lights.is_empty();
    if has_lights {
        root["extensions"] = json!({ "KHR_lights_punctual": { "lights": nodes.lights } });
    }
    if let Some(animation) = scene.animation() {
        material::set_driven(animation, &mut root);
        let told = (path, warnings);
        let made = animation::animations(animation, &nodes, &mut root, &mut buffer, told);
        if !made.is_empty() {
            root["animations"] = made.into();
        }
    }
    for (key, values) in [("accessors", buffer.accessors), ("bufferViews", buffer.views)] {
        if !values.is_empty() {
            root[key] = values.into();
        }
    }
    let Value::Object(mut root) = root else { unreachable!("it is an object") };
    let mut used = BTreeSet::new();
    root.values().for_each(|value| note_extensions(value, &mut used));
    used.extend(has_lights.then(|| "KHR_lights_punctual".to_owned()));
    if !used.is_empty() {
        root.insert("extensionsUsed".into(), used.into_iter().collect());
    }
    write_files(root, &buffer.bytes, path, is_binary)
}

/// The scene with all instances that move, those that are hidden now, too: their nodes hide them.
fn shown(scene: &Scene) -> Scene {
    let mut shown = scene.clone();
    let moving: Vec<_> = scene.animation().iter().flat_map(|a| &a.instances).map(|m| m.instance).collect();
    moving.into_iter().for_each(|id| shown.edit_instance(id).visible = true);
    shown
}

/// The names of extensions anywhere in `value`.
fn note_extensions(value: &Value, used: &mut BTreeSet<String>) {
    match value {
        Value::Array(list) => list.iter().for_each(|value| note_extensions(value, used)),
        Value::Object(map) => {
            for (key, value) in map {
                if let ("extensions", Value::Object(named)) = (&key[..], value) {
                    used.extend(named.keys().cloned());
                }
                // The contents of `extras` are outside of glTF.
                if key != "extras" {
                    note_extensions(value, used);
                }
            }
        }
        _ => {}
    }
}

/// The buffer file of a text file.
pub(crate) fn buffer_file(path: &Path) -> PathBuf {
    path.with_extension("bin")
}

fn write_files(
    mut root: Map<String, Value>,
    bytes: &[u8],
    path: &Path,
    is_binary: bool,
) -> Result<(), Error> {
    if is_binary {
        if !bytes.is_empty() {
            root.insert("buffers".into(), json!([{ "byteLength": bytes.len() }]));
        }
        return write(path, &binary_file(Value::Object(root).to_string().into_bytes(), bytes, path)?);
    }
    if !bytes.is_empty() {
        let file = buffer_file(path);
        let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        root.insert("buffers".into(), json!([{ "byteLength": bytes.len(), "uri": percent_encode(&name) }]));
        check_writable(&[file.clone(), path.to_owned()])?;
        write(&file, bytes)?;
    }
    write(path, format!("{:#}\n", Value::Object(root)).as_bytes())
}

/// Header, JSON chunk padded with spaces, binary chunk padded with zeros.
fn binary_file(mut json: Vec<u8>, bytes: &[u8], path: &Path) -> Result<Vec<u8>, Error> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let binary = bytes.len().next_multiple_of(4);
    let length = 12 + 8 + json.len() + if binary > 0 { 8 + binary } else { 0 };
    let u32_bytes = |n: usize| u32::try_from(n).map(u32::to_le_bytes);
    let too_large = |_| Error::io(path, "more than 4 GiB", "a .gltf file may be larger");
    let mut file = Vec::with_capacity(length);
    file.extend(b"glTF\x02\0\0\0");
    file.extend(u32_bytes(length).map_err(too_large)?);
    file.extend(u32_bytes(json.len()).map_err(too_large)?);
    file.extend(b"JSON");
    file.extend(json);
    if binary > 0 {
        file.extend(u32_bytes(binary).map_err(too_large)?);
        file.extend(b"BIN\0");
        file.extend(bytes);
        file.resize(length, 0);
    }
    Ok(file)
}

fn percent_encode(name: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-_.~".contains(&b);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}
