// SPDX-License-Identifier: GPL-3.0-or-later
//! `ConstantShader`: a surface that shows one colour, lit or not.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | value | shader | 1 1 1 | radiance |
//!
//! Source: name and parameter as OpenRT programs know them. Tests: `tests::shows_its_value`.

use glam::Vec3;

use super::class::{Kind, Parameter, ShaderClass};
use super::shown::shown;
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{RadianceShader, Tracer};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "ConstantShader",
    kind: Kind::Surface,
    parameters: &[Parameter::floats("value", &[1.0; 3])],
    make: |values| shown(Constant { value: values.vec3(0) }, Vec::new()),
};

struct Constant {
    value: Vec3,
}

impl RadianceShader for Constant {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        out.reset(hits.len(), self.value);
    }
}

#[cfg(test)]
mod tests {
    use super::super::probe::{Probe, floor, shade};
    use super::super::shown::Shown;
    use super::*;

    #[test]
    fn shows_its_value() {
        let shader = Shown { shader: Constant { value: Vec3::new(0.1, 2.0, 0.3) }, attributes: Vec::new() };
        assert_eq!(
            shade(&shader, &mut Probe::dark(), &floor()),
            Vec3::new(0.1, 2.0, 0.3),
            "unlit, unclamped"
        );
    }
}
