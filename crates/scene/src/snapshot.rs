// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes as bytes, for other processes of the same version: all that a scene is, as it is.
//! Files of scenes lack some of it, and round numbers; these bytes are for messages and caches, not for archives.
//! Layout: a tag, the version, a CRC-32 of the rest; the number of bytes of the description; the description by `postcard`; the
//! texels of all pictures, each once, little-endian. Source: the layout is our own.
//! Invariant: a scene of bytes is equal to the one that they were made of, at rest, but for its identity and edit log.
//! Tests: `tests/snapshot.rs`.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use flate2::Crc;
use gnurt_image::{TexelData, Texels};
use serde::{Deserialize, Serialize};

use crate::animation::Animation;
use crate::displacement::Displacement;
use crate::id::{CameraId, MaterialId};
use crate::mesh::Mesh;
use crate::scene::{Instance, Object, Scene};
use crate::shader_file::ShaderFile;
use crate::texture::{Filter, Texture, Wrap};
use crate::{Camera, Labels, Light, Material, Medium};

const TAG: &[u8; 12] = b"gnurt scene\0";
/// Types of a description may change in each version.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Bytes that are no scene, or a scene that has no bytes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SnapshotError(String);

impl SnapshotError {
    fn new(problem: impl Into<String>) -> Self {
        Self(problem.into())
    }
}

/// A description without texels: lists of a scene are written, own ones are read.
#[derive(Serialize, Deserialize)]
struct Description<'a> {
    meshes: Cow<'a, [Arc<Mesh>]>,
    objects: Cow<'a, [Object]>,
    instances: Cow<'a, [Instance]>,
    materials: Cow<'a, [Material]>,
    lights: Cow<'a, [Light]>,
    media: Cow<'a, [Medium]>,
    cameras: Cow<'a, [Camera]>,
    animation: Option<Cow<'a, Animation>>,
    labels: Cow<'a, Labels>,
    shader_files: Vec<(MaterialId, ShaderFile)>,
    displacements: Vec<(MaterialId, Displacement)>,
    camera_files: Vec<(CameraId, ShaderFile)>,
    textures: Vec<StoredTexture>,
    /// The numbers of further pictures.
    more: Vec<u32>,
    pictures: Vec<StoredPicture>,
}

/// A texture with the number of its picture.
#[derive(Serialize, Deserialize)]
struct StoredTexture {
    name: String,
    picture: u32,
    wrap: [Wrap; 2],
    filter: Filter,
}

/// The size and the form of texels.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct StoredPicture {
    width: u32,
    height: u32,
    form: Form,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
enum Form {
    Srgb8,
    Linear8,
    Linear16,
    Float,
}

impl StoredPicture {
    /// How many bytes its texels are; `None` if they are too many, or none.
    fn bytes(self) -> Option<usize> {
        let texel = match self.form {
            Form::Srgb8 | Form::Linear8 => 4,
            Form::Linear16 => 8,
            Form::Float => 16,
        };
        let texels = (self.width as usize).checked_mul(self.height as usize).filter(|&texels| texels > 0)?;
        texels.checked_mul(texel)
    }

    fn texels(self, bytes: &[u8]) -> Texels {
        let floats = |[r, g, b, a]: [[u8; 4]; 4]| [r, g, b, a].map(f32::from_le_bytes);
        let numbers = |[r, g, b, a]: [[u8; 2]; 4]| [r, g, b, a].map(u16::from_le_bytes);
        let data = match self.form {
            Form::Srgb8 => TexelData::Srgb8(bytes.as_chunks().0.to_vec()),
            Form::Linear8 => TexelData::Linear8(bytes.as_chunks().0.to_vec()),
            Form::Linear16 => {
                TexelData::Linear16(bytes.as_chunks().0.as_chunks().0.iter().copied().map(numbers).collect())
            }
            Form::Float => {
                TexelData::Float(bytes.as_chunks().0.as_chunks().0.iter().copied().map(floats).collect())
            }
        };
        Texels { width: self.width, height: self.height, data }
    }
}

