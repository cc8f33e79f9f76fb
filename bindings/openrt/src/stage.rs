// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene and the world that frames render, brought up to date with the program's objects when a frame starts.
//! Source: original. The stage belongs to the frame in flight; the program edits its own description meanwhile.
//! Invariant: a mesh, object or instance of the scene that nothing needs is empty or invisible and waits to be used
//! again, so a program that redefines objects for ever takes no more memory than its largest frame.
//! Proof: `tests/state_machine.rs`; tests/c/scene.c.

use std::collections::BTreeMap;

use gnurt::render::{Accumulation, ShaderTable, World};
use gnurt::scene::{
    Affine, Attribute, Instance, InstanceId, Material, MaterialId, Mesh, MeshId, Object, ObjectId, Scene,
    Surface, TEXCOORD_RQ,
};
use gnurt::shading::classes::{Shader as RenderShader, Value, Values};
use gnurt_plugins::host::PluginFrame;

use crate::state::geometry::ShaderMesh;
use crate::state::shader::Shaders;
use crate::state::texture::Textures;

/// The id under which geometry outside of objects is staged; no object has it.
pub(crate) const UNNAMED: u32 = 0;

/// Scene, world and what of them is in use.
#[derive(Default)]
pub(crate) struct Stage {
    /// What the renderer reads.
    pub(crate) scene: Scene,
    /// What rays meet.
    pub(crate) world: World,
    /// The samples of the last frame.
    pub(crate) accumulation: Option<Accumulation>,
    /// Their means, from the top row on: room that frames use again.
    pub(crate) colors: Vec<[f32; 4]>,
    objects: BTreeMap<u32, ObjectId>,
    /// The first ones are visible, in the order of the instances' ids.
    instances: Vec<InstanceId>,
    free_objects: Vec<ObjectId>,
    free_meshes: Vec<MeshId>,
    /// Number of each shader in the shader table, which is also that of its material.
    shader_slots: BTreeMap<u32, u32>,
    free_slots: Vec<u32>,
}

impl Stage {
    /// Gives an object new meshes.
    pub(crate) fn define(&mut self, id: u32, meshes: Vec<ShaderMesh>) {
        let object = self.object(id);
        self.release_meshes(object);
        let meshes = meshes.into_iter().map(|ShaderMesh { shader, mesh }| {
            let material = self.material(shader);
            self.place_mesh(Mesh { material, ..mesh })
        });
        let meshes = meshes.collect();
        self.scene.edit_object(object).meshes = meshes;
    }

    /// Frees the objects that are not to be kept.
    pub(crate) fn keep_objects(&mut self, keep: impl Fn(u32) -> bool) {
        let gone: Vec<u32> = self.objects.keys().copied().filter(|&id| !keep(id)).collect();
        for id in gone {
            if let Some(object) = self.objects.remove(&id) {
                self.release_meshes(object);
                self.free_objects.push(object);
            }
        }
    }

    /// Makes exactly these instances visible; those of objects without a definition show nothing.
    pub(crate) fn show(&mut self, instances: impl Iterator<Item = (u32, Affine)>) {
        let mut shown = 0;
        for (id, world_from_object) in instances {
            let Some(&object) = self.objects.get(&id) else { continue };
            let wanted = Instance { name: String::new(), object, world_from_object, visible: true };
            match self.instances.get(shown) {
                Some(&slot) if *self.scene.instance(slot) == wanted => {}
                Some(&slot) => *self.scene.edit_instance(slot) = wanted,
                None => self.instances.push(self.scene.add_instance(wanted)),
            }
            shown += 1;
        }
        for &slot in &self.instances[shown..] {
            if self.scene.instance(slot).visible {
                self.scene.edit_instance(slot).visible = false;
            }
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

    /// Whether an object has been defined, so that its instances are shown.
    #[must_use]
    pub(crate) fn has_object(&self, id: u32) -> bool {
        self.objects.contains_key(&id)
    }

    /// The scene's numbers of the instances that were shown, in their order.
    pub(crate) fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.instances.iter().map(|id| id.index())
    }

    /// The surface shaders with their present values, each at its number; mid-grey where one cannot take part in the
    /// frame. Frees the numbers of those that are gone.
    pub(crate) fn surfaces(
        &mut self,
        shaders: &Shaders,
        textures: &Textures,
        plugins: &PluginFrame,
    ) -> ShaderTable {
        let is_alive = |id: u32| shaders.in_use(id).is_some();
        let gone = self.shader_slots.iter().filter(|&(&id, _)| !is_alive(id));
        self.free_slots.extend(gone.map(|(_, &slot)| slot));
        self.shader_slots.retain(|&id, _| is_alive(id));
        let by_slot: BTreeMap<u32, u32> = self.shader_slots.iter().map(|(&id, &slot)| (slot, id)).collect();
        let constant = gnurt::shading::classes::find("ConstantShader").expect("a built-in class");
        let unused = constant.make(&Values(vec![Value::Floats(vec![0.5; 3])]));
        let made = |slot: u32| {
            let made = by_slot.get(&slot).and_then(|&id| shaders.in_use(id)?.make(id, textures, plugins));
            made.unwrap_or_else(|| unused.clone())
        };
        let surface = |made| match made {
            RenderShader::Surface(surface) => Some(surface),
            RenderShader::Environment(_) | RenderShader::Light(_) | RenderShader::Camera(_) => None,
        };
        let slot_count = self.scene.materials().len() as u32;
        ShaderTable {
            surfaces: (0..slot_count).map(made).filter_map(surface).collect(),
            ..Default::default()
        }
    }

    /// The scene's object of an id.
    fn object(&mut self, id: u32) -> ObjectId {
        let (scene, free) = (&mut self.scene, &mut self.free_objects);
        let fresh = || free.pop().unwrap_or_else(|| scene.add_object(Object::default()));
        *self.objects.entry(id).or_insert_with(fresh)
    }

    /// Empties an object's meshes and keeps their places for others.
    fn release_meshes(&mut self, object: ObjectId) {
        for mesh in std::mem::take(&mut self.scene.edit_object(object).meshes) {
            self.scene.replace_mesh(mesh, Mesh::default());
            self.free_meshes.push(mesh);
        }
    }

    fn place_mesh(&mut self, mesh: Mesh) -> MeshId {
        match self.free_meshes.pop() {
            Some(place) => {
                self.scene.replace_mesh(place, mesh);
                place
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn redefinition_takes_no_more_places() {
        let mut stage = Stage::default();
        let meshes = |n: u32| (0..n).map(|shader| ShaderMesh { shader, mesh: Mesh::default() }).collect();
        for round in 0..10 {
            stage.define(1, meshes(1 + round % 3));
            stage.define(2 + round, meshes(2));
            stage.show(
                [(1, Affine::IDENTITY), (2 + round, Affine::IDENTITY), (99, Affine::IDENTITY)].into_iter(),
            );
            stage.keep_objects(|id| id == 1);
        }
        let sizes = [stage.scene.meshes().len(), stage.scene.objects().len(), stage.scene.instances().len()];
        assert_eq!(sizes, [5, 2, 2], "meshes, objects and instances of the largest frame");
        stage.show(std::iter::empty());
        assert!(stage.scene.instances().iter().all(|instance| !instance.visible), "nothing is shown");
    }
}
