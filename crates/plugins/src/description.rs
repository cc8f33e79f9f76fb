// SPDX-License-Identifier: GPL-3.0-or-later
//! The description of a shader class, wherever its code is: kind, and parameters with type, rate and default.
//! Source: \[DWBS03\]; [SIP06], Figure 1, for rates. Invariant: a class keeps the number and order of its
//! parameters.
//! Tests: bindings/openrt/tests/c/scene.c, bindings/openrt/tests/plugins.rs.

use gnurt::shading::classes::{self, ParameterRate, ParameterType, ShaderClass};

use crate::data_type::DataType;

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
    /// How a picture is made.
    RenderingObject,
}

impl From<classes::Kind> for Kind {
    fn from(kind: classes::Kind) -> Self {
        match kind {
            classes::Kind::Surface => Self::Surface,
            classes::Kind::Environment => Self::Environment,
            classes::Kind::Light => Self::Light,
            classes::Kind::Camera => Self::Camera,
        }
    }
}

/// A parameter of a class.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// How often it changes.
    pub rate: ParameterRate,
    /// The type of its components.
    pub kind: DataType,
    /// How many of them.
    pub count: usize,
    /// Its default if it varies, or belongs to a class without a block: `count` numbers.
    pub default: Vec<f32>,
}

impl Parameter {
    /// The parameters of a built-in class.
    #[must_use]
    pub fn of_built_in(class: &ShaderClass) -> Vec<Self> {
        class.parameters.iter().map(built_in).collect()
    }
}

fn built_in(p: &classes::Parameter) -> Parameter {
    let kind = match p.kind {
        ParameterType::Float => DataType::F32,
        ParameterType::Texture | ParameterType::Int => DataType::I32,
    };
    let (count, default) = (p.components as usize, p.default.to_vec());
    Parameter { name: p.name.to_owned(), rate: p.rate, kind, count, default }
}
