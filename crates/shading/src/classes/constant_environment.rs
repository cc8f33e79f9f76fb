// SPDX-License-Identifier: GPL-3.0-or-later
//! `ConstantEnvironmentShader`: the same colour on all sides.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | value | shader | 1 1 1 | radiance |
//!
//! Tests: `tests` of `lights/environment.rs`.

use std::sync::Arc;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::lights::ConstantEnvironment;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "ConstantEnvironmentShader",
    kind: Kind::Environment,
    parameters: &[Parameter::floats("value", &[1.0; 3])],
    make: |values| Shader::Environment(Arc::new(ConstantEnvironment { radiance: values.vec3(0) })),
};
