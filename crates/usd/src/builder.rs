// SPDX-License-Identifier: GPL-3.0-or-later
//! The state of a walk over a stage: the scene so far, known materials, prototypes and skeletons.
//! Space: metres, y up; within prototypes that of the prototype. Tests: `tests/composition.rs`.

use std::collections::HashMap;
use std::rc::Rc;

use gnurt_scene::io::Oddity;
use gnurt_scene::io::reader::Cutter;
use gnurt_scene::labels::{Luminaire, Shining};
use gnurt_scene::{Affine, MaterialId, Member, ObjectId, Scene};
use openusd::sdf::Path;

use crate::binding::Bindings;
use crate::material::Materials;
use crate::pose::Skeleton;
use crate::reader::Reader;

/// A scene under construction from a stage.
pub(crate) struct Builder<'a> {
    pub(crate) reader: &'a Reader,
    pub(crate) scene: Scene,
    pub(crate) bindings: Bindings,
    pub(crate) materials: Materials<'a>,
    pub(crate) cutter: Cutter,
    /// Objects of meshes in prototypes, by their path there and their materials.
    pub(crate) objects: HashMap<SharedKey, ObjectId>,
    /// Whether a prototype of a point instancer is read: its objects have their paths, which nothing else would name.
    pub(crate) is_prototype: bool,
    /// Objects of other meshes, by the sum of their contents.
    pub(crate) equal: HashMap<[u64; 2], ObjectId>,
    /// Objects of prototypes of point instancers.
    pub(crate) prototypes: HashMap<Path, Option<ObjectId>>,
    /// The place of prims that reset the transforms above them.
    pub(crate) root: Affine,
    /// Skeletons by their path.
    pub(crate) skeletons: HashMap<Path, Option<Rc<Skeleton>>>,
    /// Lights by their prims, whose collections are read when all instances are known.
    pub(crate) lights: Vec<(Shining, Path)>,
}

/// The key of a mesh in a prototype: its path there and its materials.
pub(crate) type SharedKey = (String, Vec<MaterialId>);

/// Facts that a prim inherits from those above it.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub(crate) world_from_parent: Affine,
    pub(crate) is_of_purpose: bool,
}

/// An object somewhere.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub(crate) object: ObjectId,
    pub(crate) transform: Affine,
    pub(crate) path: String,
    pub(crate) luminaire: Option<Luminaire>,
}

impl Builder<'_> {
    /// Puts an object where a prim is.
    pub(crate) fn add_instance(
        &self,
        prim: &Path,
        object: ObjectId,
        transform: Affine,
        placed: &mut Vec<Placed>,
    ) {
        if transform.inverse().is_none() {
            self.reader.note(Oddity::BadNode, prim, "its transform is flat or not finite");
            return;
        }
        placed.push(Placed { object, transform, path: prim.as_str().to_owned(), luminaire: None });
    }

    /// The material that a prim is bound to.
    pub(crate) fn bound(&mut self, prim: &Path) -> Option<Path> {
        self.bindings.of(self.reader, prim)
    }

    /// The key of a mesh in a prototype; `None` of others, which occur once.
    pub(crate) fn shared_key(&self, prim: &Path, materials: &[MaterialId]) -> Option<SharedKey> {
        let inner = self.reader.stage.prim(prim.clone()).prim_in_prototype().ok().flatten()?;
        Some((inner.path().as_str().to_owned(), materials.to_vec()))
    }

    /// Members in the place of placed objects.
    pub(crate) fn members(placed: &[Placed]) -> Vec<Member> {
        placed.iter().map(|placed| Member::new(placed.object, placed.transform)).collect()
    }
}
