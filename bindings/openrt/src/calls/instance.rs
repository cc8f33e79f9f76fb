// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances (rtUpdateInstance, rtInstanceMask, rtDeleteInstance, rtClearInstances, rtGetInstanceMatrixf, rtIsInstance).
//! Source: \[DWBS03\]. Tests: tests/c/scene.c, tests/c/errors.c.

use crate::context::Context;
use crate::state::error::{Error, Result, Writer, not_null};
use crate::state::instance::Instance;

impl Context {
    /// Adds an instance of an object that exists.
    pub(super) fn add_instance(&mut self, object: u32) -> Result<u32> {
        let world_from_object = self.modelview();
        self.instances.add(Instance { object, world_from_object, mask: u32::MAX })
    }

    /// rtUpdateInstance.
    pub(crate) fn update_instance(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        let world_from_object = self.modelview();
        let instance = self.instances.get_mut(id).ok_or(Error::InvalidValue)?;
        instance.world_from_object = world_from_object;
        Ok(())
    }

    /// rtInstanceMask.
    pub(crate) fn instance_mask(&mut self, id: u32, mask: u32) -> Result<()> {
        self.outside_block()?;
        self.instances.get_mut(id).ok_or(Error::InvalidValue)?.mask = mask;
        Ok(())
    }

    /// rtDeleteInstance.
    pub(crate) fn delete_instance(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        if self.instances.remove(id) { Ok(()) } else { Err(Error::InvalidValue) }
    }

    /// rtClearInstances.
    pub(crate) fn clear_instances(&mut self) -> Result<()> {
        self.outside_block()?;
        self.instances.clear();
        Ok(())
    }

    /// rtGetInstanceMatrixf: passes 16 numbers, column by column, to `write`.
    pub(crate) fn get_instance_matrix(&self, id: u32, write: Option<Writer<'_, f32>>) -> Result<()> {
        self.outside_block()?;
        let write = not_null(write)?;
        let instance = self.instances.get(id).ok_or(Error::InvalidValue)?;
        write(&instance.world_from_object.to_f32());
        Ok(())
    }

    /// rtIsInstance.
    pub(crate) fn is_instance(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.instances.get(id).is_some())
    }
}
