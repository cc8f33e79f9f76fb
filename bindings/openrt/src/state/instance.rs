// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances: objects put somewhere, and their ids.
//! Source: \[DWBS03\]; two levels after the paper's section 6. Space: an instance's matrix goes from object to world.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::collections::BTreeMap;

use super::error::{Error, Result};
use super::matrix::Matrix;

/// An object put somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instance {
    /// The object's id.
    pub(crate) object: u32,
    /// Where it is put.
    pub(crate) world_from_object: Matrix,
}

/// All instances.
#[derive(Clone, Debug, Default)]
pub(crate) struct Instances {
    last_id: u32,
    all: BTreeMap<u32, Instance>,
}

impl Instances {
    /// All of them, in the order of their ids.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Instance> {
        self.all.values()
    }

    /// All of them with their ids, in that order.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (u32, &Instance)> {
        self.all.iter().map(|(&id, instance)| (id, instance))
    }

    /// How many there are.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// Adds one and returns its id.
    pub(crate) fn add(&mut self, instance: Instance) -> Result<u32> {
        let id = self.last_id.checked_add(1).filter(|&id| id < u32::MAX).ok_or(Error::OutOfMemory)?;
        self.last_id = id;
        self.all.insert(id, instance);
        Ok(id)
    }

    /// The one of an id.
    #[must_use]
    pub(crate) fn get(&self, id: u32) -> Option<&Instance> {
        self.all.get(&id)
    }

    /// The one of an id, to be changed.
    pub(crate) fn get_mut(&mut self, id: u32) -> Option<&mut Instance> {
        self.all.get_mut(&id)
    }

    /// Removes one; says whether it was there.
    pub(crate) fn remove(&mut self, id: u32) -> bool {
        self.all.remove(&id).is_some()
    }

    /// Removes all.
    pub(crate) fn clear(&mut self) {
        self.all.clear();
    }
}
