// SPDX-License-Identifier: GPL-3.0-or-later
//! `ConstantShader`: a surface that shows one colour, lit or not.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | value | shader | 1 1 1 | radiance |
//!
//! Source: original, name and parameter as OpenRT programs know them. Proof: `tests::shows_its_value`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{RadianceShader, SurfaceShader, Tracer};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "ConstantShader",
    kind: Kind::Surface,
    parameters: &[Parameter::floats("value", &[1.0; 3])],
    make: |values| Shader::Surface(Arc::new(Constant { value: values.vec3(0) })),
};

struct Constant {
    value: Vec3,
}

impl RadianceShader for Constant {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        out.reset(hits.len(), self.value);
    }
}

impl SurfaceShader for Constant {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::super::probe::{Probe, floor, shade};
    use super::*;

    #[test]
    fn shows_its_value() {
        let shader = Constant { value: Vec3::new(0.1, 2.0, 0.3) };
        assert_eq!(
            shade(&shader, &mut Probe::dark(), &floor()),
            Vec3::new(0.1, 2.0, 0.3),
            "unlit, unclamped"
        );
    }
}
