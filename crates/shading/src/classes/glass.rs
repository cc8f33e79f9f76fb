// SPDX-License-Identifier: GPL-3.0-or-later
//! `GlassShader`: smooth glass, mirrored and refracted by Fresnel's shares; normals point out of it.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | ior | 1.5 | index of refraction inside over outside |
//! | reflectance | 1 1 1 | tint of reflection |
//! | transmittance | 1 1 1 | tint of transmission |
//! | attenuationColor | 1 1 1 | transmittance of white light over the distance |
//! | attenuationDistance | 0 | world units; 0 = nothing is absorbed |
//! | dispersion | 0 | 20 over Abbe's number; 0 = all colours are bent alike |
//!
//! Source: see `materials/dielectric.rs`. Tests: `materials::tests`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, Shader, ShaderClass, Values};
use crate::materials::Dielectric;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "GlassShader",
    kind: Kind::Surface,
    parameters: &[
        Parameter::floats("ior", &[1.5]),
        Parameter::floats("reflectance", &[1.0; 3]),
        Parameter::floats("transmittance", &[1.0; 3]),
        Parameter::floats("attenuationColor", &[1.0; 3]),
        Parameter::floats("attenuationDistance", &[0.0]),
        Parameter::floats("dispersion", &[0.0]),
    ],
    make: |values| {
        let ior = values.float(0);
        // An index that means nothing bends nothing.
        let ior = if ior > 0.0 && ior.is_finite() { ior } else { 1.0 };
        let (absorption, spread) = inside(values, 3, ior);
        Shader::Surface(Arc::new(Dielectric {
            ior,
            reflectance: values.vec3(1),
            transmittance: values.vec3(2),
            absorption,
            spread,
        }))
    },
};

/// Absorption and spread of indices by parameters from `first` on: `attenuationColor`, `attenuationDistance`, `dispersion`.
pub(super) fn inside(values: &Values, first: usize, ior: f32) -> (Vec3, f32) {
    let (color, distance, dispersion) =
        (values.vec3(first), values.float(first + 1), values.float(first + 2));
    let absorption = -color.clamp(Vec3::splat(1e-6), Vec3::ONE).map(f32::ln) / distance;
    let absorption =
        if distance > 0.0 && absorption.is_finite() { absorption.max(Vec3::ZERO) } else { Vec3::ZERO };
    let spread = (ior.max(1.0 / ior) - 1.0) * dispersion / 20.0;
    (absorption, if spread > 0.0 && spread.is_finite() { spread } else { 0.0 })
}
