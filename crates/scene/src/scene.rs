// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene: arrays of plain data and the log of their edits.
//! Objects and instances after the paper's section 6 and [WBS03a], objects in objects: `nesting`.
//! Everything is read through public slices and written through methods, so that no edit escapes the log.
//! Meshes are shared: the holder of an `Arc` keeps its mesh unchanged, because an edit copies shared meshes.
//! Tests: `tests::edits_leave_shared_meshes_alone`, crates/render/tests/commit.rs.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::affine::Affine;
use crate::animation::{Animation, Playback};
use crate::camera::Camera;
use crate::displacement::Displacement;
use crate::edit::{Cursor, Edit, EditLog, SceneIdentity};
use crate::id::{CameraId, InstanceId, LightId, MaterialId, MediumId, MeshId, ObjectId, TextureId};
use crate::labels::Labels;
use crate::light::Light;
use crate::material::Material;
use crate::medium::Medium;
use crate::mesh::Mesh;
use crate::motion::Motion;
use crate::ray_mask::RayMask;
use crate::shader_file::ShaderFile;
use crate::texture::Texture;

/// Meshes that share one acceleration structure and move together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// A label; need not be unique.
    pub name: String,
    /// Its meshes; a hit's `geom_id` is a position in this list.
    pub meshes: Vec<MeshId>,
    /// Other objects that it is made of, in addition to its meshes; each is stored once, however often it
    /// occurs. [`DEEPEST`](crate::nesting::DEEPEST) levels at most, and none may hold itself.
    pub members: Vec<Member>,
    /// Hint for its tree when the meshes are edited.
    pub motion: Motion,
}

/// An object within another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Member {
    /// The nested object.
    pub object: ObjectId,
    /// Where, in the space of the object that holds it; must have an inverse, else the member is dropped and counted at commit.
    pub object_from_member: Affine,
    /// The rays that hit it, among those that hit the object that holds it.
    pub mask: RayMask,
}

impl Member {
    /// A member that all rays hit.
    #[must_use]
    pub fn new(object: ObjectId, object_from_member: Affine) -> Self {
        Self { object, object_from_member, mask: RayMask::ALL }
    }
}

/// An object put somewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instance {
    /// A label; need not be unique.
    pub name: String,
    /// The object shown.
    pub object: ObjectId,
    /// Where; must have an inverse, else the instance is dropped and counted at commit.
    pub world_from_object: Affine,
    /// Whether rays meet it.
    pub visible: bool,
    /// Which rays do, where it is visible.
    pub mask: RayMask,
}

/// Objects, instances, materials, textures, lights and cameras, their animation, and the log of edits.
// A new field goes into `snapshot`, too.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    meshes: Vec<Arc<Mesh>>,
    objects: Vec<Object>,
    instances: Vec<Instance>,
    materials: Vec<Material>,
    /// Shaders that its file names, by materials.
    shader_files: BTreeMap<MaterialId, ShaderFile>,
    /// Displacements, by materials.
    displacements: BTreeMap<MaterialId, Displacement>,
    /// Shaders that its file names, by cameras.
    camera_files: BTreeMap<CameraId, ShaderFile>,
    textures: Vec<Texture>,
    lights: Vec<Light>,
    media: Vec<Medium>,
    cameras: Vec<Camera>,
    animation: Option<Arc<Animation>>,
    playback: Playback,
    /// See [`Scene::labels`].
    labels: Labels,
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
    objects, Object, ObjectId, Object, add_object, object, edit_object;
    instances, Instance, InstanceId, Instance, add_instance, instance, edit_instance;
    materials, Material, MaterialId, Material, add_material, material, edit_material;
    textures, Texture, TextureId, Texture, add_texture, texture, edit_texture;
    lights, Light, LightId, Light, add_light, light, edit_light;
    media, Medium, MediumId, Medium, add_medium, medium, edit_medium;
    cameras, Camera, CameraId, Camera, add_camera, camera, edit_camera;
}

impl Scene {
    /// Shaders that its file names for materials; without a shader compiler the materials are shown.
    pub fn shader_files(&self) -> impl Iterator<Item = (MaterialId, &ShaderFile)> {
        self.shader_files.iter().map(|(&id, file)| (id, file))
    }

    /// Names a shader for a material. The renderer's caller compiles it.
    pub fn set_shader_file(&mut self, material: MaterialId, file: ShaderFile) {
        self.log.note(Edit::Material(material));
        self.shader_files.insert(material, file);
    }

    /// Displacements of its surfaces, by materials.
    pub fn displacements(&self) -> impl Iterator<Item = (MaterialId, &Displacement)> {
        self.displacements.iter().map(|(&id, displacement)| (id, displacement))
    }

    /// The displacement of a material's surfaces.
    #[must_use]
    pub fn displacement(&self, material: MaterialId) -> Option<&Displacement> {
        self.displacements.get(&material)
    }

    /// Displaces the surfaces of a material from now on; `None` = no longer.
    pub fn set_displacement(&mut self, material: MaterialId, displacement: Option<Displacement>) {
        self.log.note(Edit::Material(material));
        match displacement {
            Some(displacement) => self.displacements.insert(material, displacement),
            None => self.displacements.remove(&material),
        };
    }

