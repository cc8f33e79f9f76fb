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
//! | transmission | 0 | share of the plastic's body that is glass |
//! | thickness | 0 | 0 = that glass is a pane; else it has an inside |
//! | attenuationColor | 1 1 1 | transmittance of white light over the distance |
//! | attenuationDistance | 0 | world units; 0 = nothing is absorbed |
//! | dispersion | 0 | 20 over Abbe's number; 0 = all colours are bent alike |
//! | anisotropy | 0 | how much rougher microfacets are along one direction, 0 to 1 |
//! | anisotropyRotation | 0 | that direction, counter-clockwise from where u grows, radians |
//! | anisotropyTexture | texture 0 | red and green the direction, blue times anisotropy |
//! | iridescence | 0 | share of the surface that a thin film is on |
//! | iridescenceIor | 1.3 | its index of refraction |
//! | iridescenceThickness | 400 | nanometres |
//! | diffuseTransmission | 0 | share of the body's light that goes through |
//! | diffuseTransmissionColor | 1 1 1 | its colour |
//!
//! Source: see `materials/metallic_roughness.rs`. Tests: `materials::tests`.

use std::sync::Arc;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use super::glass::inside;
use super::matte::textured;
use glam::Vec3;

use crate::bsdf::{Film, Principled};
use crate::materials::{Anisotropy, MetallicRoughness, NormalMap};

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
        Parameter::floats("transmission", &[0.0]),
        Parameter::floats("thickness", &[0.0]),
        Parameter::floats("attenuationColor", &[1.0; 3]),
        Parameter::floats("attenuationDistance", &[0.0]),
        Parameter::floats("dispersion", &[0.0]),
        Parameter::floats("anisotropy", &[0.0]),
        Parameter::floats("anisotropyRotation", &[0.0]),
        Parameter::texture("anisotropyTexture"),
        Parameter::floats("iridescence", &[0.0]),
        Parameter::floats("iridescenceIor", &[1.3]),
        Parameter::floats("iridescenceThickness", &[400.0]),
        Parameter::floats("diffuseTransmission", &[0.0]),
        Parameter::floats("diffuseTransmissionColor", &[1.0; 3]),
    ],
    make: |values| {
        let (scale, ior) = (values.float(7), values.float(3).max(1.0));
        let (absorption, spread) = inside(values, 10, ior);
        let share = |parameter| values.float(parameter).clamp(0.0, 1.0);
        Shader::Surface(Arc::new(MetallicRoughness {
            base_color: textured(values, 0, 4),
            metallic: values.float(1).clamp(0.0, 1.0),
            roughness: values.float(2).clamp(0.0, 1.0),
            ior,
            metallic_roughness_texture: values.texture(5).as_deref().cloned(),
            normal_map: values.texture(6).map(|texture| NormalMap { texture: (*texture).clone(), scale }),
            model: Principled {
                transmission: share(8),
                thin: values.float(9) <= 0.0,
                spread,
                film: Film {
                    share: share(16),
                    ior: values.float(17).max(1.0),
                    thickness: values.float(18).max(0.0),
                },
                translucence: share(19),
                beyond: values.vec3(20).clamp(Vec3::ZERO, Vec3::ONE),
                ..Principled::new(Vec3::ONE, 0.0, 1.0, ior)
            },
            anisotropy: Anisotropy {
                strength: share(13),
                rotation: values.float(14),
                texture: values.texture(15).as_deref().cloned(),
            },
            absorption,
            layers: None,
        }))
    },
};
