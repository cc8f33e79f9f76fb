// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader classes (rtGenNewShaderClass, rtBindShaderClass, rtParameterHandle, rtGetShaderClassInfoLog).
//! Source: \[DWBS03\]; the paper's Figure 1. Tests: tests/c/scene.c, tests/c/errors.c.

use std::ffi::CStr;

use gnurt_plugins::host::LoadError;

use crate::context::Context;
use crate::state::error::{Error, Result, not_null};
use crate::state::shader_class::Handle;

impl Context {
    /// rtGenNewShaderClass.
    pub(crate) fn gen_new_shader_class(&mut self, name: Option<&CStr>, file: Option<&CStr>) -> Result<u32> {
        self.outside_block()?;
        let text = |s: &CStr| s.to_string_lossy().into_owned();
        let outcome = match name {
            None => Err(LoadError::Missing("shader class name missing: the name is NULL".to_owned())),
            Some(name) => self.classes.load(&text(name), &file.map(text).unwrap_or_default()),
        };
        self.classes.set_info_log(&outcome.as_ref().err().map_or_else(String::new, ToString::to_string));
        let id = outcome.map_err(|failure| match failure {
            LoadError::Missing(_) => Error::InvalidValue,
            LoadError::Unfit(_) => Error::InvalidOperation,
        })?;
        self.bind_shader_class(id)?;
        Ok(id)
    }

    /// rtBindShaderClass.
    pub(crate) fn bind_shader_class(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        let class = self.classes.get(id).ok_or(Error::InvalidOperation)?;
        self.bound.bind(id, class.clone(), None);
        Ok(())
    }

    /// rtParameterHandle.
    pub(crate) fn parameter_handle(&mut self, name: Option<&CStr>) -> Result<u32> {
        self.outside_block()?;
        let name = not_null(name)?;
        let class = self.bound.class_id().ok_or(Error::InvalidOperation)?;
        let loaded = self.classes.get(class).ok_or(Error::InvalidOperation)?;
        let mut parameters = loaded.parameters.iter();
        let parameter = parameters.position(|p| p.name.as_bytes() == name.to_bytes());
        let parameter = parameter.ok_or(Error::InvalidValue)?;
        Ok(self.classes.handle_of(Handle { class, parameter }))
    }

    /// rtGetShaderClassInfoLog.
    pub(crate) fn shader_class_info_log(&self) -> Result<&CStr> {
        self.outside_block()?;
        Ok(&self.classes.info_log)
    }
}
