// SPDX-License-Identifier: GPL-3.0-or-later
//! Which shaders light, see and surround the scene (rtUseLight, rtUseCamera, rtUseEnvironmentShader, ...).
//! Source: \[DWBS03\]. Invariant: the ids are of shaders of the right kind; a deleted one goes on working.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use crate::class::Kind;
use crate::context::Context;
use crate::error::{Error, Result};

/// The shaders in use beside those of surfaces.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Lights, in the order in which they were added; one may be there more than once.
    pub lights: Vec<u32>,
    /// The camera; the default one if none.
    pub camera: Option<u32>,
    /// The environment; black if none.
    pub environment: Option<u32>,
    /// How pictures are made; `Whitted` with the context's limits if none.
    pub rendering_object: Option<u32>,
}

impl Usage {
    /// All ids.
    pub fn ids(&self) -> impl Iterator<Item = u32> + '_ {
        let lights = self.lights.iter().copied();
        lights.chain(self.camera).chain(self.environment).chain(self.rendering_object)
    }
}

impl Context {
    /// The id itself if it is of a shader of this kind.
    fn shader_of_kind(&self, id: u32, kind: Kind) -> Result<u32> {
        self.outside_block()?;
        let shader = self.shaders.get(id).ok_or(Error::InvalidValue)?;
        if shader.kind() == kind { Ok(id) } else { Err(Error::InvalidOperation) }
    }

    /// rtUseLight.
    pub fn use_light(&mut self, id: u32) -> Result<()> {
        let id = self.shader_of_kind(id, Kind::Light)?;
        if self.usage.lights.contains(&id) {
            return Err(Error::InvalidOperation);
        }
        self.usage.lights.push(id);
        Ok(())
    }

    /// rtUseLightFast.
    pub fn use_light_fast(&mut self, id: u32) -> Result<()> {
        let id = self.shader_of_kind(id, Kind::Light)?;
        self.usage.lights.push(id);
        Ok(())
    }

    /// rtRemoveLight.
    pub fn remove_light(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        let before = self.usage.lights.len();
        self.usage.lights.retain(|&light| light != id);
        if self.usage.lights.len() < before { Ok(()) } else { Err(Error::InvalidValue) }
    }

    /// rtUseCamera.
    pub fn use_camera(&mut self, id: u32) -> Result<()> {
        self.usage.camera = Some(self.shader_of_kind(id, Kind::Camera)?);
        Ok(())
    }

    /// rtUseEnvironmentShader.
    pub fn use_environment_shader(&mut self, id: u32) -> Result<()> {
        self.usage.environment = Some(self.shader_of_kind(id, Kind::Environment)?);
        Ok(())
    }

    /// rtUseRenderingObject.
    pub fn use_rendering_object(&mut self, id: u32) -> Result<()> {
        self.usage.rendering_object = Some(self.shader_of_kind(id, Kind::RenderingObject)?);
        Ok(())
    }
}
