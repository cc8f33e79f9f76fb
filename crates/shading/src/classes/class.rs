// SPDX-License-Identifier: GPL-3.0-or-later
//! The description of a shader class: name, kind, parameters with type, rate and default, and its
//! constructor.
//! Source: [DWBS03]; rates after the paper's Figure 1 (per shader, per triangle, per vertex).
//! Invariant: a value list has one value per parameter, in the class's order. Tests: `classes::tests`.

use std::sync::Arc;

use glam::Vec3;

use crate::shader::{
    AttributeRequest, CameraShader, EnvironmentShader, LightShader, PixelShader, SurfaceShader,
};
use crate::texture::TextureSampler;

/// The purpose of a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The appearance of a surface.
    Surface,
    /// Radiance of rays that hit nothing.
    Environment,
    /// A light.
    Light,
    /// A camera.
    Camera,
}

/// How often a parameter's value changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterRate {
    /// One value per shader.
    Shader,
    /// One value per triangle.
    Triangle,
    /// One value per vertex, interpolated between them.
    Vertex,
}

/// The type of a parameter's components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterType {
    /// Single-precision numbers.
    Float,
    /// The number of a texture; 0 = none, which is white.
    Texture,
    /// A single whole number.
    Int,
}

/// A parameter of a class.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// How often it changes.
    pub rate: ParameterRate,
    /// The type of its components.
    pub kind: ParameterType,
    /// How many numbers it has, 1 to 16.
    pub components: u32,
    /// Its value in a new shader: `components` numbers.
    pub default: &'static [f32],
}

impl Parameter {
    /// Numbers that every point of a shader shares.
    pub(super) const fn floats(name: &'static str, default: &'static [f32]) -> Self {
        let components = default.len() as u32;
        Self { name, rate: ParameterRate::Shader, kind: ParameterType::Float, components, default }
    }

    /// A texture that every point of a shader shares.
    pub(super) const fn texture(name: &'static str) -> Self {
        let (rate, kind) = (ParameterRate::Shader, ParameterType::Texture);
        Self { name, rate, kind, components: 1, default: &[0.0] }
    }

    /// A whole number that every point of a shader shares; `default` holds just one.
    pub(super) const fn int(name: &'static str, default: &'static [f32]) -> Self {
        let (rate, kind) = (ParameterRate::Shader, ParameterType::Int);
        Self { name, rate, kind, components: 1, default }
    }

    /// The same parameter with another rate.
    pub(super) const fn at(self, rate: ParameterRate) -> Self {
        Self { rate, ..self }
    }

    /// The mesh attribute that supplies this parameter's values.
    pub(super) fn request(&self) -> AttributeRequest {
        AttributeRequest {
            name: self.name.to_owned(),
            components: self.components,
            default: self.default.to_vec(),
        }
    }
}

/// The value of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Numbers.
    Floats(Vec<f32>),
    /// A texture, or none.
    Texture(Option<Arc<TextureSampler>>),
    /// A whole number.
    Int(i32),
}

/// The values of all parameters of a shader; those of other rates than per shader are ignored.
#[derive(Clone, Debug, Default)]
pub struct Values(pub Vec<Value>);

impl Values {
    /// Number `parameter` as a single float; 0 if it is none.
    pub(super) fn float(&self, parameter: usize) -> f32 {
        match self.0.get(parameter) {
            Some(Value::Floats(v)) => v.first().copied().unwrap_or(0.0),
            _ => 0.0,
        }
    }

    /// Number `parameter` as three floats; 0 where there are fewer.
    pub(super) fn vec3(&self, parameter: usize) -> Vec3 {
        match self.0.get(parameter) {
            Some(Value::Floats(v)) if v.len() >= 3 => Vec3::from_slice(v),
            _ => Vec3::ZERO,
        }
    }

    /// Number `parameter` as a whole number; 0 if it is none.
    pub(super) fn int(&self, parameter: usize) -> i32 {
        match self.0.get(parameter) {
            Some(Value::Int(value)) => *value,
            _ => 0,
        }
    }

    /// Number `parameter` as a texture.
    pub(super) fn texture(&self, parameter: usize) -> Option<Arc<TextureSampler>> {
        match self.0.get(parameter) {
            Some(Value::Texture(texture)) => texture.clone(),
            _ => None,
        }
    }
}

/// A shader of any kind.
#[derive(Clone)]
pub enum Shader {
    /// The appearance of a surface.
    Surface(Arc<dyn SurfaceShader>),
    /// Radiance of rays that hit nothing.
    Environment(Arc<dyn EnvironmentShader>),
    /// A light.
    Light(Arc<dyn LightShader>),
    /// A camera.
    Camera(Arc<dyn CameraShader>),
    /// Colours of pixels.
    Pixel(Arc<dyn PixelShader>),
}

/// A class of shaders.
pub struct ShaderClass {
    /// Its name.
    pub name: &'static str,
    /// The purpose of its shaders.
    pub kind: Kind,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Makes a shader from values.
    pub(super) make: fn(&Values) -> Shader,
}

impl ShaderClass {
    /// A shader with these values.
    #[must_use]
    pub fn make(&self, values: &Values) -> Shader {
        (self.make)(values)
    }

    /// The values of a new shader.
    #[must_use]
    pub fn defaults(&self) -> Values {
        let value = |parameter: &Parameter| match parameter.kind {
            ParameterType::Float => Value::Floats(parameter.default.to_vec()),
            ParameterType::Texture => Value::Texture(None),
            ParameterType::Int => Value::Int(parameter.default.first().map_or(0, |&x| x as i32)),
        };
        Values(self.parameters.iter().map(value).collect())
    }
}
