// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of shaders whose code is not a plugin's. Tests: tests/c/scene.c.

/// The per-shader value of a parameter; parameters of other rates keep their default here.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ParameterValue {
    /// Numbers.
    Floats(Vec<f32>),
    /// An integer; as a texture, 0, a negative or an unknown one is white.
    Integer(i32),
    /// A text; without a value the shader's default.
    Text(Option<String>),
}
