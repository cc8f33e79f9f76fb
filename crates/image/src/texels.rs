// SPDX-License-Identifier: GPL-3.0-or-later
//! Texels: the picture of a texture, in the form that its file had.
//! Source: original. Rows from the upper left texel on. Invariant: `data` holds `width * height` values, both at least 1.

/// Texels in rows, from the upper left one.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// The values.
    pub data: TexelData,
}

/// Texel values in the form that a file had, so that a picture takes no more memory than it must.
#[derive(Clone, Debug, PartialEq)]
pub enum TexelData {
    /// Red, green, blue as sRGB bytes and opacity as a linear byte.
    Srgb8(Vec<[u8; 4]>),
    /// Red, green, blue, opacity as linear bytes (roughness, metalness, OpenRT's byte textures).
    Linear8(Vec<[u8; 4]>),
    /// Linear floats, unclamped.
    Float(Vec<[f32; 4]>),
}

impl Texels {
    /// Bytes that the values take.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        match &self.data {
            TexelData::Srgb8(v) | TexelData::Linear8(v) => size_of_val(&v[..]),
            TexelData::Float(v) => size_of_val(&v[..]),
        }
    }
}
