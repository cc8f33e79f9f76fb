// SPDX-License-Identifier: GPL-3.0-or-later
//! `ConstantEnvironmentShader`: the same colour on all sides.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | value | shader | 1 1 1 | radiance |
//!
//! Source: original. Proof: `tests::is_the_same_on_all_sides`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::batch::Vec3s;
use crate::shader::EnvironmentShader;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "ConstantEnvironmentShader",
    kind: Kind::Environment,
    parameters: &[Parameter::floats("value", &[1.0; 3])],
    make: |values| Shader::Environment(Arc::new(ConstantEnvironment { value: values.vec3(0) })),
};

struct ConstantEnvironment {
    value: Vec3,
}

impl EnvironmentShader for ConstantEnvironment {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        out.reset(dir.len(), self.value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_same_on_all_sides() {
        let mut out = Vec3s::default();
        ConstantEnvironment { value: Vec3::Z }.miss(&Vec3s::splat(2, Vec3::X), &mut out);
        assert_eq!(out, Vec3s::splat(2, Vec3::Z), "two lanes of the value");
    }
}
