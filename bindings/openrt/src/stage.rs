// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene and the world that frames render, brought up to date with the program's objects when a frame starts.
//! The stage belongs to the frame in flight; the program edits its own description meanwhile.
//! Only the program's changes are processed, so that a commit finds no other edits. Invariants: an instance
//! keeps its index in the scene while it is shown. An unused mesh, object or instance of the scene is empty
//! or invisible and is reused, the first index first. So a program that redefines objects for ever takes no
//! more memory than its largest frame, and repeated contents keep their indices.
//! Tests: `tests`, `calls::tests`; tests/c/scene.c.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gnurt::render::{Accumulation, CommitReport, ShaderTable, World};
use gnurt::scene::{
    Affine, Attribute, Instance, InstanceId, Material, MaterialId, Member, Mesh, MeshId, Object, ObjectId,
    RayMask, Scene, Surface, TEXCOORD_RQ,
};
use gnurt::shading::SurfaceShader;
use gnurt::shading::classes::{Shader as RenderShader, Value, Values};
use gnurt_plugins::host::PluginFrame;

use crate::state::geometry::ShaderMesh;
use crate::state::ids::RT_INVALID;
use crate::state::shader::Shaders;
use crate::state::texture::Textures;

/// The id under which geometry outside of objects is staged; no object has it.
pub(crate) const UNNAMED: u32 = 0;

/// Scene and world, and the indices in use.
#[derive(Default)]
pub(crate) struct Stage {
    /// The scene that the renderer reads.
    pub(crate) scene: Scene,
    /// The world that rays traverse.
    pub(crate) world: World,
    /// The samples of the last frame.
    pub(crate) accumulation: Option<Accumulation>,
    /// Their means, from the top row on: memory that frames use again.
    pub(crate) colors: Vec<[f32; 4]>,
    /// Work of the last frame's commit.
    pub(crate) report: CommitReport,
    objects: BTreeMap<u32, ObjectId>,
    /// By id, those that are visible; `RT_INVALID` for geometry outside of objects.
    instances: BTreeMap<u32, InstanceId>,
    /// Whether all existing instances have been checked.
    knows_instances: bool,
    /// Objects that came or went since instances were checked: those that show them are shown or hidden.
    renewed: bool,
    free_instances: BTreeSet<InstanceId>,
    free_objects: Vec<ObjectId>,
    free_meshes: Vec<MeshId>,
    /// Number of each shader in the shader table, which is also that of its material.
    shader_slots: BTreeMap<u32, u32>,
    free_slots: Vec<u32>,
    /// The surface of triangles without a shader.
    no_shader: Option<Arc<dyn SurfaceShader>>,
}

/// An instance as the program has it, or an object within another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown {
    /// The object's id.
    pub(crate) object: u32,
    /// Of an object within another: to that.
    pub(crate) world_from_object: Affine,
    pub(crate) mask: RayMask,
}

impl Stage {
    /// Gives an object new meshes, and objects in it.
    pub(crate) fn define(&mut self, id: u32, meshes: Vec<ShaderMesh>, nested: impl Iterator<Item = Shown>) {
        let object = self.object(id);
        self.release_meshes(object);
        let meshes = meshes.into_iter().map(|ShaderMesh { shader, mesh }| {
            let material = self.material(shader);
            self.place_mesh(Mesh { material, ..mesh })
        });
        let meshes = meshes.collect();
        // An undefined object exists and is empty.
        let member = |shown: Shown| Member {
            object: self.object(shown.object),
            object_from_member: shown.world_from_object,
            mask: shown.mask,
        };
        let members = nested.map(member).collect();
        let object = self.scene.edit_object(object);
        (object.meshes, object.members) = (meshes, members);
    }

    /// Frees an object, if it is there.
    pub(crate) fn free_object(&mut self, id: u32) {
        if let Some(object) = self.objects.remove(&id) {
            self.renewed = true;
            self.release_meshes(object);
            self.scene.edit_object(object).members.clear();
            self.free_objects.push(object);
        }
    }

