// SPDX-License-Identifier: GPL-3.0-or-later
//! `MetallicRoughnessShader`: glTF's metal and plastic.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | baseColor | 0.8 0.8 0.8 | colour of plastic, of metal's reflections |
//! | metallic | 0 | 0 = plastic, 1 = metal |
//! | roughness | 0.5 | 0 = smooth, 1 = rough |
//! | ior | 1.5 | index of refraction of the plastic's surface |
//! | baseColorTexture | texture 0 | multiplied to the colour |
//! | metallicRoughnessTexture | texture 0 | green times roughness, blue times metallic |
//! | normalTexture | texture 0 | normals, 2 texel - 1; none if 0 |
//! | normalScale | 1 | multiplied to their two components along the surface |
//!
//! Source: see `materials/metallic_roughness.rs`. Proof: `materials::tests`.

use std::sync::Arc;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use super::matte::textured;
use crate::materials::{Layers, MetallicRoughness, NormalMap};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "MetallicRoughnessShader",
    kind: Kind::Surface,
    parameters: &[
        Parameter::floats("baseColor", &[0.8; 3]),
        Parameter::floats("metallic", &[0.0]),
        Parameter::floats("roughness", &[0.5]),
        Parameter::floats("ior", &[1.5]),
        Parameter::texture("baseColorTexture"),
        Parameter::texture("metallicRoughnessTexture"),
        Parameter::texture("normalTexture"),
        Parameter::floats("normalScale", &[1.0]),
    ],
    make: |values| {
        let scale = values.float(7);
        Shader::Surface(Arc::new(MetallicRoughness {
            base_color: textured(values, 0, 4),
            metallic: values.float(1).clamp(0.0, 1.0),
            roughness: values.float(2).clamp(0.0, 1.0),
            ior: values.float(3).max(1.0),
            metallic_roughness_texture: values.texture(5).as_deref().cloned(),
            normal_map: values.texture(6).map(|texture| NormalMap { texture: (*texture).clone(), scale }),
            layers: Layers::default(),
        }))
    },
};
