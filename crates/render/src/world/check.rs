// SPDX-License-Identifier: GPL-3.0-or-later
//! Validity of all ids in edited parts of a scene. A scene never loses elements, so earlier parts stay valid;
//! only shader tables get shorter.
//! Tests: crates/render/tests/commit.rs.

use gnurt_scene::displacement::Offset;
use gnurt_scene::{Scene, Surface};

use super::dirty::DirtyParts;
use super::materials;
use super::table::ShaderTable;
use crate::error::CommitError;

pub(super) fn check(scene: &Scene, shaders: &ShaderTable, dirty: &DirtyParts) -> Result<(), CommitError> {
    let dangling =
        |what, index: u32, used, id| CommitError::DanglingId { what, index: index as usize, used, id };
    for &index in &dirty.instances {
        let object = scene.instances()[index as usize].object;
        if object.index() >= scene.objects().len() {
            return Err(dangling("instance", index, "object", object.0));
        }
    }
    if dirty.objects.iter().any(|&index| !scene.objects()[index as usize].members.is_empty()) {
        scene.levels()?;
    }
    for &index in &dirty.objects {
        let object = &scene.objects()[index as usize];
        if let Some(mesh) = object.meshes.iter().find(|mesh| mesh.index() >= scene.meshes().len()) {
            return Err(dangling("object", index, "mesh", mesh.0));
        }
    }
    for &index in &dirty.meshes {
        let material = scene.meshes()[index as usize].material;
        if material.index() >= scene.materials().len() {
            return Err(dangling("mesh", index, "material", material.0));
        }
    }
    for &index in &dirty.materials {
        let material = &scene.materials()[index as usize];
        if let Some(texture) = materials::textures_of(material).find(|t| t.index() >= scene.textures().len())
        {
            return Err(dangling("material", index, "texture", texture.0));
        }
        if let Surface::Shader(shader) = material.surface
            && shader as usize >= shaders.surfaces.len()
        {
            let known = shaders.surfaces.len();
            return Err(CommitError::UnknownShader { material: index as usize, shader, known });
        }
    }
    for (id, displacement) in scene.displacements() {
        if let Some(texture) = displacement.texture().filter(|t| t.texture.index() >= scene.textures().len())
        {
            return Err(dangling("displacement of material", id.0, "texture", texture.texture.0));
        }
        if let Offset::Shader(shader) = displacement.offset
            && shader as usize >= shaders.displacements.len()
        {
            let known = shaders.displacements.len();
            return Err(CommitError::UnknownDisplacement { material: id.index(), shader, known });
        }
    }
    for &index in &dirty.materials {
        let medium = scene.materials()[index as usize].medium;
        if let Some(medium) = medium.filter(|medium| medium.index() >= scene.media().len()) {
            return Err(dangling("material", index, "medium", medium.0));
        }
    }
    for &index in &dirty.media {
        if let Some(problem) = scene.media()[index as usize].problem() {
            return Err(CommitError::BadMedium { medium: index as usize, problem });
        }
    }
    for &index in &dirty.lights {
        if let Some(texture) = scene.lights()[index as usize].texture()
            && texture.index() >= scene.textures().len()
        {
            return Err(dangling("light", index, "texture", texture.0));
        }
    }
    Ok(())
}
