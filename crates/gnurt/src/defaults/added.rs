// SPDX-License-Identifier: GPL-3.0-or-later
//! Defaults added to one scene of a sequence, for the other scenes, so that camera and light stay from frame
//! to frame. Added elements are at the end of their lists, and refer only to each other.
//! Tests: `tests::frames_get_what_the_first_one_got`.

use crate::scene::{Camera, Instance, Light, Material, Mesh, Object, Scene, Surface, Texture};
use crate::scene::{MaterialId, MeshId, ObjectId, TextureId};
use std::sync::Arc;

/// How much a scene has.
#[derive(Clone, Copy, Debug)]
pub struct Stock {
    cameras: usize,
    lights: usize,
    textures: usize,
    materials: usize,
    meshes: usize,
    objects: usize,
    instances: usize,
}

impl Stock {
    /// Of a scene to which something will be added.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        Self {
            cameras: scene.cameras().len(),
            lights: scene.lights().len(),
            textures: scene.textures().len(),
            materials: scene.materials().len(),
            meshes: scene.meshes().len(),
            objects: scene.objects().len(),
            instances: scene.instances().len(),
        }
    }

    /// The elements added since then.
    #[must_use]
    pub fn added_to(self, scene: &Scene) -> Added {
        Added {
            cameras: scene.cameras()[self.cameras..].to_vec(),
            lights: scene.lights()[self.lights..].to_vec(),
            textures: scene.textures()[self.textures..].to_vec(),
            materials: scene.materials()[self.materials..].to_vec(),
            meshes: scene.meshes()[self.meshes..].to_vec(),
            objects: scene.objects()[self.objects..].to_vec(),
            instances: scene.instances()[self.instances..].to_vec(),
            before: self,
        }
    }
}

/// Cameras, lights and surroundings that a scene got.
#[derive(Clone, Debug)]
pub struct Added {
    cameras: Vec<Camera>,
    lights: Vec<Light>,
    textures: Vec<Texture>,
    materials: Vec<Material>,
    meshes: Vec<Arc<Mesh>>,
    objects: Vec<Object>,
    instances: Vec<Instance>,
    before: Stock,
}

impl Added {
    /// Adds it to another scene: lights and surroundings always, cameras if there are none.
    pub fn add_to(&self, scene: &mut Scene) {
        let (now, before) = (Stock::of(scene), self.before);
        let moved = |id: u32, before: usize, now: usize| (id as usize - before + now) as u32;
        if scene.cameras().is_empty() {
            self.cameras.iter().for_each(|camera| _ = scene.add_camera(camera.clone()));
        }
        self.textures.iter().for_each(|texture| _ = scene.add_texture(texture.clone()));
        for light in &self.lights {
            let mut light = light.clone();
            if let Some(TextureId(id)) = light.texture_mut() {
                *id = moved(*id, before.textures, now.textures);
            }
            scene.add_light(light);
        }
        for material in &self.materials {
            // The studio's floor is of one colour.
            debug_assert!(matches!(material.surface, Surface::ShadowCatcher { .. }), "{material:?}");
            scene.add_material(material.clone());
        }
        for mesh in &self.meshes {
            let MaterialId(id) = mesh.material;
            let material = MaterialId(moved(id, before.materials, now.materials));
            scene.add_mesh(Mesh { material, ..(**mesh).clone() });
        }
        for object in &self.objects {
            let mesh = |&MeshId(id): &MeshId| MeshId(moved(id, before.meshes, now.meshes));
            let meshes = object.meshes.iter().map(mesh).collect();
            // The studio has no objects in objects.
            debug_assert!(object.members.is_empty(), "{object:?}");
            scene.add_object(Object { meshes, ..object.clone() });
        }
        for instance in &self.instances {
            let object = ObjectId(moved(instance.object.0, before.objects, now.objects));
            scene.add_instance(Instance { object, ..instance.clone() });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::complete;
    use super::*;
    use crate::scene::Affine;

    fn triangle(size: f32) -> Scene {
        let mut scene = Scene::new();
        let material = scene.add_material(Material::matte("m", [0.5; 3]));
        let positions = vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
        let mesh = scene.add_mesh(Mesh { positions, indices: vec![[0, 1, 2]], material, ..Mesh::default() });
        let object = scene.add_object_of("o", vec![mesh]);
        scene.instantiate(object, Affine::IDENTITY);
        scene
    }

    #[test]
    fn frames_get_what_the_first_one_got() {
        let mut first = triangle(1.0);
        let stock = Stock::of(&first);
        complete(&mut first, 1.0);
        let mut later = triangle(2.0);
        later.add_material(Material::matte("another", [0.1; 3]));
        stock.added_to(&first).add_to(&mut later);
        later.check().expect("every number is a place");
        assert_eq!(later.cameras(), first.cameras(), "the same view");
        assert_eq!(later.lights(), first.lights(), "the same light");
        let floor = |scene: &Scene| {
            let object = scene.object(scene.instances()[1].object);
            let mesh = scene.mesh(object.meshes[0]);
            (mesh.positions.clone(), scene.material(mesh.material).clone())
        };
        assert_eq!(floor(&later), floor(&first), "the same floor");
    }
}
