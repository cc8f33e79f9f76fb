// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects: ids, what was defined under them, which hold which, and the one that is open.
//! Source: \[DWBS03\], the paper's Figure 1; display lists of OpenGL 1.x for what an id is.
//! Invariants: instances name objects by id; geometry waits here until the next frame takes it. No object holds itself, and no
//! more lie in one another than a scene may have.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::collections::{BTreeMap, BTreeSet};

use gnurt::scene::nesting::DEEPEST;

use super::block::Assembly;
use super::enums::ObjectMode;
use super::error::Result;
use super::geometry::{Geometry, ShaderMesh};
use super::ids::Ids;
use super::matrix::Matrix;

/// Ids that objects never have: a first argument of rtNewObject that lies here is the mode of the one-argument form.
pub(crate) const MODE_RANGE: std::ops::Range<u32> = 0x200..0x300;

/// An object within another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nested {
    /// Its id.
    pub(crate) object: u32,
    /// Where it is in the object that holds it.
    pub(crate) object_from_nested: Matrix,
    /// Which kinds of rays see it, as bits.
    pub(crate) mask: u32,
}

/// What has been defined under an id.
pub(crate) struct Definition {
    /// Vertices that the program gave.
    pub(crate) vertices_given: usize,
    /// Triangles that they made.
    pub(crate) triangles: usize,
    /// Shaders that they use.
    pub(crate) shaders: Vec<u32>,
    /// Objects in it.
    pub(crate) nested: Vec<Nested>,
    /// The meshes, if no frame has taken them yet.
    pub(crate) fresh: Option<Vec<ShaderMesh>>,
}

impl Definition {
    /// What a closed object holds.
    pub(crate) fn of(geometry: Geometry, nested: Vec<Nested>) -> Self {
        let (vertices_given, triangles) = (geometry.vertices_given, geometry.triangle_count());
        let meshes = geometry.finish();
        let shaders = meshes.iter().map(|mesh| mesh.shader).collect();
        Self { vertices_given, triangles, shaders, nested, fresh: Some(meshes) }
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
    /// Objects in it.
    pub(crate) nested: Vec<Nested>,
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

    /// Objects that lie in others.
    pub(crate) fn held(&self) -> BTreeSet<u32> {
        self.defined.values().flat_map(|object| &object.nested).map(|nested| nested.object).collect()
    }

    /// All these objects and what they hold, and that holds.
    pub(crate) fn with_held(&self, mut objects: BTreeSet<u32>) -> BTreeSet<u32> {
        let mut new: Vec<u32> = objects.iter().copied().collect();
        while let Some(id) = new.pop() {
            let nested = self.defined.get(&id).into_iter().flat_map(|object| &object.nested);
            new.extend(nested.map(|nested| nested.object).filter(|&held| objects.insert(held)));
        }
        objects
    }

    /// Whether an object may hold these: none of them holds it, and no more than [`DEEPEST`] lie in one another.
    pub(crate) fn may_hold(&self, id: u32, nested: &[Nested]) -> bool {
        let inner: BTreeSet<u32> = nested.iter().map(|nested| nested.object).collect();
        if inner.is_empty() {
            return true;
        }
        if self.with_held(inner.clone()).contains(&id) {
            return false;
        }
        let mut known = BTreeMap::new();
        let below = inner.iter().map(|&held| 1 + self.level(held, &mut known)).max().unwrap_or(0);
        // Those that hold the object, and those that hold these.
        let (mut above, mut holders) = (0, BTreeSet::from([id]));
        while below + above < DEEPEST {
            let holds =
                |object: &Definition| object.nested.iter().any(|nested| holders.contains(&nested.object));
            let next = self.defined.iter().filter(|&(&other, object)| other != id && holds(object));
            holders = next.map(|(&other, _)| other).collect();
            if holders.is_empty() {
                return true;
            }
            above += 1;
        }
        false
    }

    /// How many objects lie in one another here, without the outermost.
    fn level(&self, id: u32, known: &mut BTreeMap<u32, u32>) -> u32 {
        if let Some(&level) = known.get(&id) {
            return level;
        }
        let nested = self.defined.get(&id).into_iter().flat_map(|object| &object.nested);
        let inner: BTreeSet<u32> = nested.map(|nested| nested.object).collect();
        let level = inner.into_iter().map(|held| 1 + self.level(held, known)).max().unwrap_or(0);
        known.insert(id, level);
        level
    }

    /// Frees what was removed and is not in `shown`.
    pub(crate) fn prune(&mut self, shown: impl Fn(u32) -> bool) {
        self.defined.retain(|&id, _| self.ids.exists(id) || shown(id));
    }
}