/// Appends the texels of a picture in memory.
fn push_texels(to: &mut Vec<u8>, texels: &Texels) -> StoredPicture {
    let form = match &texels.data {
        TexelData::Srgb8(all) => {
            to.extend_from_slice(all.as_flattened());
            Form::Srgb8
        }
        TexelData::Linear8(all) => {
            to.extend_from_slice(all.as_flattened());
            Form::Linear8
        }
        TexelData::Linear16(all) => {
            all.as_flattened().iter().for_each(|number| to.extend_from_slice(&number.to_le_bytes()));
            Form::Linear16
        }
        TexelData::Float(all) => {
            all.as_flattened().iter().for_each(|number| to.extend_from_slice(&number.to_le_bytes()));
            Form::Float
        }
        TexelData::Tiled(_) => return push_texels(to, &texels.clone().resident()),
    };
    StoredPicture { width: texels.width, height: texels.height, form }
}

/// Pictures by numbers, each once, and their texels.
#[derive(Default)]
struct Pictures {
    numbers: HashMap<*const Texels, u32>,
    stored: Vec<StoredPicture>,
    texels: Vec<u8>,
}

impl Pictures {
    fn number(&mut self, texels: &Arc<Texels>) -> u32 {
        let next = self.stored.len() as u32;
        let number = *self.numbers.entry(Arc::as_ptr(texels)).or_insert(next);
        if number == next {
            self.stored.push(push_texels(&mut self.texels, texels));
        }
        number
    }
}

