// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF 2.0: objects as meshes, instances as nodes, cameras, lights, materials, pictures inside the buffer.
//! Source: glTF 2.0; KHR_lights_punctual and the extensions of `gltf/material.rs`. A file lists exactly the
//! extensions that it uses. The buffer of `.gltf` is the file NAME.bin, that of `.glb` is inside. Tests:
//! `tests/save.rs`.

mod buffer;
mod camera;
mod material;
mod opacity;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use buffer::Buffer;
use opacity::BaseTexture;

use super::files::{check_writable, leave_out, write};
use super::png;
use crate::affine::Affine;
use crate::camera::Camera;
use crate::id::TextureId;
use crate::io::{Error, Warnings};
use crate::light::Light;
use crate::material::TextureRef;
use crate::mesh::Mesh;
use crate::motion::Motion;
use crate::ray_mask::RayMask;
use crate::scene::{Object, Scene};

/// Writes a text file and its buffer.
pub(in crate::io) fn save_text(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    save(scene, path, false, warnings)
}

/// Writes a binary file.
pub(in crate::io) fn save_binary(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    save(scene, path, true, warnings)
}

fn save(scene: &Scene, path: &Path, is_binary: bool, warnings: &mut Warnings) -> Result<(), Error> {
    let mut buffer = Buffer::default();
    let meshes: Vec<Value> = scene
        .objects()
        .iter()
        .filter(|object| is_mesh(scene, object))
        .map(|object| {
            let shown = shown_meshes(scene, object);
            let primitives = shown.map(|mesh| primitive(mesh, &mut buffer));
            let mut mesh = json!({ "name": object.name, "primitives": primitives.collect::<Vec<_>>() });
            if object.motion != Motion::Auto {
                mesh["extras"] = json!({ "gnurt_motion": object.motion.to_string() });
            }
            mesh
        })
        .collect();
    let mut merged = Vec::new();
    let mut lost = 0;
    let materials: Vec<Value> = scene
        .materials()
        .iter()
        .map(|material| {
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
            })
        })
        .collect();
    leave_out(lost, "opacity under coordinates of its own", path, warnings);
    let bumps = scene.materials().iter().filter(|material| material.bump.is_some()).count();
    leave_out(bumps, "bump map", path, warnings);
    let bright = scene.materials().iter().filter(|material| material::is_too_bright(material)).count();
    leave_out(bright, "base colour above 1, cut off", path, warnings);
    let (mut images, mut samplers, mut textures) = (Vec::new(), Vec::new(), Vec::new());
    let measures = png::measures(scene);
    for (k, texture) in scene.textures().iter().chain(&merged).enumerate() {
        let is_measure = measures.contains(&TextureId(k as u32));
        let view = buffer.add_bytes(&png::encode(&texture.texels, is_measure, path)?);
        images.push(json!({ "name": texture.name, "mimeType": "image/png", "bufferView": view }));
        samplers.push(material::sampler(texture));
        textures.push(json!({ "source": k, "sampler": k, "name": texture.name }));
    }
    let (mut nodes, mut roots, lights) = nodes(scene, path, warnings)?;
    let cameras: Vec<Value> = scene.cameras().iter().map(camera::camera).collect();
    for (k, camera) in scene.cameras().iter().enumerate() {
        if let Some(matrix) = camera_matrix(camera) {
            roots.push(nodes.len());
            nodes.push(json!({ "name": camera.name, "camera": k, "matrix": matrix.to_column_major() }));
        }
    }

    let mut root = Map::new();
    let mut put = |key: &str, values: Vec<Value>| {
        // Empty arrays are not allowed.
        if !values.is_empty() {
            root.insert(key.to_owned(), values.into());
        }
    };
    put("meshes", meshes);
    put("nodes", nodes);
    put("materials", materials);
    put("images", images);
    put("samplers", samplers);
    put("textures", textures);
    put("cameras", cameras);
    put("accessors", std::mem::take(&mut buffer.accessors));
    put("bufferViews", std::mem::take(&mut buffer.views));
    put("scenes", vec![json!({ "nodes": roots })]);
    root.insert("scene".into(), 0.into());
    root.insert("asset".into(), json!({ "version": "2.0", "generator": gnurt_image::SOFTWARE }));
    if !lights.is_empty() {
        root.insert("extensions".into(), json!({ "KHR_lights_punctual": { "lights": lights } }));
    }
    let mut used = BTreeSet::new();
    root.values().for_each(|value| note_extensions(value, &mut used));
    used.extend(root.contains_key("extensions").then(|| "KHR_lights_punctual".to_owned()));
    if !used.is_empty() {
        root.insert("extensionsUsed".into(), used.into_iter().collect());
    }
    write_files(root, &buffer.bytes, path, is_binary)
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
pub(in crate::io) fn buffer_file(path: &Path) -> PathBuf {
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

fn primitive(mesh: &Mesh, buffer: &mut Buffer) -> Value {
    let mut attributes = Map::new();
    attributes.insert("POSITION".into(), buffer.add_positions(&mesh.positions).into());
    if !mesh.normals.is_empty() {
        attributes.insert("NORMAL".into(), buffer.add_floats("VEC3", &mesh.normals).into());
    }
    if !mesh.texcoords.is_empty() {
        let down: Vec<_> = mesh.texcoords.iter().map(|[u, v]| [*u, 1.0 - v]).collect();
        attributes.insert("TEXCOORD_0".into(), buffer.add_floats("VEC2", &down).into());
    }
    let second: Vec<_> = mesh.second_texcoords().chunks_exact(2).map(|uv| [uv[0], 1.0 - uv[1]]).collect();
    if !second.is_empty() {
        attributes.insert("TEXCOORD_1".into(), buffer.add_floats("VEC2", &second).into());
    }
    if !mesh.tangents.is_empty() && !mesh.normals.is_empty() {
        let unit: Vec<_> = mesh.tangents.iter().map(unit_tangent).collect();
        attributes.insert("TANGENT".into(), buffer.add_floats("VEC4", &unit).into());
    }
    if !mesh.colors.is_empty() {
        attributes.insert("COLOR_0".into(), buffer.add_floats("VEC4", &mesh.colors).into());
    }
    json!({ "attributes": attributes, "indices": buffer.add_indices(&mesh.indices), "material": mesh.material.0 })
}

/// As glTF requires: unit, and the fourth number 1 or -1. A zero tangent stays zero.
fn unit_tangent(&[x, y, z, side]: &[f32; 4]) -> [f32; 4] {
    let [x, y, z] = glam::Vec3::new(x, y, z).normalize_or_zero().to_array();
    [x, y, z, 1.0_f32.copysign(side)]
}

/// The meshes of an object that have triangles: glTF allows none without.
fn shown_meshes<'a>(scene: &'a Scene, object: &'a Object) -> impl Iterator<Item = &'a Mesh> {
    object.meshes.iter().map(|&id| scene.mesh(id)).filter(|mesh| !mesh.indices.is_empty())
}

/// Whether an object becomes a mesh: an object without meshes has nodes only.
fn is_mesh(scene: &Scene, object: &Object) -> bool {
    shown_meshes(scene, object).next().is_some()
}

/// Nodes for objects in objects, unfolded, that a file may have.
const MOST_NODES: usize = 1 << 24;

/// Nodes of instances and lights, which of them are roots, and the lights.
type Nodes = (Vec<Value>, Vec<usize>, Vec<Value>);

fn nodes(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<Nodes, Error> {
    let (mut nodes, mut roots) = (Vec::new(), Vec::new());
    let mut next = 0..;
    let numbers: Vec<Option<usize>> = scene
        .objects()
        .iter()
        .map(|object| if is_mesh(scene, object) { next.next() } else { None })
        .collect();
    // Path from the root: the number of its nodes, and their indices.
    let mut stack: Vec<usize> = Vec::new();
    for found in scene.occurrences() {
        if nodes.len() >= MOST_NODES {
            let problem = format!("more than {MOST_NODES} nodes, with objects in objects unfolded");
            return Err(Error::io(path, problem, "glTF has a node for each; leave some out"));
        }
        stack.truncate(found.depth);
        let matrix = found.parent_from_object.to_column_major();
        let mut node = json!({ "name": found.name, "matrix": matrix });
        if let Some(number) = numbers[found.object_id.index()] {
            node["mesh"] = number.into();
            if found.mask != RayMask::ALL {
                node["extras"] = json!({ "mask": found.mask.0 });
            }
        }
        let node_index = nodes.len();
        match stack.last() {
            None => roots.push(node_index),
            Some(&parent) => {
                let parent: &mut Value = &mut nodes[parent];
                match parent["children"].as_array_mut() {
                    Some(children) => children.push(node_index.into()),
                    None => parent["children"] = json!([node_index]),
                }
            }
        }
        nodes.push(node);
        stack.push(node_index);
    }
    let mut lights = Vec::new();
    for light in scene.lights() {
        let (described, node_index) = match light {
            Light::Point { position, intensity } => {
                (punctual("point", *intensity), at(*position, [0.0, 0.0, -1.0]))
            }
            Light::Directional { direction, irradiance } => {
                (punctual("directional", *irradiance), at([0.0; 3], *direction))
            }
            Light::Spot { position, direction, intensity, inner_angle, outer_angle } => {
                let mut spot = punctual("spot", *intensity);
                spot["spot"] = json!({ "innerConeAngle": inner_angle, "outerConeAngle": outer_angle });
                (spot, at(*position, *direction))
            }
            Light::Environment { .. } | Light::Backdrop { .. } => {
                leave_out(1, "environment light", path, warnings);
                continue;
            }
        };
        let extension = json!({ "KHR_lights_punctual": { "light": lights.len() } });
        roots.push(nodes.len());
        nodes.push(json!({ "matrix": node_index.to_column_major(), "extensions": extension }));
        lights.push(described);
    }
    Ok((nodes, roots, lights))
}

fn punctual(kind: &str, color: [f32; 3]) -> Value {
    let intensity = color.iter().copied().fold(0.0, f32::max);
    let color = if intensity > 0.0 { color.map(|c| c / intensity) } else { [1.0; 3] };
    json!({ "type": kind, "intensity": intensity, "color": color })
}

/// The frame at `position` that faces `direction`.
fn at(position: [f32; 3], direction: [f32; 3]) -> Affine {
    let target = [0, 1, 2].map(|k| position[k] + direction[k]);
    let view = Camera {
        name: String::new(),
        eye: position,
        target,
        up: [0.0, 1.0, 0.0],
        fov_y: 45.0,
        ..Camera::default()
    };
    camera_matrix(&view).unwrap_or_else(|| Affine::translation(position.map(f64::from)))
}

fn camera_matrix(camera: &Camera) -> Option<Affine> {
    let frame = camera.frame()?;
    let back = frame.forward.map(|x| -x);
    Some(Affine { columns: [frame.right, frame.up, back, camera.eye].map(|column| column.map(f64::from)) })
}
