// SPDX-License-Identifier: GPL-3.0-or-later
//! `SpotLightShader`: a light at a point, which emits to all sides.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | radiance | shader | 1 1 1 | irradiance at distance 1; falls with the square of the distance |
//! | position | shader | 0 0 1 | where it is |
//!
//! Source: name and parameters as OpenRT programs know them. Tests: `tests` of `lights/punctual.rs`.

use std::sync::Arc;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::lights::PointLight;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "SpotLightShader",
    kind: Kind::Light,
    parameters: &[Parameter::floats("radiance", &[1.0; 3]), Parameter::floats("position", &[0.0, 0.0, 1.0])],
    make: |values| Shader::Light(Arc::new(PointLight::new(values.vec3(1), values.vec3(0)))),
};
