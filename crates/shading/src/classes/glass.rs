// SPDX-License-Identifier: GPL-3.0-or-later
//! `GlassShader`: smooth glass, mirrored and refracted by Fresnel's shares; normals point out of it.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | ior | 1.5 | index of refraction inside over outside |
//! | reflectance | 1 1 1 | tint of what is mirrored |
//! | transmittance | 1 1 1 | tint of what goes through |
//!
//! Source: see `materials/dielectric.rs`. Proof: `materials::tests`.

use std::sync::Arc;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::materials::Dielectric;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "GlassShader",
    kind: Kind::Surface,
    parameters: &[
        Parameter::floats("ior", &[1.5]),
        Parameter::floats("reflectance", &[1.0; 3]),
        Parameter::floats("transmittance", &[1.0; 3]),
    ],
    make: |values| {
        let ior = values.float(0);
        Shader::Surface(Arc::new(Dielectric {
            // An index that means nothing bends nothing.
            ior: if ior > 0.0 && ior.is_finite() { ior } else { 1.0 },
            reflectance: values.vec3(1),
            transmittance: values.vec3(2),
        }))
    },
};