    /// The shader that its file names for a camera; the camera gives its position, and the view without a
    /// shader compiler.
    #[must_use]
    pub fn camera_file(&self, camera: CameraId) -> Option<&ShaderFile> {
        self.camera_files.get(&camera)
    }

    /// Names a shader for a camera. The renderer's caller compiles it.
    pub fn set_camera_file(&mut self, camera: CameraId, file: ShaderFile) {
        self.log.note(Edit::Camera(camera));
        self.camera_files.insert(camera, file);
    }

    /// What its file says of its parts, beside what is shown.
    #[must_use]
    pub fn labels(&self) -> &Labels {
        &self.labels
    }

    /// The same, to be changed.
    pub fn labels_mut(&mut self) -> &mut Labels {
        &mut self.labels
    }

    /// Whether light is scattered or absorbed by media that integrators may leave out.
    #[must_use]
    pub fn has_media(&self) -> bool {
        !self.media.is_empty() || self.materials.iter().any(Material::scatters_within)
    }

    /// An empty scene.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// All meshes; an id is a position in this slice. Clone an `Arc` to keep a mesh as it is now.
    #[must_use]
    pub fn meshes(&self) -> &[Arc<Mesh>] {
        &self.meshes
    }

    /// Adds to the meshes.
    pub fn add_mesh(&mut self, value: impl Into<Arc<Mesh>>) -> MeshId {
        let id = MeshId(u32::try_from(self.meshes.len()).expect("fewer than 2^32 values"));
        self.meshes.push(value.into());
        self.log.note(Edit::Mesh(id));
        id
    }

    /// One of the meshes. Panics on an id of another scene.
    #[must_use]
    pub fn mesh(&self, id: MeshId) -> &Mesh {
        &self.meshes[id.index()]
    }

    /// One of the meshes, to be changed; the log notes it. A shared mesh is copied first: a committed world
    /// keeps its version. Panics on an id of another scene.
    pub fn edit_mesh(&mut self, id: MeshId) -> &mut Mesh {
        self.log.note(Edit::Mesh(id));
        Arc::make_mut(&mut self.meshes[id.index()])
    }

    /// Replaces a mesh, without copying either. Panics on an id of another scene.
    pub fn replace_mesh(&mut self, id: MeshId, value: impl Into<Arc<Mesh>>) {
        self.log.note(Edit::Mesh(id));
        self.meshes[id.index()] = value.into();
    }

    /// Adds an object of `meshes`.
    pub fn add_object_of(&mut self, name: impl Into<String>, meshes: Vec<MeshId>) -> ObjectId {
        self.add_object(Object { name: name.into(), meshes, ..Object::default() })
    }

    /// Adds an object that is made of others.
    pub fn add_object_of_members(&mut self, name: impl Into<String>, members: Vec<Member>) -> ObjectId {
        self.add_object(Object { name: name.into(), members, ..Object::default() })
    }

    /// Puts `object` at `world_from_object`.
    pub fn instantiate(&mut self, object: ObjectId, world_from_object: Affine) -> InstanceId {
        let name = self.object(object).name.clone();
        self.add_instance(Instance { name, object, world_from_object, visible: true, mask: RayMask::ALL })
    }

    /// The animation; `None` if nothing moves. [`animate`](Self::animate) sets it, [`pose`](Self::pose) shows
    /// a time of it.
    #[must_use]
    pub fn animation(&self) -> Option<&Animation> {
        self.animation.as_deref()
    }

    pub(crate) fn shared_animation(&self) -> Option<Arc<Animation>> {
        self.animation.clone()
    }

    /// Replaces the animation by a checked one.
    pub fn set_animation(&mut self, animation: Animation) {
        self.animation = Some(Arc::new(animation));
        self.playback = Playback::default();
    }

    /// The pose that is shown.
    pub(crate) fn playback(&mut self) -> &mut Playback {
        &mut self.playback
    }

    /// The current position of the edit log.
    #[must_use]
    pub fn cursor(&self) -> Cursor {
        self.log.cursor()
    }

    /// The identity of this scene, distinct from all others, copies included.
    #[must_use]
    pub fn identity(&self) -> &SceneIdentity {
        self.log.identity()
    }

    /// The edits after `cursor`, each element once.
    pub fn edits_since(&self, cursor: Cursor) -> impl Iterator<Item = Edit> + '_ {
        self.log.since(cursor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_leave_shared_meshes_alone() {
        let mut scene = Scene::new();
        let id = scene.add_mesh(Mesh { positions: vec![[1.0; 3]], ..Mesh::default() });
        let location = scene.mesh(id).positions.as_ptr();
        scene.edit_mesh(id).name = "alone".into();
        assert_eq!(scene.mesh(id).positions.as_ptr(), location, "nobody else holds it: changed in place");
        let snapshot = scene.meshes()[id.index()].clone();
        scene.edit_mesh(id).positions[0] = [2.0; 3];
        assert_eq!(snapshot.positions, [[1.0; 3]], "the snapshot is as it was");
        assert_eq!(scene.mesh(id).positions, [[2.0; 3]], "the scene is not");
        let before = scene.cursor();
        scene.replace_mesh(id, snapshot.clone());
        assert!(Arc::ptr_eq(&scene.meshes()[id.index()], &snapshot), "nothing was copied");
        assert_eq!(scene.edits_since(before).collect::<Vec<_>>(), [Edit::Mesh(id)], "the log knows");
    }
}
