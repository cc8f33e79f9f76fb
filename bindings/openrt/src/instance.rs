// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances: objects put somewhere (rtUpdateInstance, rtDeleteInstance, rtClearInstances, rtGetInstanceMatrixf).
//! Source: \[DWBS03\]; two levels after the paper's section 6. Space: an instance's matrix goes from object to world.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::collections::BTreeMap;

use crate::context::Context;
use crate::error::{Error, Result, Writer, not_null};
use crate::matrix::Matrix;

/// An object put somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The object's id.
    pub object: u32,
    /// Where it is put.
    pub world_from_object: Matrix,
}

/// All instances.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    last_id: u32,
    all: BTreeMap<u32, Instance>,
}

impl Instances {
    /// All of them, in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = &Instance> {
        self.all.values()
    }

    /// All of them with their ids, in that order.
    pub fn entries(&self) -> impl Iterator<Item = (u32, &Instance)> {
        self.all.iter().map(|(&id, instance)| (id, instance))
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Removes all.
    pub fn clear(&mut self) {
        self.all.clear();
    }
}

impl Context {
    /// Adds an instance of an object that exists.
    pub(crate) fn add_instance(&mut self, object: u32) -> Result<u32> {
        let instances = &mut self.instances;
        let id = instances.last_id.checked_add(1).filter(|&id| id < u32::MAX).ok_or(Error::OutOfMemory)?;
        let world_from_object = self.stacks.top(crate::enums::MatrixMode::Modelview).matrix;
        instances.last_id = id;
        instances.all.insert(id, Instance { object, world_from_object });
        Ok(id)
    }

    /// rtUpdateInstance.
    pub fn update_instance(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        let world_from_object = self.modelview();
        let instance = self.instances.all.get_mut(&id).ok_or(Error::InvalidValue)?;
        instance.world_from_object = world_from_object;
        Ok(())
    }

    /// rtDeleteInstance.
    pub fn delete_instance(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.instances.all.remove(&id).map(|_| ()).ok_or(Error::InvalidValue)
    }

    /// rtClearInstances.
    pub fn clear_instances(&mut self) -> Result<()> {
        self.outside_block()?;
        self.instances.clear();
        Ok(())
    }

    /// rtGetInstanceMatrixf: passes 16 numbers, column by column, to `write`.
    pub fn get_instance_matrix(&self, id: u32, write: Option<Writer<'_, f32>>) -> Result<()> {
        self.outside_block()?;
        let write = not_null(write)?;
        let instance = self.instances.all.get(&id).ok_or(Error::InvalidValue)?;
        write(&instance.world_from_object.to_f32());
        Ok(())
    }

    /// rtIsInstance.
    pub fn is_instance(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.instances.all.contains_key(&id))
    }
}
