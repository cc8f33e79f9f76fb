// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects: ids, their definitions, their nesting, and the open one.
//! Source: \[DWBS03\], [SIP06], Figure 1; ids as those of OpenGL 1.x display lists. Invariants: instances
//! name objects by id; geometry is stored here until the next frame takes it. No object holds itself, and the
//! nesting is no deeper than a scene allows.
//! Tests: tests/c/scene.c, tests/c/errors.c.

use std::collections::{BTreeMap, BTreeSet};

use gnurt::scene::nesting::DEEPEST;

use super::block::Assembly;
use super::enums::ObjectMode;
use super::error::Result;
use super::geometry::{Geometry, ShaderMesh};
use super::ids::Ids;
use super::matrix::Matrix;

/// Ids that objects never have: a first argument of rtNewObject in this range is the mode of the one-argument
/// form.
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

/// The definition of an id.
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
    /// The contents of a closed object.
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
    /// Its vertices and triangles so far.
    pub(crate) assembly: Assembly,
    /// Objects in it.
    pub(crate) nested: Vec<Nested>,
}

/// All objects.
pub(crate) struct Objects {
    /// Which ids there are.
    pub(crate) ids: Ids,
    /// Definitions; a removed id stays here while an instance shows it.
    defined: BTreeMap<u32, Definition>,
    /// For each object that lies in others, which these are.
    holders: BTreeMap<u32, BTreeSet<u32>>,
    /// Those whose meshes no frame has taken yet.
    fresh: BTreeSet<u32>,
    /// Those of `defined` whose id is gone.
    removed: BTreeSet<u32>,
    /// Those that lost their definition or the last object that held them since the last frame's check.
    left: BTreeSet<u32>,
}

impl Default for Objects {
    fn default() -> Self {
        Self {
            ids: Ids::without(MODE_RANGE),
            defined: BTreeMap::new(),
            holders: BTreeMap::new(),
            fresh: BTreeSet::new(),
            removed: BTreeSet::new(),
            left: BTreeSet::new(),
        }
    }
}

impl Objects {
    /// Reserves ids. Those that an instance still shows are not used again.
    pub(crate) fn reserve(&mut self, count: i32) -> Result<u32> {
        self.ids.reserve(count, |id| !self.defined.contains_key(&id))
    }

    /// The definition of an id.
    #[must_use]
    pub(crate) fn get(&self, id: u32) -> Option<&Definition> {
        self.defined.get(&id)
    }

    /// All definitions.
    pub(crate) fn definitions(&self) -> impl Iterator<Item = &Definition> {
        self.defined.values()
    }

    /// Gives an id a definition.
    pub(crate) fn define(&mut self, id: u32, definition: Definition) {
        for nested in &definition.nested {
            self.holders.entry(nested.object).or_default().insert(id);
        }
        let nested: Vec<u32> = definition.nested.iter().map(|nested| nested.object).collect();
        if let Some(before) = self.defined.insert(id, definition) {
            self.let_go(
                id,
                before.nested.iter().map(|nested| nested.object).filter(|held| !nested.contains(held)),
            );
        }
        self.fresh.insert(id);
    }

    /// An object holds these no longer.
    fn let_go(&mut self, id: u32, held: impl Iterator<Item = u32>) {
        for held in held {
            if let Some(holders) = self.holders.get_mut(&held) {
                holders.remove(&id);
                if holders.is_empty() {
                    self.holders.remove(&held);
                    self.left.insert(held);
                }
            }
        }
    }

    /// Removes an id. Its definition stays while an instance shows it.
    pub(crate) fn remove(&mut self, id: u32) -> Result<()> {
        self.ids.remove(id)?;
        if self.defined.contains_key(&id) {
            self.removed.insert(id);
        }
        Ok(())
    }

    /// How many objects with an id have been defined, and their triangles.
    #[must_use]
    pub(crate) fn counts(&self) -> (usize, usize) {
        let alive = self.defined.iter().filter(|(id, _)| !self.removed.contains(id));
        alive.fold((0, 0), |(n, triangles), (_, object)| (n + 1, triangles + object.triangles))
    }

    /// Whether a removed one may still be shown.
    pub(crate) fn has_removed(&self) -> bool {
        !self.removed.is_empty()
    }

    /// Whether a frame needs this id: it is defined, or an empty member of another object.
    pub(crate) fn is_needed(&self, id: u32) -> bool {
        self.defined.contains_key(&id) || self.holders.contains_key(&id)
    }

    /// Ids that a frame may need no longer, since the last call of this.
    pub(crate) fn take_left(&mut self) -> BTreeSet<u32> {
        std::mem::take(&mut self.left)
    }

    /// Calls `take` with each object whose meshes no frame has taken yet, ascending, with its meshes and
    /// members.
    pub(crate) fn take_fresh(&mut self, mut take: impl FnMut(u32, Vec<ShaderMesh>, &[Nested])) {
        for id in std::mem::take(&mut self.fresh) {
            if let Some(object) = self.defined.get_mut(&id)
                && let Some(meshes) = object.fresh.take()
            {
                take(id, meshes, &object.nested);
            }
        }
    }

    /// All these objects and everything that they hold, transitively.
    fn with_held(&self, mut objects: BTreeSet<u32>) -> BTreeSet<u32> {
        let mut new: Vec<u32> = objects.iter().copied().collect();
        while let Some(id) = new.pop() {
            let nested = self.defined.get(&id).into_iter().flat_map(|object| &object.nested);
            new.extend(nested.map(|nested| nested.object).filter(|&held| objects.insert(held)));
        }
        objects
    }

    /// Whether an object may hold these: none of them holds it, and the nesting stays within [`DEEPEST`]
    /// levels.
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
            let next = holders.iter().filter_map(|held| self.holders.get(held)).flatten().copied();
            holders = next.filter(|&other| other != id).collect();
            if holders.is_empty() {
                return true;
            }
            above += 1;
        }
        false
    }

    /// The nesting depth of an object, without itself.
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

    /// Frees removed objects that are neither `shown` nor held by another one.
    pub(crate) fn prune(&mut self, shown: impl Fn(u32) -> bool) {
        let mut known = BTreeMap::new();
        let gone: Vec<u32> =
            self.removed.iter().copied().filter(|&id| !self.stays(id, &shown, &mut known)).collect();
        for id in gone {
            self.removed.remove(&id);
            self.fresh.remove(&id);
            self.left.insert(id);
            if let Some(object) = self.defined.remove(&id) {
                self.let_go(id, object.nested.iter().map(|nested| nested.object));
            }
        }
    }

    /// Whether an object with a definition retains it: its id exists, or it is shown, or contained in one
    /// that stays.
    fn stays(&self, id: u32, shown: &impl Fn(u32) -> bool, known: &mut BTreeMap<u32, bool>) -> bool {
        if let Some(&stays) = known.get(&id) {
            return stays;
        }
        let stays = !self.removed.contains(&id)
            || shown(id)
            || self
                .holders
                .get(&id)
                .is_some_and(|all| all.iter().any(|&holder| self.stays(holder, shown, known)));
        known.insert(id, stays);
        stays
    }
}
