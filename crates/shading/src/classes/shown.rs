// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces of classes that only define their appearance: their scattering is unknown to integrators.
//! Tests: `tests` of the classes.

use std::sync::Arc;

use super::class::Shader;
use crate::shader::{AttributeRequest, RadianceShader, SurfaceShader};

/// A surface that only defines its appearance.
pub(super) struct Shown<S> {
    pub(super) shader: S,
    /// The attributes that it requests from meshes, in the order of its parameters.
    pub(super) attributes: Vec<AttributeRequest>,
}

impl<S: RadianceShader> SurfaceShader for Shown<S> {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(&self.shader)
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.attributes
    }
}

/// The shader of a class whose surfaces are [`Shown`].
pub(super) fn shown(shader: impl RadianceShader + 'static, attributes: Vec<AttributeRequest>) -> Shader {
    Shader::Surface(Arc::new(Shown { shader, attributes }))
}