    /// Updates the instances of `changed`: their contents, `None` for a removed one. Those of objects without
    /// a definition show nothing. `all` are processed if this stage is new, or if the set of defined objects
    /// has changed.
    pub(crate) fn show(
        &mut self,
        changed: impl Iterator<Item = (u32, Option<Shown>)>,
        all: impl Iterator<Item = (u32, Shown)>,
    ) {
        if !self.knows_instances || self.renewed {
            return self.show_all(all);
        }
        let changed: Vec<_> = changed.collect();
        // Numbers of those that are gone are free for new ones.
        for (id, expected) in &changed {
            let is_shown = expected.is_some_and(|shown| self.objects.contains_key(&shown.object));
            if !is_shown {
                self.hide(*id);
            }
        }
        for (id, expected) in changed {
            if let Some(shown) = expected {
                self.show_one(id, shown);
            }
        }
    }

    /// Makes exactly these instances visible.
    pub(crate) fn show_all(&mut self, all: impl Iterator<Item = (u32, Shown)>) {
        (self.knows_instances, self.renewed) = (true, false);
        let all: Vec<_> = all.filter(|(_, shown)| self.objects.contains_key(&shown.object)).collect();
        let stay: BTreeSet<u32> = all.iter().map(|&(id, _)| id).collect();
        let mut gone = Vec::new();
        self.instances.retain(|&id, slot| {
            let stays = id == RT_INVALID || stay.contains(&id);
            if !stays {
                gone.push(*slot);
            }
            stays
        });
        self.free_instances.extend(gone.iter().copied());
        for (id, shown) in all {
            self.show_one(id, shown);
        }
        for slot in gone {
            self.hide_if_free(slot);
        }
    }

    /// Shows geometry outside of objects, or hides it.
    pub(crate) fn show_unnamed(&mut self, is_there: bool) {
        if is_there {
            let (object, world_from_object) = (UNNAMED, Affine::IDENTITY);
            self.show_one(RT_INVALID, Shown { object, world_from_object, mask: RayMask::ALL });
        } else {
            self.hide(RT_INVALID);
        }
    }

    fn show_one(&mut self, id: u32, Shown { object, world_from_object, mask }: Shown) {
        let Some(&object) = self.objects.get(&object) else { return };
        let expected = Instance { name: String::new(), object, world_from_object, visible: true, mask };
        let slot = self.instances.get(&id).copied().or_else(|| self.free_instances.pop_first());
        let slot = match slot {
            Some(slot) => {
                if *self.scene.instance(slot) != expected {
                    *self.scene.edit_instance(slot) = expected;
                }
                slot
            }
            None => self.scene.add_instance(expected),
        };
        self.instances.insert(id, slot);
    }

    fn hide(&mut self, id: u32) {
        if let Some(slot) = self.instances.remove(&id) {
            self.free_instances.insert(slot);
            self.hide_if_free(slot);
        }
    }

    fn hide_if_free(&mut self, slot: InstanceId) {
        if self.free_instances.contains(&slot) && self.scene.instance(slot).visible {
            self.scene.edit_instance(slot).visible = false;
        }
    }

