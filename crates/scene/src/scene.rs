// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene: arrays of plain data and the log of their edits.
//! Source: original; two levels (objects, instances) after the paper's section 6 and [WBS03a].
//! Everything is read through public slices and written through methods, so that no edit escapes the log.

use crate::affine::Affine;
use crate::camera::Camera;
use crate::edit::{Cursor, Edit, EditLog};
use crate::id::{CameraId, InstanceId, LightId, MaterialId, MeshId, ObjectId, TextureId};
use crate::light::Light;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::texture::Texture;

/// Meshes that share one acceleration structure and move together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Object {
    /// For people; need not be unique.
    pub name: String,
    /// Its meshes; a hit's `geom_id` is a position in this list.
    pub meshes: Vec<MeshId>,
}

/// An object put somewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// For people; need not be unique.
    pub name: String,
    /// What is put there.
    pub object: ObjectId,
    /// Where; must have an inverse, else the instance is dropped and counted at commit.
    pub world_from_object: Affine,
    /// Whether rays meet it.
    pub visible: bool,
}

/// Objects, instances, materials, textures, lights and cameras, and the log of what changed.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
    instances: Vec<Instance>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    lights: Vec<Light>,
    cameras: Vec<Camera>,
    log: EditLog,
}

macro_rules! arrays {
    ($($array:ident, $value:ty, $id:ident, $edit:ident, $add:ident, $get:ident, $edit_fn:ident);* $(;)?) => {
        impl Scene {$(
            #[doc = concat!("All ", stringify!($array), "; an id is a position in this slice.")]
            #[must_use]
            pub fn $array(&self) -> &[$value] {
                &self.$array
            }

            #[doc = concat!("Adds to the ", stringify!($array), ".")]
            pub fn $add(&mut self, value: $value) -> $id {
                let id = $id(u32::try_from(self.$array.len()).expect("fewer than 2^32 values"));
                self.$array.push(value);
                self.log.note(Edit::$edit(id));
                id
            }

            #[doc = concat!("One of the ", stringify!($array), ". Panics on an id of another scene.")]
            #[must_use]
            pub fn $get(&self, id: $id) -> &$value {
                &self.$array[id.index()]
            }

            #[doc = concat!("One of the ", stringify!($array), ", to be changed; the log notes it. Panics on an id of another scene.")]
            pub fn $edit_fn(&mut self, id: $id) -> &mut $value {
                self.log.note(Edit::$edit(id));
                &mut self.$array[id.index()]
            }
        )*}
    };
}

arrays! {
    meshes, Mesh, MeshId, Mesh, add_mesh, mesh, edit_mesh;
    objects, Object, ObjectId, Object, add_object, object, edit_object;
    instances, Instance, InstanceId, Instance, add_instance, instance, edit_instance;
    materials, Material, MaterialId, Material, add_material, material, edit_material;
    textures, Texture, TextureId, Texture, add_texture, texture, edit_texture;
    lights, Light, LightId, Light, add_light, light, edit_light;
    cameras, Camera, CameraId, Camera, add_camera, camera, edit_camera;
}

impl Scene {
    /// An empty scene.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an object of `meshes`.
    pub fn add_object_of(&mut self, name: impl Into<String>, meshes: Vec<MeshId>) -> ObjectId {
        self.add_object(Object { name: name.into(), meshes })
    }

    /// Puts `object` at `world_from_object`.
    pub fn instantiate(&mut self, object: ObjectId, world_from_object: Affine) -> InstanceId {
        let name = self.object(object).name.clone();
        self.add_instance(Instance { name, object, world_from_object, visible: true })
    }

    /// The present moment of the edit log.
    #[must_use]
    pub fn cursor(&self) -> Cursor {
        self.log.cursor()
    }

    /// What was edited after `cursor`, each thing once.
    pub fn edits_since(&self, cursor: Cursor) -> impl Iterator<Item = Edit> + '_ {
        self.log.since(cursor)
    }
}
