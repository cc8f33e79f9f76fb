// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects: ids, what was defined under them, and the one that is open.
//! Source: \[DWBS03\], the paper's Figure 1; display lists of OpenGL 1.x for what an id is.
//! Invariant: instances name objects by id; geometry waits here until the next frame takes it.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::collections::BTreeMap;

use super::block::Assembly;
use super::enums::ObjectMode;
use super::error::Result;
use super::geometry::{Geometry, ShaderMesh};
use super::ids::Ids;

/// Ids that objects never have: a first argument of rtNewObject that lies here is the mode of the one-argument form.
pub(crate) const MODE_RANGE: std::ops::Range<u32> = 0x200..0x300;

/// What has been defined under an id.
pub(crate) struct Definition {
    /// Vertices that the program gave.
    pub(crate) vertices_given: usize,
    /// Triangles that they made.
    pub(crate) triangles: usize,
    /// Shaders that they use.
    pub(crate) shaders: Vec<u32>,
    /// The meshes, if no frame has taken them yet.
    pub(crate) fresh: Option<Vec<ShaderMesh>>,
}

impl Definition {
    /// What a closed object holds.
    pub(crate) fn of(geometry: Geometry) -> Self {
        let (vertices_given, triangles) = (geometry.vertices_given, geometry.triangle_count());
        let meshes = geometry.finish();
        let shaders = meshes.iter().map(|mesh| mesh.shader).collect();
        Self { vertices_given, triangles, shaders, fresh: Some(meshes) }
    }
}

/// The object between rtNewObject and its end.
pub(crate) struct OpenObject {
    /// Its id.
    pub(crate) id: u32,
    /// How it was opened.
    pub(crate) mode: ObjectMode,
    /// What it takes in.
    pub(crate) assembly: Assembly,
}

/// All objects.
pub(crate) struct Objects {
    /// Which ids there are.
    pub(crate) ids: Ids,
    /// What has been defined; an id that was removed stays here while an instance shows it.
    pub(crate) defined: BTreeMap<u32, Definition>,
}

impl Default for Objects {
    fn default() -> Self {
        Self { ids: Ids::without(MODE_RANGE), defined: BTreeMap::new() }
    }
}

impl Objects {
    /// Reserves ids. Those that an instance still shows are not used again.
    pub(crate) fn reserve(&mut self, count: i32) -> Result<u32> {
        self.ids.reserve(count, |id| !self.defined.contains_key(&id))
    }

    /// How many objects with an id have been defined, and their triangles.
    #[must_use]
    pub(crate) fn counts(&self) -> (usize, usize) {
        let alive = self.defined.iter().filter(|(id, _)| self.ids.exists(**id));
        alive.fold((0, 0), |(n, triangles), (_, object)| (n + 1, triangles + object.triangles))
    }

    /// Whether one that was removed may still be shown.
    pub(crate) fn has_removed(&self) -> bool {
        self.defined.keys().any(|&id| !self.ids.exists(id))
    }

    /// Frees what was removed and is not in `shown`.
    pub(crate) fn prune(&mut self, shown: impl Fn(u32) -> bool) {
        self.defined.retain(|&id, _| self.ids.exists(id) || shown(id));
    }
}
