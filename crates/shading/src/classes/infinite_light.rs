// SPDX-License-Identifier: GPL-3.0-or-later
//! `InfiniteLightShader`: a light infinitely far away.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | radiance | shader | 1 1 1 | irradiance |
//! | direction | shader | 0 0 1 | towards the light, any length but zero |
//!
//! Source: name and parameters as OpenRT programs know them. Tests: `tests::comes_from_one_side`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::batch::Vec3s;
use crate::shader::{LightBatch, LightShader};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "InfiniteLightShader",
    kind: Kind::Light,
    parameters: &[Parameter::floats("radiance", &[1.0; 3]), Parameter::floats("direction", &[0.0, 0.0, 1.0])],
    make: |values| {
        let (radiance, dir) = (values.vec3(0), values.vec3(1).try_normalize());
        Shader::Light(Arc::new(InfiniteLight { radiance, dir }))
    },
};

struct InfiniteLight {
    radiance: Vec3,
    /// Unit, towards the light; `None` if the given direction was zero: then the light is dark.
    dir: Option<Vec3>,
}

impl LightShader for InfiniteLight {
    fn illuminate(&self, p: &Vec3s, _: &Vec3s, _: &[[f32; 2]], out: &mut LightBatch) {
        let Some(dir) = self.dir else { return };
        out.dir.reset(p.len(), dir);
        out.radiance.reset(p.len(), self.radiance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_from_one_side() {
        let illuminate = |dir| {
            let p = Vec3s::splat(1, Vec3::splat(9.0));
            let mut out = LightBatch::default();
            out.reset(1);
            InfiniteLight { radiance: Vec3::ONE, dir }.illuminate(&p, &p, &[[0.0; 2]], &mut out);
            (out.dir.get(0), out.dist[0], out.radiance.get(0))
        };
        assert_eq!(illuminate(Some(Vec3::X)), (Vec3::X, f32::INFINITY, Vec3::ONE), "from x, infinitely far");
        assert_eq!(illuminate(None).2, Vec3::ZERO, "from nowhere comes nothing");
    }
}
