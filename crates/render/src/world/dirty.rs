// SPDX-License-Identifier: GPL-3.0-or-later
//! The dirty parts of a scene for a commit: its edits, and their dependents. Cost: the number of edits;
//! meshes and textures are searched for in all objects and materials.
//! Tests: crates/render/tests/{commit,edits}.rs.

use std::sync::Arc;

use gnurt_scene::displacement::Offset;
use gnurt_scene::edit::{Cursor, Edit};
use gnurt_scene::{Displacement, MaterialId, ObjectId, Scene};
use gnurt_shading::DisplacementShader;

use super::material_table::MaterialTable;
use super::materials;
use super::open::Open;
use super::table::ShaderTable;

/// Displacements at a commit, and their shaders; empty where nothing is displaced.
#[derive(Clone, Default)]
pub(super) struct Displaced {
    all: Vec<(MaterialId, Displacement)>,
    shaders: Vec<Arc<dyn DisplacementShader>>,
}

impl Displaced {
    pub(super) fn of(scene: &Scene, shaders: &ShaderTable) -> Self {
        let all: Vec<_> = scene.displacements().map(|(id, displacement)| (id, *displacement)).collect();
        let shaders = if all.is_empty() { Vec::new() } else { shaders.displacements.clone() };
        Self { all, shaders }
    }

    /// The shader of a displacement, if it has one.
    fn shader(&self, displacement: &Displacement) -> Option<&Arc<dyn DisplacementShader>> {
        match displacement.offset {
            Offset::Shader(number) => self.shaders.get(number as usize),
            _ => None,
        }
    }

    /// The displacement of a material.
    fn get(&self, material: MaterialId) -> Option<&Displacement> {
        self.all.iter().find(|(id, _)| *id == material).map(|(_, displacement)| displacement)
    }
}

/// Dirty ids, each list ascending.
#[derive(Debug, Default)]
pub(super) struct DirtyParts {
    pub(super) meshes: Vec<u32>,
    /// Those with an edited list, or an edited mesh.
    pub(super) objects: Vec<u32>,
    pub(super) instances: Vec<u32>,
    /// Edited ones, those with an edited texture, and those with a replaced shader.
    pub(super) materials: Vec<u32>,
    pub(super) textures: Vec<u32>,
    pub(super) lights: Vec<u32>,
    pub(super) media: Vec<u32>,
}

impl DirtyParts {
    /// All that there is.
    pub(super) fn everything(scene: &Scene) -> Self {
        let all = |count: usize| (0..count as u32).collect();
        Self {
            meshes: all(scene.meshes().len()),
            objects: all(scene.objects().len()),
            instances: all(scene.instances().len()),
            materials: all(scene.materials().len()),
            textures: all(scene.textures().len()),
            lights: all(scene.lights().len()),
            media: all(scene.media().len()),
        }
    }

    /// Parts that move during the open shutter, now or at the last commit.
    pub(super) fn open(&mut self, open: &Open) {
        for (list, more) in [(&mut self.objects, &open.objects), (&mut self.instances, &open.instances)] {
            list.extend(more);
            list.sort_unstable();
            list.dedup();
        }
    }

    /// Objects whose surfaces are displaced otherwise than at the last commit, in addition.
    pub(super) fn displaced(&mut self, before: &Displaced, scene: &Scene, shaders: &ShaderTable) {
        let now = Displaced::of(scene, shaders);
        if before.all.is_empty() && now.all.is_empty() {
            return;
        }
        let differs = |id: MaterialId| {
            let (was, is) = (before.get(id), now.get(id));
            let [was_by, is_by] = [(before, was), (&now, is)].map(|(all, one)| all.shader(one?));
            let is_same_shader = match (was_by, is_by) {
                (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                (None, None) => true,
                _ => false,
            };
            let texture = is.and_then(Displacement::texture);
            let is_edited = texture.is_some_and(|t| self.textures.binary_search(&t.texture.0).is_ok());
            was != is || !is_same_shader || is_edited
        };
        let ids = before.all.iter().chain(&now.all).map(|(id, _)| *id);
        let mut changed: Vec<MaterialId> = ids.filter(|&id| differs(id)).collect();
        changed.sort_unstable();
        if changed.is_empty() {
            return;
        }
        let has_one = |id: &u32| {
            let mut meshes = scene.objects()[*id as usize].meshes.iter();
            meshes.any(|mesh| {
                let mesh = scene.meshes().get(mesh.index());
                mesh.is_some_and(|mesh| changed.binary_search(&mesh.material).is_ok())
            })
        };
        self.objects.extend((0..scene.objects().len() as u32).filter(has_one));
        self.objects.sort_unstable();
        self.objects.dedup();
    }

    /// The edits since then, and their dependents.
    pub(super) fn since(cursor: Cursor, scene: &Scene, table: &MaterialTable, shaders: &ShaderTable) -> Self {
        let mut dirty = Self::default();
        for edit in scene.edits_since(cursor) {
            match edit {
                Edit::Mesh(id) => dirty.meshes.push(id.0),
                Edit::Object(id) => dirty.objects.push(id.0),
                Edit::Instance(id) => dirty.instances.push(id.0),
                Edit::Material(id) => dirty.materials.push(id.0),
                Edit::Texture(id) => dirty.textures.push(id.0),
                Edit::Light(id) => dirty.lights.push(id.0),
                Edit::Medium(id) => dirty.media.push(id.0),
                // A camera is passed to `render`.
                Edit::Camera(_) => {}
            }
        }
        for list in [&mut dirty.meshes, &mut dirty.textures, &mut dirty.instances, &mut dirty.lights] {
            list.sort_unstable();
        }
        if !dirty.meshes.is_empty() {
            let has_one = |id: ObjectId| {
                let mut meshes = scene.object(id).meshes.iter();
                meshes.any(|mesh| dirty.meshes.binary_search(&mesh.0).is_ok())
            };
            dirty.objects.extend((0..scene.objects().len() as u32).filter(|&id| has_one(ObjectId(id))));
        }
        if !dirty.textures.is_empty() {
            for (id, material) in (0..).zip(scene.materials()) {
                if materials::textures_of(material).any(|t| dirty.textures.binary_search(&t.0).is_ok()) {
                    dirty.materials.push(id);
                }
            }
        }
        dirty.materials.extend(table.swapped(shaders).map(|(material, _)| material));
        for list in [&mut dirty.objects, &mut dirty.materials] {
            list.sort_unstable();
            list.dedup();
        }
        dirty
    }
}