    /// Ids of the shaders of all meshes.
    pub(crate) fn shader_ids(&self) -> impl Iterator<Item = u32> + '_ {
        self.shader_slots.keys().copied()
    }

    /// Whether a mesh has third texture coordinates, or divisors.
    pub(crate) fn has_third_texcoords(&self) -> bool {
        let is_it = |attribute: &Attribute| attribute.name == TEXCOORD_RQ;
        self.scene.meshes().iter().any(|mesh| mesh.attributes.iter().any(is_it))
    }

    /// The scene's numbers of the instances that are shown, and their ids.
    pub(crate) fn places(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        self.instances.iter().map(|(&id, slot)| (slot.index(), id))
    }

    /// The surface shaders with their present values, each at its number; mid-grey where one cannot take part in the
    /// frame. Frees the numbers of removed ones.
    pub(crate) fn surfaces(
        &mut self,
        shaders: &mut Shaders,
        textures: &Textures,
        plugins: &PluginFrame,
    ) -> ShaderTable {
        let is_alive = |id: u32| shaders.in_use(id).is_some();
        let gone = self.shader_slots.iter().filter(|&(&id, _)| !is_alive(id));
        self.free_slots.extend(gone.map(|(_, &slot)| slot));
        self.shader_slots.retain(|&id, _| is_alive(id));
        let by_slot: BTreeMap<u32, u32> = self.shader_slots.iter().map(|(&id, &slot)| (slot, id)).collect();
        let no_shader = self.no_shader.get_or_insert_with(|| {
            let constant = gnurt::shading::classes::find("ConstantShader").expect("a built-in class");
            surface(constant.make(&Values(vec![Value::Floats(vec![0.5; 3])]))).expect("it is of surfaces")
        });
        let mut made = |slot: u32| {
            let id = *by_slot.get(&slot)?;
            surface(shaders.in_use_mut(id)?.make(id, textures, plugins)?)
        };
        let slot_count = self.scene.materials().len() as u32;
        ShaderTable {
            surfaces: (0..slot_count).map(|slot| made(slot).unwrap_or_else(|| no_shader.clone())).collect(),
            ..Default::default()
        }
    }

    /// The scene's object of an id.
    fn object(&mut self, id: u32) -> ObjectId {
        let (scene, free, renewed) = (&mut self.scene, &mut self.free_objects, &mut self.renewed);
        let fresh = || {
            *renewed = true;
            free.pop().unwrap_or_else(|| scene.add_object(Object::default()))
        };
        *self.objects.entry(id).or_insert_with(fresh)
    }

    /// Empties an object's meshes and frees their numbers for others.
    fn release_meshes(&mut self, object: ObjectId) {
        for mesh in std::mem::take(&mut self.scene.edit_object(object).meshes) {
            self.scene.replace_mesh(mesh, Mesh::default());
            self.free_meshes.push(mesh);
        }
    }

    fn place_mesh(&mut self, mesh: Mesh) -> MeshId {
        match self.free_meshes.pop() {
            Some(position) => {
                self.scene.replace_mesh(position, mesh);
                position
            }
            None => self.scene.add_mesh(mesh),
        }
    }

    /// The material of a shader.
    fn material(&mut self, shader: u32) -> MaterialId {
        let (scene, free) = (&mut self.scene, &mut self.free_slots);
        let fresh = || {
            free.pop().unwrap_or_else(|| {
                let slot = scene.materials().len() as u32;
                scene.add_material(Material::of("", Surface::Shader(slot)));
                slot
            })
        };
        MaterialId(*self.shader_slots.entry(shader).or_insert_with(fresh))
    }
}

/// The surface shaders among them.
fn surface(made: RenderShader) -> Option<Arc<dyn SurfaceShader>> {
    match made {
        RenderShader::Surface(surface) => Some(surface),
        RenderShader::Environment(_)
        | RenderShader::Light(_)
        | RenderShader::Camera(_)
        | RenderShader::Pixel(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn redefinition_takes_no_more_places() {
        let mut stage = Stage::default();
        let meshes = |n: u32| (0..n).map(|shader| ShaderMesh { shader, mesh: Mesh::default() }).collect();
        for round in 0..10 {
            stage.define(1, meshes(1 + round % 3), std::iter::empty());
            stage.define(2 + round, meshes(2), std::iter::empty());
            let shown =
                |object| (object, Shown { object, world_from_object: Affine::IDENTITY, mask: RayMask::ALL });
            stage.show_all([1, 2 + round, 99].into_iter().map(shown));
            stage.free_object(2 + round);
        }
        let sizes = [stage.scene.meshes().len(), stage.scene.objects().len(), stage.scene.instances().len()];
        assert_eq!(sizes, [5, 2, 2], "meshes, objects and instances of the largest frame");
        stage.show_all(std::iter::empty());
        assert!(stage.scene.instances().iter().all(|instance| !instance.visible), "nothing is shown");
    }
}