/// The bytes of a scene at rest, and of further pictures, which its shaders may read.
///
/// # Errors
/// The scene is inconsistent ([`Scene::check`]), or names a file whose name is not UTF-8.
pub fn to_bytes(scene: &Scene, more: &[Arc<Texels>]) -> Result<Vec<u8>, SnapshotError> {
    scene.check().map_err(|fault| SnapshotError::new(fault.to_string()))?;
    let mut at_rest = scene.clone();
    if at_rest.playback().is_begun {
        at_rest.rest();
    }
    let scene = &at_rest;
    let mut pictures = Pictures::default();
    let textures = scene.textures().iter().map(|texture| {
        let Texture { name, texels, wrap, filter } = texture;
        let picture = pictures.number(texels);
        StoredTexture { name: name.clone(), picture, wrap: *wrap, filter: *filter }
    });
    let textures = textures.collect();
    let more = more.iter().map(|texels| pictures.number(texels)).collect();
    let cameras = (0..scene.cameras().len()).map(|number| CameraId(number as u32));
    let description = Description {
        meshes: scene.meshes().into(),
        objects: scene.objects().into(),
        instances: scene.instances().into(),
        materials: scene.materials().into(),
        lights: scene.lights().into(),
        media: scene.media().into(),
        cameras: scene.cameras().into(),
        animation: scene.animation().map(Cow::Borrowed),
        labels: Cow::Borrowed(scene.labels()),
        shader_files: scene.shader_files().map(|(id, file)| (id, file.clone())).collect(),
        displacements: scene.displacements().map(|(id, displacement)| (id, *displacement)).collect(),
        camera_files: cameras.filter_map(|id| Some((id, scene.camera_file(id)?.clone()))).collect(),
        textures,
        more,
        pictures: pictures.stored,
    };
    let described = postcard::to_allocvec(&description)
        .map_err(|why| SnapshotError::new(format!("the scene has no bytes: {why}")))?;
    let mut bytes = TAG.to_vec();
    bytes.push(VERSION.len() as u8);
    bytes.extend_from_slice(VERSION.as_bytes());
    bytes.extend_from_slice(&sum(&[&described, &pictures.texels]).to_le_bytes());
    bytes.extend_from_slice(&(described.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&described);
    bytes.extend_from_slice(&pictures.texels);
    Ok(bytes)
}

/// The scene of bytes, and the further pictures in their order.
///
/// # Errors
/// The bytes are no scene's, are damaged, or were made by another version.
pub fn from_bytes(bytes: &[u8]) -> Result<(Scene, Vec<Arc<Texels>>), SnapshotError> {
    let damaged = || SnapshotError::new("the bytes of a scene are damaged");
    let Some(rest) = bytes.strip_prefix(TAG) else {
        return Err(SnapshotError::new("these are no bytes of a scene"));
    };
    let (&length, rest) = rest.split_first().ok_or_else(damaged)?;
    let (version, rest) = rest.split_at_checked(length.into()).ok_or_else(damaged)?;
    if version != VERSION.as_bytes() {
        let version = String::from_utf8_lossy(version);
        return Err(SnapshotError::new(format!(
            "the bytes of a scene are of version {version}; this is {VERSION}: send scenes between equal versions"
        )));
    }
    let (&expected, rest) = rest.split_first_chunk().ok_or_else(damaged)?;
    let (&length, rest) = rest.split_first_chunk().ok_or_else(damaged)?;
    let length = usize::try_from(u64::from_le_bytes(length)).map_err(|_| damaged())?;
    let (described, mut texels) = rest.split_at_checked(length).ok_or_else(damaged)?;
    if sum(&[described, texels]) != u32::from_le_bytes(expected) {
        return Err(damaged());
    }
    let description: Description = postcard::from_bytes(described).map_err(|_| damaged())?;
    let mut pictures = Vec::new();
    for picture in &description.pictures {
        let length = picture.bytes().ok_or_else(damaged)?;
        let (own, rest) = texels.split_at_checked(length).ok_or_else(damaged)?;
        texels = rest;
        pictures.push(Arc::new(picture.texels(own)));
    }
    let picture = |number: u32| pictures.get(number as usize).cloned().ok_or_else(damaged);
    let more = description.more.iter().map(|&number| picture(number)).collect::<Result<_, _>>()?;
    let mut scene = Scene::new();
    for StoredTexture { name, picture: number, wrap, filter } in &description.textures {
        let (name, texels) = (name.clone(), picture(*number)?);
        scene.add_texture(Texture { name, texels, wrap: *wrap, filter: *filter });
    }
    fill(&mut scene, description)?;
    scene.check().map_err(|fault| SnapshotError::new(fault.to_string()))?;
    Ok((scene, more))
}

/// Adds all but the textures.
fn fill(scene: &mut Scene, description: Description) -> Result<(), SnapshotError> {
    for mesh in description.meshes.into_owned() {
        scene.add_mesh(mesh);
    }
    for object in description.objects.into_owned() {
        scene.add_object(object);
    }
    for instance in description.instances.into_owned() {
        scene.add_instance(instance);
    }
    for material in description.materials.into_owned() {
        scene.add_material(material);
    }
    for light in description.lights.into_owned() {
        scene.add_light(light);
    }
    for medium in description.media.into_owned() {
        scene.add_medium(medium);
    }
    for camera in description.cameras.into_owned() {
        scene.add_camera(camera);
    }
    *scene.labels_mut() = description.labels.into_owned();
    // The edit log grows to the highest number that it is given.
    let (materials, cameras) = (scene.materials().len(), scene.cameras().len());
    for (id, file) in description.shader_files.into_iter().filter(|(id, _)| id.index() < materials) {
        scene.set_shader_file(id, file);
    }
    for (id, displacement) in description.displacements.into_iter().filter(|(id, _)| id.index() < materials) {
        scene.set_displacement(id, Some(displacement));
    }
    for (id, file) in description.camera_files.into_iter().filter(|(id, _)| id.index() < cameras) {
        scene.set_camera_file(id, file);
    }
    match description.animation {
        None => Ok(()),
        Some(animation) => {
            scene.animate(animation.into_owned()).map_err(|why| SnapshotError::new(why.to_string()))
        }
    }
}

fn sum(parts: &[&[u8]]) -> u32 {
    let mut crc = Crc::new();
    parts.iter().for_each(|part| crc.update(part));
    crc.sum()
}
