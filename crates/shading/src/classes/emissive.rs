// SPDX-License-Identifier: GPL-3.0-or-later
//! `EmissiveShader`: a surface that gives off light on its front, the side of its geometric normal, and scatters some.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | radiance | 1 1 1 | radiance that leaves its front |
//! | texture | texture 0 | multiplied to it |
//! | color | 0 0 0 | share of light that is scattered, on both sides |
//!
//! It is a light: all integrators sample it.
//! Source: see `materials/material.rs`. Tests: `materials::tests`.

use std::sync::Arc;

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::materials::{Emission, Material, Matte, TexturedColor};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "EmissiveShader",
    kind: Kind::Surface,
    parameters: &[
        Parameter::floats("radiance", &[1.0; 3]),
        Parameter::texture("texture"),
        Parameter::floats("color", &[0.0; 3]),
    ],
    make: |values| {
        let emission =
            Emission { texture: values.texture(1).as_deref().cloned(), ..Emission::constant(values.vec3(0)) };
        let surface = Arc::new(Matte { albedo: TexturedColor::constant(values.vec3(2)) });
        Shader::Surface(Arc::new(Material {
            surface,
            emission: Some(emission),
            coverage: None,
            bump: None,
            attributes: Vec::new(),
        }))
    },
};
