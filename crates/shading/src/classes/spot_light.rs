// SPDX-License-Identifier: GPL-3.0-or-later
//! `SpotLightShader`: a light at a point, shining to all sides.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | radiance | shader | 1 1 1 | what arrives at distance 1; falls with the square of the distance |
//! | position | shader | 0 0 1 | where it is |
//!
//! Source: original, name and parameters as OpenRT programs know them. Proof: `tests::falls_with_the_square`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::batch::Vec3s;
use crate::shader::{LightBatch, LightShader};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "SpotLightShader",
    kind: Kind::Light,
    parameters: &[Parameter::floats("radiance", &[1.0; 3]), Parameter::floats("position", &[0.0, 0.0, 1.0])],
    make: |values| Shader::Light(Arc::new(SpotLight { radiance: values.vec3(0), position: values.vec3(1) })),
};

struct SpotLight {
    radiance: Vec3,
    position: Vec3,
}

impl LightShader for SpotLight {
    fn illuminate(&self, p: &Vec3s, _: &Vec3s, _: &[[f32; 2]], out: &mut LightBatch) {
        for i in 0..p.len() {
            let to_light = self.position - p.get(i);
            let distance = to_light.length();
            // A point at the light's place is not lit: it has no direction.
            if distance > 0.0 && distance.is_finite() {
                out.dir.set(i, to_light / distance);
                out.dist[i] = distance;
                out.radiance.set(i, self.radiance / (distance * distance));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn falls_with_the_square() {
        let light = SpotLight { radiance: Vec3::splat(8.0), position: Vec3::new(0.0, 2.0, 0.0) };
        let p = Vec3s { x: vec![0.0, 0.0], y: vec![0.0, 2.0], z: vec![0.0, 0.0] };
        let mut out = LightBatch::default();
        out.reset(2);
        light.illuminate(&p, &p, &[[0.0; 2]; 2], &mut out);
        assert_eq!(out.radiance.get(0), Vec3::splat(2.0), "8 / 2^2");
        assert_eq!((out.dir.get(0), out.dist[0]), (Vec3::Y, 2.0), "straight up");
        assert_eq!(out.radiance.get(1), Vec3::ZERO, "not at its own place");
    }
}
