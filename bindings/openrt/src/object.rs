// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects: ids, definition, re-definition and removal (rtGenObjects to rtEndObject, rtRemoveObject).
//! Source: \[DWBS03\], the paper's Figure 1; display lists of OpenGL 1.x for what an id is.
//! Invariant: instances name objects by id; geometry waits here until the next frame takes it.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::collections::BTreeMap;

use crate::block::Assembly;
use crate::context::Context;
use crate::enums::ObjectMode;
use crate::error::{Error, Result};
use crate::geometry::{Geometry, ShaderMesh};
use crate::ids::Ids;

/// Ids that objects never have: a first argument of rtNewObject that lies here is the mode of the one-argument form.
pub const MODE_RANGE: std::ops::Range<u32> = 0x200..0x300;

/// What has been defined under an id.
pub struct Definition {
    /// Vertices that the program gave.
    pub vertices_given: usize,
    /// Triangles that they made.
    pub triangles: usize,
    /// Shaders that they use.
    pub shaders: Vec<u32>,
    /// The meshes, if no frame has taken them yet.
    pub fresh: Option<Vec<ShaderMesh>>,
}

impl Definition {
    fn of(geometry: Geometry) -> Self {
        let (vertices_given, triangles) = (geometry.vertices_given, geometry.triangle_count());
        let meshes = geometry.finish();
        let shaders = meshes.iter().map(|mesh| mesh.shader).collect();
        Self { vertices_given, triangles, shaders, fresh: Some(meshes) }
    }
}

/// The object between rtNewObject and its end.
pub struct OpenObject {
    id: u32,
    mode: ObjectMode,
    /// What it takes in.
    pub assembly: Assembly,
}

/// All objects.
pub struct Objects {
    ids: Ids,
    /// What has been defined; an id that was removed stays here while an instance shows it.
    pub defined: BTreeMap<u32, Definition>,
}

impl Default for Objects {
    fn default() -> Self {
        Self { ids: Ids::without(MODE_RANGE), defined: BTreeMap::new() }
    }
}

impl Objects {
    /// Whether the id was generated and not removed.
    #[must_use]
    pub fn exists(&self, id: u32) -> bool {
        self.ids.exists(id)
    }

    /// How many objects with an id have been defined, and their triangles.
    #[must_use]
    pub fn counts(&self) -> (usize, usize) {
        let alive = self.defined.iter().filter(|(id, _)| self.ids.exists(**id));
        alive.fold((0, 0), |(n, triangles), (_, object)| (n + 1, triangles + object.triangles))
    }

    /// Frees what was removed and is not in `shown`.
    pub fn prune(&mut self, shown: impl Fn(u32) -> bool) {
        self.defined.retain(|&id, _| self.ids.exists(id) || shown(id));
    }
}

impl Context {
    /// rtGenObjects.
    pub fn gen_objects(&mut self, count: i32) -> Result<u32> {
        self.outside_block()?;
        self.no_open_object()?;
        self.objects.ids.reserve(count)
    }

    /// rtNewObject with two arguments.
    pub fn new_object(&mut self, id: u32, mode: u32) -> Result<u32> {
        self.outside_block()?;
        self.no_open_object()?;
        let mode = ObjectMode::from_code(mode)?;
        self.objects.ids.check(id)?;
        self.open_object(id, mode);
        Ok(id)
    }

    /// rtCreateObject: rtNewObject with one argument.
    pub fn create_object(&mut self, mode: u32) -> Result<u32> {
        self.outside_block()?;
        self.no_open_object()?;
        let mode = ObjectMode::from_code(mode)?;
        let id = self.objects.ids.reserve(1)?;
        self.open_object(id, mode);
        Ok(id)
    }

    /// The function `rtNewObject` as programs without its prototype call it: the first argument may be the mode.
    pub fn new_object_either_form(&mut self, first: u32, second: u32) -> Result<u32> {
        let is_mode = first == ObjectMode::Define.code() || first == ObjectMode::DefineAndInstantiate.code();
        if is_mode { self.create_object(first) } else { self.new_object(first, second) }
    }

    fn open_object(&mut self, id: u32, mode: ObjectMode) {
        self.bound.restart_values();
        self.open = Some(OpenObject { id, mode, assembly: Assembly::default() });
    }

    /// rtEndObject.
    pub fn end_object(&mut self) -> Result<()> {
        self.outside_block()?;
        let open = self.open.take().ok_or(Error::InvalidOperation)?;
        self.close(open).map(|_| ())
    }

    /// rtInstantiateObject.
    pub fn instantiate_object(&mut self, id: u32) -> Result<u32> {
        self.outside_block()?;
        match self.open.take() {
            None => {
                self.objects.ids.check(id)?;
                self.add_instance(id)
            }
            Some(open) if open.id == id => match self.close(open)? {
                Some(instance) => Ok(instance),
                None => self.add_instance(id),
            },
            Some(other) => {
                self.open = Some(other);
                Err(Error::InvalidOperation)
            }
        }
    }

    /// Stores what an open object has taken in. Returns the instance that its mode asks for.
    fn close(&mut self, open: OpenObject) -> Result<Option<u32>> {
        let geometry = open.assembly.geometry;
        let known_vertices = self.objects.defined.get(&open.id).map_or(0, |known| known.vertices_given);
        if open.mode == ObjectMode::Update && geometry.vertices_given != known_vertices {
            return Err(Error::InvalidOperation);
        }
        self.objects.defined.insert(open.id, Definition::of(geometry));
        match open.mode {
            ObjectMode::DefineAndInstantiate => self.add_instance(open.id).map(Some),
            ObjectMode::Define | ObjectMode::Update => Ok(None),
        }
    }

    /// rtRemoveObject.
    pub fn remove_object(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        self.objects.ids.remove(id)
    }

    /// rtIsObject.
    pub fn is_object(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.objects.ids.exists(id))
    }
}
