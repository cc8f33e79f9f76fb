// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders (rtGenNewShader, rtBindShader, rtDeleteShader, rtIsShader).
//! Source: \[DWBS03\]; the paper's Figure 1. Tests: tests/c/scene.c, tests/c/errors.c.

use crate::context::Context;
use crate::state::error::{Error, Result};
use crate::state::shader::Shader;

impl Context {
    /// rtGenNewShader.
    pub(crate) fn gen_new_shader(&mut self) -> Result<u32> {
        self.outside_block()?;
        let class_id = self.bound.class_id().ok_or(Error::InvalidOperation)?;
        let class = self.bound.class().ok_or(Error::InvalidOperation)?.clone();
        let shader = Shader::new(class_id, class.clone()).or_else(|why| {
            self.notify(&[why])?;
            Err(Error::InvalidOperation)
        })?;
        let id = self.shaders.add(shader)?;
        self.bound.bind(class_id, class, Some(id));
        Ok(id)
    }

    /// rtBindShader.
    pub(crate) fn bind_shader(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        let shader = self.shaders.get(id).ok_or(Error::InvalidOperation)?;
        self.bound.bind(shader.class_id, shader.class.clone(), Some(id));
        Ok(())
    }

    /// rtDeleteShader.
    pub(crate) fn delete_shader(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.shaders.get_mut(id).ok_or(Error::InvalidValue)?.deleted = true;
        self.bound.unbind(id);
        Ok(())
    }

    /// rtIsShader.
    pub(crate) fn is_shader(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.shaders.get(id).is_some())
    }
}
