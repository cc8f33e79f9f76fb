// SPDX-License-Identifier: GPL-3.0-or-later
//! `MatteShader`: a Lambertian reflector with shadows, as scene files have it: radiance is E color / pi.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | color | 0.8 0.8 0.8 | share of light that is scattered, times the colour of the vertices |
//! | texture | texture 0 | multiplied to it |
//!
//! Source: see `materials/matte.rs`. Tests: `materials::tests`.

use std::sync::Arc;

use super::class::{Kind, Parameter, Shader, ShaderClass, Values};
use crate::materials::{Matte, TexturedColor};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "MatteShader",
    kind: Kind::Surface,
    parameters: &[Parameter::floats("color", &[0.8; 3]), Parameter::texture("texture")],
    make: |values| Shader::Surface(Arc::new(Matte { albedo: textured(values, 0, 1) })),
};

/// A colour times a texture, from two parameters.
pub(super) fn textured(values: &Values, color: usize, texture: usize) -> TexturedColor {
    TexturedColor {
        texture: values.texture(texture).as_deref().cloned(),
        ..TexturedColor::constant(values.vec3(color))
    }
}
