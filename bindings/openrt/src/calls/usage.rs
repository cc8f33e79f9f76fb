// SPDX-License-Identifier: GPL-3.0-or-later
//! Which shaders light, see and surround the scene (rtUseLight, rtUseCamera, rtUseEnvironmentShader, ...).
//! Source: \[DWBS03\]. Tests: tests/c/scene.c, tests/c/errors.c.

use gnurt_plugins::host::Kind;

use crate::context::Context;
use crate::state::class::ClassCode;
use crate::state::error::{Error, Result};

impl Context {
    /// The id itself if it is of a shader of this kind.
    fn shader_of_kind(&self, id: u32, kind: Kind) -> Result<u32> {
        self.outside_block()?;
        let shader = self.shaders.get(id).ok_or(Error::InvalidValue)?;
        if shader.kind() == kind { Ok(id) } else { Err(Error::InvalidOperation) }
    }

    /// rtUseLight.
    pub(crate) fn use_light(&mut self, id: u32) -> Result<()> {
        let id = self.shader_of_kind(id, Kind::Light)?;
        if self.usage.lights.contains(&id) {
            return Err(Error::InvalidOperation);
        }
        self.usage.lights.push(id);
        Ok(())
    }

    /// rtUseLightFast.
    pub(crate) fn use_light_fast(&mut self, id: u32) -> Result<()> {
        let id = self.shader_of_kind(id, Kind::Light)?;
        self.usage.lights.push(id);
        Ok(())
    }

    /// rtRemoveLight.
    pub(crate) fn remove_light(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        let before = self.usage.lights.len();
        self.usage.lights.retain(|&light| light != id);
        if self.usage.lights.len() < before { Ok(()) } else { Err(Error::InvalidValue) }
    }

    /// rtUseCamera.
    pub(crate) fn use_camera(&mut self, id: u32) -> Result<()> {
        self.usage.camera = Some(self.shader_of_kind(id, Kind::Camera)?);
        Ok(())
    }

    /// rtUseEnvironmentShader.
    pub(crate) fn use_environment_shader(&mut self, id: u32) -> Result<()> {
        self.usage.environment = Some(self.shader_of_kind(id, Kind::Environment)?);
        Ok(())
    }

    /// rtUseRenderingObject. One in the shading language computes the colours of pixels; the integrator
    /// stays.
    pub(crate) fn use_rendering_object(&mut self, id: u32) -> Result<()> {
        let id = self.shader_of_kind(id, Kind::RenderingObject)?;
        let is_script =
            self.shaders.get(id).is_some_and(|shader| matches!(shader.class.code, ClassCode::Script(_)));
        *(if is_script { &mut self.usage.pixel } else { &mut self.usage.rendering_object }) = Some(id);
        Ok(())
    }
}
